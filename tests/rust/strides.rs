//! Strides and their covariance, as a Rust program meets them.

use footnav::config::{CorrectionKind, SmootherKind};
use footnav::detectors::Scripted;
use footnav::math::rotation::about_up;
use footnav::simulation::{
    Gait, Route, SensorErrors, SimulationSettings, TriadErrors, Walk, simulate,
};
use footnav::types::rate::sample_rate;
use footnav::{Batch, Config, ImuSample, Navigator, Stride, Trajectory, track};
use nalgebra::Vector4;
use proptest::prelude::*;

const RATE: f64 = 100.0;

fn walk(sensor: &SensorErrors, gait: &Gait, seed: u64) -> Walk {
    let settings = SimulationSettings { rate_hz: RATE, seed, ..SimulationSettings::default() };
    simulate(&Route::square(4.0), gait, sensor, &settings).unwrap()
}

fn samples(seed: u64) -> Vec<ImuSample> {
    walk(&SensorErrors::mpu6050(), &Gait::walk(), seed).samples
}

fn with_strides() -> Config {
    let mut config = Config::default();
    config.output.strides = true;
    config
}

fn in_batch(samples: &[ImuSample], config: &Config) -> (Trajectory, Vec<Stride>) {
    let mut batch = Batch::new(config.clone(), sample_rate(samples).unwrap()).unwrap();
    batch.push_block(samples).unwrap();
    let (trajectory, _, strides) = batch.finish().unwrap();
    (trajectory, strides)
}

fn in_blocks(samples: &[ImuSample], config: &Config, cuts: &[usize]) -> Vec<Stride> {
    let mut navigator = Navigator::new(config.clone(), RATE).unwrap();
    let mut ends: Vec<usize> =
        cuts.iter().map(|cut| cut % samples.len()).chain([samples.len()]).collect();
    ends.sort_unstable();
    let (mut start, mut strides) = (0, Vec::new());
    for end in ends {
        navigator.push_block(&samples[start..end]).unwrap();
        strides.extend(navigator.strides().unwrap());
        start = end;
    }
    navigator.flush().unwrap();
    strides.extend(navigator.strides().unwrap());
    strides
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_stream_hands_out_the_strides_of_the_batch_to_the_bit(
        cuts in prop::collection::vec(0usize..3000, 0..9), seed in 0u64..2, longest_step in prop::option::of(0.1..4.0),
    ) {
        let (samples, mut config) = (samples(seed), with_strides());
        if let Some(longest_step) = longest_step {
            config.smoother.kind = SmootherKind::Stepwise;
            config.smoother.longest_step = longest_step;
        }
        let (_, strides) = in_batch(&samples, &config);
        prop_assert!(strides.len() >= 12);
        prop_assert_eq!(in_blocks(&samples, &config, &cuts), strides);
    }
}

#[test]
fn keeping_the_strides_changes_no_number_of_the_track() {
    let samples = samples(1);
    let (trajectory, _) = track(&samples, &Config::default()).unwrap();
    assert_eq!(in_batch(&samples, &with_strides()).0, trajectory);
    assert_eq!(in_batch(&samples, &Config::default()).1, []);
}

#[test]
fn strides_without_the_setting_are_an_error_that_names_it() {
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    let error = navigator.strides().unwrap_err().to_string();
    assert_eq!(error, "strides are not tracked: set output.strides = true");
}

#[test]
fn strides_go_from_row_to_row_of_the_track_that_comes_out() {
    let samples = samples(2);
    let mut step_by_step = with_strides();
    step_by_step.filter.covariance_interval = 0.0;
    let (plain, found) = in_batch(&samples, &step_by_step);
    let kinds = [
        (SmootherKind::Rts, CorrectionKind::None),
        (SmootherKind::Stepwise, CorrectionKind::None),
        (SmootherKind::None, CorrectionKind::LinearlyWeighted),
        (SmootherKind::None, CorrectionKind::ResidualVelocity),
    ];
    for (smoother, correction) in kinds {
        let mut config = step_by_step.clone();
        config.smoother.kind = smoother;
        config.correction.kind = correction;
        let (trajectory, strides) = in_batch(&samples, &config);
        assert_ne!(trajectory.position, plain.position);
        for (stride, filters) in strides.iter().zip(&found) {
            assert_eq!((stride.start_row, stride.end_row), (filters.start_row, filters.end_row));
            assert_eq!(stride.covariance, filters.covariance);
            let way = |axis: usize| {
                trajectory.position[stride.end_row][axis]
                    - trajectory.position[stride.start_row][axis]
            };
            assert_eq!(stride.displacement, nalgebra::Vector3::from_fn(|axis, _| way(axis)));
        }
        assert_eq!(strides.len(), found.len());
    }
}

