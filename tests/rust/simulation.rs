//! The simulation: consistency with the mechanization, reproducibility, and plausible kinematics.

use footnav::error::ConfigError;
use footnav::ins::earth;
use footnav::ins::strapdown::{Increments, MechanizationKind};
use footnav::simulation::{
    Gait, Route, SensorErrors, SimulationSettings, TriadErrors, Walk, Waypoint, corrupt, rest,
    simulate,
};
use footnav::types::nav_state::NavState;
use nalgebra::Vector3;
use serde::Serialize;
use serde::de::DeserializeOwned;

const KINDS: [MechanizationKind; 3] =
    [MechanizationKind::TwoSample, MechanizationKind::SingleSample, MechanizationKind::FirstOrder];

fn ideal(route: &Route, gait: &Gait, settings: &SimulationSettings) -> Walk {
    simulate(route, gait, &SensorErrors::ideal(), settings).unwrap()
}

fn short(errors: &SensorErrors, seed: u64) -> Walk {
    let settings = SimulationSettings { seed, ..SimulationSettings::default() };
    simulate(&Route::straight(4.0), &Gait::walk(), errors, &settings).unwrap()
}

fn replay(walk: &Walk, settings: &SimulationSettings) -> Vec<NavState> {
    let strapdown = settings.strapdown();
    let (dt, first) = (strapdown.nominal_interval, walk.samples[0]);
    let mut before =
        Increments { dt, angle: dt * first.angular_rate, velocity: dt * first.specific_force };
    let mut state = walk.truth[0];
    let mut states = vec![state];
    for pair in walk.samples.windows(2) {
        let now = strapdown.increments(&pair[0], &pair[1]);
        strapdown.advance(&mut state, &before, &now);
        states.push(state);
        before = now;
    }
    states
}

fn assert_replays(walk: &Walk, settings: &SimulationSettings) {
    for (state, truth) in replay(walk, settings).iter().zip(&walk.truth) {
        let turn = (state.attitude.inverse() * truth.attitude).imag().norm();
        assert!((state.time - truth.time).abs() < 1e-9);
        assert!((state.position - truth.position).norm() < 1e-9, "{settings:?} at {}", truth.time);
        assert!((state.velocity - truth.velocity).norm() < 1e-9, "{settings:?} at {}", truth.time);
        assert!(turn < 1e-9, "{settings:?} at {}: {turn}", truth.time);
    }
}

fn all_settings() -> impl Iterator<Item = SimulationSettings> {
    let earth_rates = [Vector3::zeros(), earth::rotation_rate(0.8)];
    KINDS.into_iter().flat_map(move |kind| {
        earth_rates.map(|earth_rate| SimulationSettings {
            kind,
            earth_rate,
            rate_hz: 50.0,
            jitter: 0.2,
            ..SimulationSettings::default()
        })
    })
}

#[test]
fn strapdown_reproduces_the_truth_over_minutes() {
    let gait = Gait { mounting: Vector3::new(0.4, -2.0, 1.1), ..Gait::walk() };
    for settings in all_settings().filter(|settings| settings.earth_rate != Vector3::zeros()) {
        let walk = ideal(&Route::figure_of_eight(130.0), &gait, &settings);
        assert!(walk.truth[walk.truth.len() - 1].time > 105.0);
        assert_replays(&walk, &settings);
    }
}

#[test]
fn strapdown_reproduces_the_truth_for_every_mounting_and_gait() {
    let mountings =
        [[0.0; 3], [std::f64::consts::PI, 0.0, 0.0], [0.0, -1.57, 0.0], [0.3, 0.2, 3.0]];
    for settings in all_settings() {
        for (gait, mounting) in
            [Gait::walk(), Gait::slow(), Gait::run(), Gait::walk()].into_iter().zip(mountings)
        {
            let gait = Gait { mounting: mounting.into(), ..gait };
            assert_replays(&ideal(&Route::out_and_back(4.0), &gait, &settings), &settings);
        }
    }
}

/// A route with a lift ride down: four metres to the lift, then back at the lower level.
fn down_a_lift() -> Route {
    let waypoint =
        |position: [f64; 3], lift| Waypoint { position: position.into(), lift, tread: false };
    Route {
        waypoints: vec![
            waypoint([0.0; 3], false),
            waypoint([4.0, 0.0, 0.0], false),
            waypoint([4.0, 0.0, -5.0], true),
            waypoint([1.0, 0.0, -5.0], false),
        ],
    }
}

