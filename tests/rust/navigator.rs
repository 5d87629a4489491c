//! The public interface of the navigator.

use footnav::config::{AlignmentConfig, DetectorConfig, MagnitudeVarianceConfig, ShoeConfig};
use footnav::decide_all;
use footnav::detectors::Scripted;
use footnav::detectors::{Decision, Detector};
use footnav::ins::strapdown::MechanizationKind;
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, Walk, simulate};
use footnav::types::health::{Flags, Status};
use footnav::types::nav_state::NavState;
use footnav::{Config, DataError, Error, ImuSample, Navigator, Trajectory, track};
use nalgebra::Vector3;
use proptest::prelude::*;

const RATE: f64 = 100.0;

fn walk(sensor: &SensorErrors, seed: u64) -> Walk {
    let settings = SimulationSettings { rate_hz: RATE, seed, ..SimulationSettings::default() };
    simulate(&Route::straight(8.0), &Gait::walk(), sensor, &settings).unwrap()
}

fn in_blocks(samples: &[ImuSample], cuts: &[usize]) -> Trajectory {
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    let mut ends: Vec<usize> =
        cuts.iter().map(|cut| cut % samples.len()).chain([samples.len()]).collect();
    ends.sort_unstable();
    let mut trajectory = Trajectory::default();
    let mut start = 0;
    for end in ends {
        trajectory.append(navigator.push_block(&samples[start..end]).unwrap());
        start = end;
    }
    trajectory.append(navigator.flush().unwrap());
    trajectory
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn any_chunking_gives_the_batch_result_to_the_bit(
        cuts in prop::collection::vec(0usize..2000, 0..12), seed in 0u64..3,
    ) {
        let samples = walk(&SensorErrors::mpu6050(), seed).samples;
        let (batch, _) = track(&samples, &Config::default()).unwrap();
        prop_assert_eq!(in_blocks(&samples, &cuts), batch);
    }
}

#[test]
fn push_gives_one_solution_per_sample_at_a_fixed_latency() {
    let samples = walk(&SensorErrors::mpu6050(), 1).samples;
    let (batch, _) = track(&samples, &Config::default()).unwrap();
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    for (k, sample) in samples.iter().enumerate() {
        let solution = navigator.push(sample).unwrap();
        assert_eq!(solution.is_some(), k >= navigator.latency());
        if let Some(solution) = solution {
            let row = k - navigator.latency();
            let position = <[f64; 3]>::from(solution.estimate.nav.position);
            assert_eq!(position.map(f64::to_bits), batch.position[row].map(f64::to_bits));
            assert_eq!(solution.zero_velocity, batch.zero_velocity[row]);
        }
    }
    assert_eq!(batch.len(), samples.len());
}

#[test]
fn position_error_with_an_ideal_sensor_is_below_a_decimetre() {
    let max_errors = (0..8).map(|seed| {
        let Walk { samples, truth, .. } = walk(&SensorErrors::ideal(), seed);
        let (trajectory, health) = track(&samples, &Config::default()).unwrap();
        assert_eq!(health.flags.status(), Status::Ok);
        let error = |(state, position): (&NavState, &[f64; 3])| {
            (state.position - Vector3::from(*position)).norm()
        };
        truth.iter().zip(&trajectory.position).map(error).fold(0.0, f64::max)
    });
    let mean = max_errors.sum::<f64>() / 8.0;
    assert!(mean < 0.1, "{mean} m");
}

/// Every detector with its default settings, except for a wider gate of `magnitude-variance`, which
/// finds no stance in these data by default.
fn every_detector() -> Vec<DetectorConfig> {
    let with_gate = |detector| match detector {
        DetectorConfig::MagnitudeVariance(settings) => {
            DetectorConfig::MagnitudeVariance(MagnitudeVarianceConfig {
                magnitude_gate: 0.3,
                ..settings
            })
        }
        detector => detector,
    };
    DetectorConfig::all().into_iter().map(with_gate).collect()
}

#[test]
fn every_detector_gives_the_batch_result_to_the_bit_in_blocks_and_after_a_reset() {
    let samples = walk(&SensorErrors::mpu6050(), 1).samples;
    for detector in every_detector() {
        let config = Config { detector, ..Config::default() };
        let (batch, _) = track(&samples, &config).unwrap();
        let mut navigator = Navigator::new(config, RATE).unwrap();
        navigator.push_block(&samples[..700]).unwrap();
        navigator.reset();
        let mut states = Trajectory::default();
        for block in samples.chunks(37) {
            states.append(navigator.push_block(block).unwrap());
        }
        assert_eq!(states.len(), samples.len() - navigator.latency());
        states.append(navigator.flush().unwrap());
        assert_eq!(states, batch, "{:?}", navigator.latency());
    }
}