#[test]
fn a_stride_is_known_a_tenth_of_a_second_after_its_stance_or_half_a_second_into_it() {
    let samples = samples(1);
    let mut navigator = Navigator::new(with_strides(), RATE).unwrap();
    let mut known = 0;
    for sample in &samples {
        navigator.push(sample).unwrap();
        for stride in navigator.strides().unwrap() {
            let delay = navigator.latest().unwrap().estimate.nav.time - stride.end;
            assert!((0.0..0.62).contains(&delay), "{delay} s");
            known += 1;
        }
    }
    assert!(known >= 12);
}

/// A gait whose foot stands perfectly still.
fn still() -> Gait {
    Gait { tremor: 0.0, stance_roll: 0.0, impact: 0.0, ..Gait::walk() }
}

/// White noise and constant biases, and the settings of a filter that knows how large they are.
fn matched() -> (SensorErrors, Config) {
    let (accel_density, gyro_density, accel_bias) = (2e-3, 1e-3, 0.01);
    let sensor = SensorErrors {
        accel: TriadErrors {
            noise_density: accel_density,
            bias_std: accel_bias,
            ..TriadErrors::default()
        },
        gyro: TriadErrors { noise_density: gyro_density, bias_std: 0.01, ..TriadErrors::default() },
        ..SensorErrors::ideal()
    };
    let mut config = with_strides();
    config.sensor.accel_noise_density = accel_density;
    config.sensor.gyro_noise_density = gyro_density;
    config.sensor.accel_bias_std = accel_bias;
    config.sensor.accel_bias_walk = 0.0;
    config.sensor.gyro_bias_walk = 0.0;
    config.alignment.gyro_bias_std = gyro_density / config.alignment.duration.sqrt();
    config.alignment.tilt_std = accel_density / config.alignment.duration.sqrt() / config.gravity();
    config.filter.specific_force_noise = 0.0;
    config.filter.angular_rate_noise = 0.0;
    config.filter.zero_velocity_std = 1e-5;
    config.filter.zupt_lever_std = 0.0;
    config.filter.contact_rate = 0.0;
    config.filter.zero_angular_rate = false;
    (sensor, config)
}

/// Error of a stride (truth minus estimate) in its own frame: displacement and change of heading.
fn error(stride: &Stride, walk: &Walk, trajectory: &Trajectory) -> Vector4<f64> {
    let heading_error = |row: usize| {
        let [x, y, z, w] = trajectory.quaternion[row];
        let estimate =
            nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        (walk.truth[row].attitude * estimate.inverse()).scaled_axis().z
    };
    let (at_start, at_end) = (heading_error(stride.start_row), heading_error(stride.end_row));
    let way = walk.truth[stride.end_row].position - walk.truth[stride.start_row].position;
    let heading = stride.start_heading;
    let wrong = about_up(-heading - at_start) * way - about_up(-heading) * stride.displacement;
    wrong.push(at_end - at_start)
}

#[test]
fn errors_of_the_strides_are_as_large_as_their_covariance_says() {
    let (sensor, config) = matched();
    let (mut sum, mut count) = (0.0, 0.0);
    let mut by_state = Vector4::zeros();
    for seed in 0..40 {
        let walk = walk(&sensor, &still(), seed);
        let rests = walk.truth.iter().map(|state| state.velocity.norm() < 1e-9).collect();
        let mut batch =
            Batch::with_detector(config.clone(), RATE, Box::new(Scripted::new(rests))).unwrap();
        batch.push_block(&walk.samples).unwrap();
        let (trajectory, _, strides) = batch.finish().unwrap();
        for stride in &strides {
            let (wrong, covariance) =
                (error(stride, &walk, &trajectory), stride.covariance.unwrap());
            sum += wrong.dot(&(covariance.try_inverse().unwrap() * wrong));
            by_state += wrong.component_mul(&wrong).component_div(&covariance.diagonal());
            count += 1.0;
        }
    }
    let (nees, by_state) = (sum / count / 4.0, by_state / count);
    println!("NEES {nees:.3} over {count} strides; {by_state:.3}");
    assert!(count > 400.0, "{count}");
    // The mean of four times 400 squares of independent normal numbers is within 0.11 of 1 at three
    // sigmas.
    assert!((nees - 1.0).abs() < 0.11, "{nees}, {by_state}");
}