#[test]
fn strapdown_reproduces_the_truth_through_a_lift_ride() {
    for settings in all_settings() {
        assert_replays(&ideal(&down_a_lift(), &Gait::walk(), &settings), &settings);
    }
}

#[test]
fn moving_lift_is_not_stance() {
    let walk = ideal(
        &down_a_lift(),
        &Gait { tremor: 0.0, ..Gait::walk() },
        &SimulationSettings::default(),
    );
    let ridden: Vec<_> =
        walk.truth.iter().zip(&walk.stance).filter(|(state, _)| state.velocity.z < -0.99).collect();
    assert!(ridden.len() > 100, "{} samples at the full speed of the lift", ridden.len());
    assert!(ridden.iter().all(|(state, stance)| !**stance && state.velocity.xy().norm() < 1e-9));
    let end = walk.truth[walk.truth.len() - 1].position;
    assert!((end - Vector3::new(1.0, 0.0, -5.0)).norm() < 2e-3, "{end}");
}

#[test]
fn mounting_rotates_the_readings_and_not_the_motion() {
    let settings = SimulationSettings {
        kind: MechanizationKind::SingleSample,
        ..SimulationSettings::default()
    };
    let turned = Gait { mounting: Vector3::new(0.5, 1.0, -0.7), ..Gait::walk() };
    let (plain, walk) = (
        ideal(&Route::straight(5.0), &Gait::walk(), &settings),
        ideal(&Route::straight(5.0), &turned, &settings),
    );
    for (k, (reference, sample)) in plain.samples.iter().zip(&walk.samples).enumerate() {
        assert!(
            (turned.sensor_to_foot() * sample.specific_force - reference.specific_force).norm()
                < 1e-9
        );
        assert!(
            (turned.sensor_to_foot() * sample.angular_rate - reference.angular_rate).norm() < 1e-9
        );
        assert!((walk.truth[k].position - plain.truth[k].position).norm() < 1e-9);
    }
}

#[test]
fn walk_ends_at_the_end_of_the_route() {
    let walks = [
        (Gait::run(), Route::straight(12.0), [12.0, 0.0, 0.0]),
        (Gait::walk(), Route::square(3.0), [0.0; 3]),
        (Gait::run(), Route::figure_of_eight(20.0), [0.0; 3]),
        (Gait::walk(), Route::stairs(2, 9, 0.17, 0.28), [0.0, 1.2, 3.06]),
        (
            Gait::slow(),
            Route::from_waypoints(&[[1.0, 2.0, 0.0], [3.0, 2.0, 0.4], [3.0, 6.0, 0.4]]),
            [2.0, 4.0, 0.4],
        ),
    ];
    for (gait, route, end) in walks {
        let gait = Gait { tremor: 0.0, ..gait };
        let walk = ideal(&route, &gait, &SimulationSettings::default());
        let last = walk.truth[walk.truth.len() - 1];
        let end = Vector3::from(end);
        assert!((last.position - end).norm() < 2e-3, "{} {end}", last.position);
        assert!(last.velocity.norm() < 1e-9);
    }
}

#[test]
fn static_sensor_measures_gravity_and_earth_rate() {
    let earth_rate = earth::rotation_rate(0.8);
    let settings = SimulationSettings { earth_rate, ..SimulationSettings::default() };
    let gait = Gait { tremor: 0.0, mounting: Vector3::new(1.0, 0.5, 0.2), ..Gait::walk() };
    let walk = ideal(&Route::straight(3.0), &gait, &settings);
    for (sample, truth) in walk.samples.iter().zip(&walk.truth).take(100) {
        // Half an interval of Earth rotation tilts gravity by 3.6e-7 rad.
        assert!(
            (truth.attitude * sample.specific_force - settings.gravity * Vector3::z()).norm()
                < 4e-6
        );
        assert!((truth.attitude * sample.angular_rate - earth_rate).norm() < 1e-9);
    }
}