#[test]
fn scripted_decisions_give_the_batch_result() {
    let samples = walk(&SensorErrors::mpu6050(), 1).samples;
    let config = Config::default();
    let decisions = decide_all(&config, RATE, &samples).unwrap();
    let scripted = Scripted::new(decisions.iter().map(|decision| decision.stationary).collect());
    let mut navigator = Navigator::with_detector(config.clone(), RATE, Box::new(scripted)).unwrap();
    assert_eq!(navigator.latency(), 0);
    let (batch, _) = track(&samples, &config).unwrap();
    for _ in 0..2 {
        assert_eq!(navigator.push_block(&samples).unwrap(), batch);
        navigator.reset();
    }
}

#[test]
fn every_mechanization_and_detector_tracks_a_walk() {
    let Walk { samples, truth, .. } = walk(&SensorErrors::stim300(), 3);
    let end = truth.last().unwrap().position;
    let kinds = [
        MechanizationKind::TwoSample,
        MechanizationKind::SingleSample,
        MechanizationKind::FirstOrder,
    ];
    let detectors = every_detector();
    for kind in kinds {
        for detector in &detectors {
            let mut config = Config { detector: detector.clone(), ..Config::default() };
            config.mechanization.kind = kind;
            let (trajectory, _) = track(&samples, &config).unwrap();
            let [x, y, z] = *trajectory.position.last().unwrap();
            let error = (Vector3::new(x, y, z) - end).norm();
            assert!(error < 0.5, "{kind:?} {detector:?}: {error} m");
        }
    }
}

#[test]
fn invalid_sample_is_rejected_counted_and_bridged() {
    let samples = walk(&SensorErrors::mpu6050(), 2).samples;
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    navigator.push_block(&samples[..600]).unwrap();
    let mut broken = samples[600];
    broken.angular_rate.y = f64::NAN;
    let error = navigator.push(&broken).unwrap_err();
    assert!(
        matches!(error, Error::Data(DataError::NonFinite { index: 600, channel: "gyro_y", .. })),
        "{error}"
    );
    let error = navigator.push(&samples[10]).unwrap_err();
    assert!(matches!(error, Error::Data(DataError::TimeReversed { .. })), "{error}");
    let rest = navigator.push_block(&samples[603..]).unwrap();
    assert!(rest.flags.iter().any(|flags| flags.contains(Flags::REFUSED | Flags::GAP)));
    let counters = navigator.health().counters;
    assert_eq!((counters.refused, counters.gaps), (2, 1));
    let [x, ..] = *rest.position.last().unwrap();
    assert!((x - 8.0).abs() < 0.5, "{x}");
}

#[test]
fn position_std_covers_the_error_of_a_gap() {
    let mut beyond_three_sigma = 0;
    for seed in 0..20_u32 {
        let Walk { samples, truth, .. } = walk(&SensorErrors::ideal(), u64::from(seed));
        let start = 450 + 13 * seed as usize;
        for missing in [10, 25, 50] {
            let gappy: Vec<ImuSample> = [&samples[..start], &samples[start + missing..]].concat();
            let (trajectory, health) = track(&gappy, &Config::default()).unwrap();
            let (error, std) =
                (trajectory.position.last().unwrap(), trajectory.position_std.last().unwrap());
            let end = truth.last().unwrap().position;
            let sigmas = (end.x - error[0]).hypot(end.y - error[1]) / std[0].hypot(std[1]);
            beyond_three_sigma += usize::from(sigmas > 3.0);
            assert!(health.flags.contains(Flags::GAP));
        }
    }
    assert!(
        beyond_three_sigma <= 6,
        "{beyond_three_sigma} of 60 walks end more than three sigma away"
    );
}

#[test]
fn navigation_continues_after_a_gap_of_hours_with_status_invalid() {
    let samples = walk(&SensorErrors::mpu6050(), 1).samples;
    for hours in [0.001, 1.0, 10_000.0] {
        let mut gappy = samples.clone();
        for sample in &mut gappy[700..] {
            sample.time += 3600.0 * hours;
        }
        let (trajectory, health) = track(&gappy, &Config::default()).unwrap();
        let [x, y, z] = *trajectory.position.last().unwrap();
        assert!(x.hypot(y).hypot(z) < 20.0, "{x} {y} {z}");
        assert!(trajectory.position_std.last().unwrap()[0] > 1.5 * 3600.0 * hours);
        assert_eq!(health.flags.status(), Status::Invalid);
    }
}

#[test]
fn block_with_an_invalid_sample_leaves_the_navigator_unchanged() {
    let samples = walk(&SensorErrors::mpu6050(), 2).samples;
    let mut broken = samples.clone();
    broken[900].specific_force.z = f64::INFINITY;
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    let error = navigator.push_block(&broken).unwrap_err();
    assert!(error.to_string().starts_with("sample 900: accel_z is inf"), "{error}");
    let mut trajectory = navigator.push_block(&samples).unwrap();
    trajectory.append(navigator.flush().unwrap());
    assert_eq!(trajectory, track(&samples, &Config::default()).unwrap().0);
}

#[test]
fn push_after_flush_is_an_error_until_reset() {
    let samples = walk(&SensorErrors::mpu6050(), 2).samples;
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    let mut first = navigator.push_block(&samples).unwrap();
    first.append(navigator.flush().unwrap());
    assert_eq!(navigator.push(&samples[0]).unwrap_err(), DataError::AfterFlush.into());
    navigator.reset();
    let mut second = navigator.push_block(&samples).unwrap();
    second.append(navigator.flush().unwrap());
    assert_eq!(first, second);
}