#[test]
fn peak_rates_and_specific_forces_are_plausible() {
    let settings = SimulationSettings { rate_hz: 200.0, ..SimulationSettings::default() };
    for (gait, rates, forces) in
        [(Gait::walk(), 5.0..10.0, 20.0..60.0), (Gait::run(), 7.0..14.0, 60.0..130.0)]
    {
        let walk = ideal(&Route::straight(15.0), &gait, &settings);
        let rate = walk.samples.iter().map(|sample| sample.angular_rate.norm()).fold(0.0, f64::max);
        let force =
            walk.samples.iter().map(|sample| sample.specific_force.norm()).fold(0.0, f64::max);
        assert!(rates.contains(&rate), "{rate} rad/s");
        assert!(forces.contains(&force), "{force} m/s^2");
    }
}

#[test]
fn foot_is_nearly_static_in_stance_and_fast_in_swing() {
    for gait in [Gait::walk(), Gait::slow(), Gait::run()] {
        let walk = ideal(&Route::straight(8.0), &gait, &SimulationSettings::default());
        let speeds = |stance: bool| {
            let chosen =
                walk.truth.iter().zip(&walk.stance).filter(move |(_, flat)| **flat == stance);
            chosen.map(|(truth, _)| truth.velocity.norm()).collect::<Vec<_>>()
        };
        let (still, moving) = (speeds(true), speeds(false));
        assert!(still.iter().all(|&speed| speed < 0.1));
        assert!(still.iter().any(|&speed| speed > 0.001), "the foot is never perfectly static");
        assert!(moving.iter().any(|&speed| speed > 1.5));
    }
}

#[test]
fn walk_is_determined_by_the_seed() {
    let errors = SensorErrors::mpu6050();
    assert_eq!(short(&errors, 7), short(&errors, 7));
    assert_ne!(short(&errors, 7).truth, short(&errors, 8).truth);
}

#[test]
fn sensor_errors_do_not_change_the_walk() {
    let (ideal, real) = (short(&SensorErrors::ideal(), 3), short(&SensorErrors::mpu6050(), 3));
    assert_eq!(ideal.truth, real.truth);
    assert_eq!(ideal.stance, real.stance);
    assert_ne!(ideal.samples, real.samples);
}

#[test]
fn true_biases_equal_those_of_the_samples() {
    let gyro = TriadErrors { bias_std: 0.02, bias_walk: 0.001, ..TriadErrors::default() };
    let accel = TriadErrors {
        bias: Vector3::new(0.1, 0.0, -0.2),
        bias_walk: 0.01,
        ..TriadErrors::default()
    };
    let (truth, walk) = (
        short(&SensorErrors::ideal(), 1),
        short(&SensorErrors { gyro, accel, ..SensorErrors::ideal() }, 1),
    );
    for (k, (read, sample)) in walk.samples.iter().zip(&truth.samples).enumerate() {
        assert!((read.angular_rate - sample.angular_rate - walk.gyro_bias[k]).norm() < 1e-12);
        assert!((read.specific_force - sample.specific_force - walk.accel_bias[k]).norm() < 1e-12);
    }
    assert_eq!(walk.accel_bias[0], accel.bias);
    assert_ne!(walk.accel_bias[100], accel.bias);
}

#[test]
fn mpu6050_readings_are_integer_counts_within_range() {
    let walk = short(&SensorErrors::mpu6050(), 2);
    let count = 9.806_65 / 4096.0;
    for value in walk
        .samples
        .iter()
        .flat_map(|sample| sample.specific_force.iter().copied().collect::<Vec<_>>())
    {
        assert!((value / count - (value / count).round()).abs() < 1e-6);
        assert!(value.abs() <= 8.0 * 9.806_65 + 1e-9);
    }
}

#[test]
fn stamps_have_the_configured_jitter() {
    let settings =
        SimulationSettings { jitter: 0.2, rate_hz: 50.0, ..SimulationSettings::default() };
    let walk = ideal(&Route::straight(3.0), &Gait::walk(), &settings);
    let intervals: Vec<f64> =
        walk.samples.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
    assert!(intervals.iter().all(|dt| (0.012 - 1e-12..=0.028 + 1e-12).contains(dt)));
    assert!(intervals.iter().any(|dt| (dt - 0.02).abs() > 0.003));
}