#[test]
fn now_extrapolates_to_the_newest_sample() {
    let mut sensor = SensorErrors::stim300();
    sensor.gyro.range = None;
    let Walk { samples, truth, .. } = walk(&sensor, 4);
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    for (k, sample) in samples.iter().enumerate() {
        navigator.push(sample).unwrap();
        let now = navigator.now().unwrap().unwrap();
        assert_eq!(now.time.to_bits(), sample.time.to_bits());
        if k > 400 {
            let error = (now.position - truth[k].position).norm();
            assert!(error < 0.4, "{error} m at {} s", sample.time);
        }
    }
}

#[test]
fn recording_shorter_than_the_alignment_is_an_error() {
    let samples = walk(&SensorErrors::ideal(), 0).samples;
    let error = track(&samples[..50], &Config::default()).unwrap_err();
    assert!(error.to_string().starts_with("50 samples over 0.49 s are too few"), "{error}");
    for few in [0, 1] {
        let error = track(&samples[..few], &Config::default()).unwrap_err();
        assert!(matches!(error, Error::Data(DataError::TooShort { .. })), "{error}");
    }
}

#[test]
fn numerical_failure_is_a_persistent_error() {
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    let mut samples = walk(&SensorErrors::ideal(), 0).samples;
    for sample in &mut samples[300..] {
        sample.specific_force *= 1e200;
    }
    let error = samples.iter().find_map(|sample| navigator.push(sample).err()).unwrap();
    assert!(matches!(error, Error::Numerical(_)), "{error}");
    let last = ImuSample::new(1e3, [0.0, 0.0, 9.8], [0.0; 3]);
    assert_eq!(navigator.push(&last).unwrap_err().to_string(), error.to_string());
    assert_eq!(navigator.latest(), None);
    assert!(
        navigator.health().flags == Flags::LOST
            && navigator.health_of_walk().flags.contains(Flags::LOST)
    );
}

#[test]
fn alignment_failure_is_a_persistent_error() {
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    let in_g = |k: u32| ImuSample::new(f64::from(k) / RATE, [0.0, 0.0, 1.0], [0.0; 3]);
    let error = (0..400).find_map(|k| navigator.push(&in_g(k)).err()).unwrap();
    assert!(error.to_string().contains("it looks like g"), "{error}");
    assert_eq!(navigator.push(&in_g(1000)).unwrap_err(), error);
    navigator.reset();
    assert_eq!(navigator.push(&in_g(0)).unwrap(), None);
}

#[test]
fn custom_detector_can_be_used() {
    struct Never;
    impl Detector for Never {
        fn latency(&self) -> usize {
            0
        }
        fn push(&mut self, _: &ImuSample) -> Option<Decision> {
            Some(Decision { statistic: 1.0, threshold: 0.0, stationary: false })
        }
        fn drain(&mut self) -> Option<Decision> {
            None
        }
        fn reset(&mut self) {}
    }
    let samples = walk(&SensorErrors::mpu6050(), 0).samples;
    let mut navigator = Navigator::with_detector(Config::default(), RATE, Box::new(Never)).unwrap();
    let trajectory = navigator.push_block(&samples).unwrap();
    assert_eq!(trajectory.len(), samples.len());
    let health = navigator.health();
    assert_eq!(health.counters.updates.zero_velocity.accepted, 0);
    assert!(
        health.flags.contains(Flags::NO_ZERO_VELOCITY) && health.horizontal_std > 0.5,
        "{health:?}"
    );
}

#[test]
fn configuration_error_names_the_unknown_key() {
    let error = Config::from_toml("[filter]\nzero_velocity_sdt = 0.02\n").unwrap_err().to_string();
    assert!(error.contains("zero_velocity_sdt") && error.contains("zero_velocity_std"), "{error}");
    let error = Config::from_toml("[alignment]\nduration = -1.0\n").unwrap_err().to_string();
    assert_eq!(error, "alignment.duration = -1: expected a positive number");
    let config = Config::from_toml("[detector]\nkind = \"shoe\"\nthreshold = 500.0\n").unwrap();
    assert_eq!(
        config.detector,
        DetectorConfig::Shoe(ShoeConfig { threshold: 500.0, ..ShoeConfig::default() })
    );
    assert!(Config::from_toml("[detector]\nkind = \"shoe\"\nfactor = 2.0\n").is_err());
}

#[test]
fn initial_heading_rotates_the_track() {
    let samples = walk(&SensorErrors::ideal(), 0).samples;
    let alignment = AlignmentConfig { heading_deg: Some(0.0), ..AlignmentConfig::default() };
    let (trajectory, _) = track(&samples, &Config { alignment, ..Config::default() }).unwrap();
    let [east, north, _] = *trajectory.position.last().unwrap();
    assert!(east.abs() < 0.1 && (north - 8.0).abs() < 0.1, "{east} {north}");
}