#[test]
fn invalid_parameters_are_errors_that_name_the_parameter() {
    let (route, gait, errors, settings) =
        (Route::default(), Gait::default(), SensorErrors::ideal(), SimulationSettings::default());
    let negative = TriadErrors { noise_density: -1.0, ..TriadErrors::default() };
    let flawed_gait = Gait { stride_length: -1.0, ..gait.clone() };
    let flawed_errors = SensorErrors { gyro: negative, ..errors };
    let flawed_settings = SimulationSettings { rate_hz: f64::NAN, ..settings };
    for (result, name) in [
        (
            simulate(&Route::from_waypoints(&[[0.0; 3]]), &gait, &errors, &settings),
            "route.waypoints",
        ),
        (simulate(&Route::straight(0.0), &gait, &errors, &settings), "route.waypoints"),
        (simulate(&Route::straight(f64::NAN), &gait, &errors, &settings), "route.waypoints"),
        (simulate(&route, &flawed_gait, &errors, &settings), "gait.stride_length"),
        (simulate(&route, &gait, &flawed_errors, &settings), "sensor.gyro.noise_density"),
        (simulate(&route, &gait, &errors, &flawed_settings), "simulation.rate_hz"),
    ] {
        assert!(
            matches!(result, Err(ConfigError::OutOfRange { key, .. }) if key == name),
            "{name}"
        );
    }
}

#[test]
fn presets_are_valid_and_unknown_names_are_errors() {
    for name in Gait::PRESETS {
        Gait::preset(name).unwrap().validate().unwrap();
    }
    for name in SensorErrors::PRESETS {
        SensorErrors::preset(name).unwrap().validate().unwrap();
    }
    assert!(matches!(Gait::preset("hop"), Err(ConfigError::UnknownPreset { .. })));
    assert!(matches!(SensorErrors::preset("hop"), Err(ConfigError::UnknownPreset { .. })));
}

fn assert_round_trips_through_toml<
    T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug,
>(
    value: &T,
) {
    let text = toml::to_string(value).unwrap();
    assert_eq!(&toml::from_str::<T>(&text).unwrap(), value);
    assert!(toml::from_str::<T>("no_such_key = 1").is_err());
}

#[test]
fn parameters_round_trip_through_toml_and_unknown_keys_are_errors() {
    assert_round_trips_through_toml(&Gait::run());
    assert_round_trips_through_toml(&SensorErrors::stim300());
    assert_round_trips_through_toml(&SimulationSettings::default());
    assert_round_trips_through_toml(&Route::stairs(1, 4, 0.17, 0.28));
    assert_eq!(toml::from_str::<Gait>("").unwrap(), Gait::walk());
}

#[test]
fn rest_measures_gravity_plus_sensor_errors() {
    let settings =
        SimulationSettings { rate_hz: 50.0, jitter: 0.1, seed: 4, ..SimulationSettings::default() };
    let still = rest(2.0, &SensorErrors::ideal(), &settings).unwrap();
    assert_eq!(still.len(), 101);
    assert!(
        still
            .iter()
            .all(|sample| sample.specific_force == Vector3::new(0.0, 0.0, settings.gravity))
    );
    assert!(still.iter().all(|sample| sample.angular_rate == Vector3::zeros()));
    let noisy = rest(2.0, &SensorErrors::mpu6050(), &settings).unwrap();
    assert!(noisy.iter().zip(&still).all(|(noisy, still)| (noisy.time - still.time).abs() < 1e-12));
    assert_ne!(noisy[0].angular_rate, noisy[1].angular_rate);
    for duration in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            rest(duration, &SensorErrors::ideal(), &settings),
            Err(ConfigError::OutOfRange { key: "duration", .. })
        ));
    }
}

#[test]
fn corrupted_ideal_walk_equals_the_walk_of_the_sensor() {
    let (clean, dirty) = (short(&SensorErrors::ideal(), 5), short(&SensorErrors::mpu6050(), 5));
    let readings = corrupt(&clean.samples, &SensorErrors::mpu6050(), 5).unwrap();
    assert_eq!(readings.len(), dirty.samples.len());
    for (reading, sample) in readings.iter().zip(&dirty.samples) {
        assert!(
            (reading.specific_force - sample.specific_force).norm() < 3e-3,
            "one least significant bit at most"
        );
        assert!(
            (reading.angular_rate - sample.angular_rate).norm() < 1e-3,
            "one least significant bit at most"
        );
    }
}

#[test]
fn corrupt_rejects_equal_stamps() {
    let sample = short(&SensorErrors::ideal(), 5).samples[0];
    let message = corrupt(&[sample, sample], &SensorErrors::mpu6050(), 5).unwrap_err().to_string();
    assert!(message.starts_with("samples 0 s apart"), "{message}");
}
