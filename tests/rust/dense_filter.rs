//! The navigator against a plain dense filter: the same mechanization, and covariances of 15x15 as
//! the textbook writes them.

use std::path::PathBuf;

use footnav::config::FilterConfig;
use footnav::detectors::Decision;
use footnav::detectors::decide_all;
use footnav::ins::strapdown::{Increments, MechanizationKind, Strapdown, StrapdownStep};
use footnav::math::rotation::{cross_matrix, exp};
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};
use footnav::types::solution::Estimate;
use footnav::{Config, ImuSample, Navigator};
use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};

const STATES: usize = 15;
const POSITION: usize = 0;
const VELOCITY: usize = 3;
const ATTITUDE: usize = 6;
const GYRO_BIAS: usize = 9;
const ACCEL_BIAS: usize = 12;

type Dense = SMatrix<f64, STATES, STATES>;

/// A zero velocity of known variance whenever the detector says so, of which the foot takes a part
/// along, and nothing else.
fn config(covariance_interval: f64) -> Config {
    let filter = FilterConfig {
        covariance_interval,
        zupt_lever_std: 0.0,
        zupt_correlation: 0.7,
        contact_rate: 0.0,
        chi2_gate: f64::MAX,
        zero_angular_rate: false,
        ..FilterConfig::default()
    };
    Config { filter, ..Config::default() }
}

/// F P Fᵀ + Q, over several steps at once in the swing, and the update in Joseph's form.
struct DenseFilter {
    strapdown: Strapdown,
    estimate: Estimate,
    /// As it was before the steps that wait.
    covariance: Dense,
    waiting: Option<DelayLine>,
    previous: ImuSample,
    increments: Increments,
    /// Time since the last zero velocity, s.
    gone_for: f64,
    /// Variance that the position gains with the next step, m².
    strayed: f64,
}

/// Steps that the covariance has still to be carried over.
#[derive(Clone, Copy)]
struct DelayLine {
    steps: f64,
    together: StrapdownStep,
    noise: Dense,
}

impl DelayLine {
    /// One after the other: the sums of what they turn errors into, and the noise of the first as
    /// it is at the end of the second.
    fn then(&self, next: &Self) -> Self {
        let (first, second) = (&self.together, &next.together);
        let dt = first.dt + second.dt;
        let together = StrapdownStep {
            dt,
            velocity_increment_n: first.velocity_increment_n + second.velocity_increment_n,
            attitude: (first.dt * first.attitude + second.dt * second.attitude) / dt,
        };
        let on = shear(POSITION, VELOCITY, Matrix3::from_diagonal_element(second.dt));
        Self {
            steps: self.steps + next.steps,
            together,
            noise: on * self.noise * on.transpose() + next.noise,
        }
    }

    fn predict(&self, covariance: &Dense) -> Dense {
        let f = transition(&self.together);
        f * covariance * f.transpose() + self.noise
    }
}

impl DenseFilter {
    /// The covariance after all steps.
    fn covariance(&self) -> Dense {
        self.waiting.map_or(self.covariance, |waiting| waiting.predict(&self.covariance))
    }

    fn step(&mut self, config: &Config, sample: &ImuSample, decision: &Decision) {
        let Estimate { nav, gyro_bias, accel_bias } = &mut self.estimate;
        let [previous, current] =
            [&self.previous, sample].map(|sample| sample.without_bias(gyro_bias, accel_bias));
        let now = self.strapdown.increments(&previous, &current);
        let step = self.strapdown.advance(nav, &self.increments, &now);
        (self.previous, self.increments) = (*sample, now);
        let mut noise = noise(config, step.dt);
        for i in POSITION..VELOCITY {
            noise[(i, i)] += self.strayed;
        }
        let stands = decision.stationary && step.velocity_increment_n.z > 0.0;
        let newest = DelayLine { steps: 1.0, together: step, noise };
        let waiting = self.waiting.take().map_or(newest, |waiting| waiting.then(&newest));
        let at_once = config.filter.covariance_interval / self.strapdown.nominal_interval;
        if !stands && waiting.steps < at_once.round() {
            self.waiting = Some(waiting);
        } else {
            self.covariance = waiting.predict(&self.covariance);
        }
        if stands {
            self.observe_rest(config.filter.zero_velocity_std.powi(2));
            (self.gone_for, self.strayed) = (0.0, 0.0);
        } else {
            self.go_on(config, step.dt);
        }
    }

    /// A foot that was faster in its stance than the filter believes goes on at that speed.
    fn go_on(&mut self, config: &Config, dt: f64) {
        let strayed = |time: f64| {
            (config.filter.zupt_correlation * config.filter.zero_velocity_std * time).powi(2)
        };
        self.strayed = strayed(self.gone_for + dt) - strayed(self.gone_for);
        self.gone_for += dt;
    }

    fn observe_rest(&mut self, variance: f64) {
        let mut h = SMatrix::<f64, 3, STATES>::zeros();
        h.fixed_columns_mut::<3>(VELOCITY).fill_with_identity();
        let (p, r) = (self.covariance, Matrix3::from_diagonal_element(variance));
        let k = p * h.transpose() * (h * p * h.transpose() + r).try_inverse().unwrap();
        let rest = Dense::identity() - k * h;
        self.covariance = rest * p * rest.transpose() + k * r * k.transpose();
        self.correct(&(-k * self.estimate.nav.velocity));
    }

    fn correct(&mut self, errors: &SVector<f64, STATES>) {
        let part = |first: usize| Vector3::from(errors.fixed_rows::<3>(first));
        self.estimate.nav.position += part(POSITION);
        self.estimate.nav.velocity += part(VELOCITY);
        let attitude = exp(&part(ATTITUDE)) * self.estimate.nav.attitude;
        self.estimate.nav.attitude = UnitQuaternion::new_normalize(attitude.into_inner());
        self.estimate.gyro_bias += part(GYRO_BIAS);
        self.estimate.accel_bias += part(ACCEL_BIAS);
    }
}

/// Position moves in two halves around the change of velocity, then the attitude turns.
fn transition(step: &StrapdownStep) -> Dense {
    let half = shear(POSITION, VELOCITY, Matrix3::from_diagonal_element(0.5 * step.dt));
    let tilt = shear(VELOCITY, ATTITUDE, -cross_matrix(&step.velocity_increment_n));
    let accel_bias = shear(VELOCITY, ACCEL_BIAS, -step.dt * step.attitude);
    let gyro_bias = shear(ATTITUDE, GYRO_BIAS, -step.dt * step.attitude);
    gyro_bias * half * accel_bias * tilt * half
}

fn shear(target: usize, source: usize, m: Matrix3<f64>) -> Dense {
    let mut shear = Dense::identity();
    shear.fixed_view_mut::<3, 3>(target, source).copy_from(&m);
    shear
}

fn noise(config: &Config, dt: f64) -> Dense {
    let (sensor, filter) = (&config.sensor, &config.filter);
    let mut variances = SVector::<f64, STATES>::zeros();
    let parts = [
        (VELOCITY, sensor.accel_noise_density.powi(2) + filter.specific_force_noise.powi(2)),
        (ATTITUDE, sensor.gyro_noise_density.powi(2) + filter.angular_rate_noise.powi(2)),
        (GYRO_BIAS, sensor.gyro_bias_walk.powi(2)),
        (ACCEL_BIAS, sensor.accel_bias_walk.powi(2)),
    ];
    for (first, density) in parts {
        variances.fixed_rows_mut::<3>(first).fill(density * dt);
    }
    Dense::from_diagonal(&variances)
}

/// One step after the other, as many at once as by default, and many.
const INTERVALS: [f64; 3] = [0.0, 0.02, 0.07];

/// Follows a recording with both filters; the dense one takes over three samples after the walk has
/// begun.
fn assert_dense_filter_agrees(samples: &[ImuSample], rate: f64, covariance_interval: f64) {
    let config = config(covariance_interval);
    let decisions = decide_all(&config, rate, samples).unwrap();
    let mut navigator = Navigator::new(config.clone(), rate).unwrap();
    let latency = navigator.latency();
    let (mut walking, mut compared) = (0, 0);
    let mut dense: Option<DenseFilter> = None;
    for newest in 0..samples.len() {
        let before = navigator.latest().map(|solution| solution.estimate);
        if navigator.push(&samples[newest]).unwrap().is_none() {
            continue;
        }
        let Some(covariance) = navigator.covariance() else { continue };
        let (index, estimate) = (newest - latency, navigator.latest().unwrap().estimate);
        walking += 1;
        if walking <= 3 {
            let strapdown = Strapdown {
                kind: MechanizationKind::TwoSample,
                gravity: config.gravity(),
                earth_rate: Vector3::zeros(),
                nominal_interval: 1.0 / rate,
            };
            let biases = before.unwrap();
            let unbiased =
                |index: usize| samples[index].without_bias(&biases.gyro_bias, &biases.accel_bias);
            let increments = strapdown.increments(&unbiased(index - 1), &unbiased(index));
            let (covariance, previous) = (covariance.dense(), samples[index]);
            dense = Some(DenseFilter {
                strapdown,
                estimate,
                covariance,
                waiting: None,
                previous,
                increments,
                gone_for: 0.0,
                strayed: 0.0,
            });
            continue;
        }
        let dense = dense.as_mut().unwrap();
        dense.step(&config, &samples[index], &decisions[index]);
        let expected = dense.covariance();
        let scale = expected.diagonal().map(f64::sqrt);
        let difference =
            (covariance.dense() - expected).component_div(&(scale * scale.transpose()));
        assert!(
            difference.amax() < 1e-9,
            "row {index}: covariances differ by {:e}",
            difference.amax()
        );
        let away = (estimate.nav.position - dense.estimate.nav.position).norm();
        assert!(away < 1e-9, "row {index}: positions differ by {away:e} m");
        compared += 1;
    }
    assert!(compared > samples.len() / 2, "{compared} rows of {}", samples.len());
}

#[test]
fn a_simulated_walk_is_that_of_a_dense_filter() {
    let settings = SimulationSettings { rate_hz: 200.0, seed: 3, ..SimulationSettings::default() };
    let walk = simulate(&Route::straight(10.0), &Gait::walk(), &SensorErrors::mpu6050(), &settings)
        .unwrap();
    for interval in INTERVALS {
        assert_dense_filter_agrees(&walk.samples, 200.0, interval);
    }
}

/// The left foot of an MPU6050 recording at 8 g and 1000 deg/s: ms, then counts.
fn recording() -> Option<Vec<ImuSample>> {
    let data = PathBuf::from(std::env::var_os("FOOTNAV_DATA")?);
    let text =
        std::fs::read_to_string(data.join("mpu6050/conf-2222-coleta02-22-06-21-10ds_05.csv"))
            .ok()?;
    let rows = text.lines().filter(|line| !line.trim().is_empty());
    let (accel, gyro) = (8.0 * 9.80665 / 32_768.0, 1_000.0_f64.to_radians() / 32_768.0);
    let sample = |line: &str| {
        let n: Vec<f64> = line.split(',').map(|count| count.trim().parse().unwrap()).collect();
        ImuSample::new(
            n[0] / 1e3,
            [n[1], n[2], n[3]].map(|c| c * accel),
            [n[4], n[5], n[6]].map(|c| c * gyro),
        )
    };
    Some(rows.map(sample).collect())
}

#[test]
fn a_recorded_walk_is_that_of_a_dense_filter() {
    let Some(samples) = recording() else { return };
    for interval in INTERVALS {
        assert_dense_filter_agrees(&samples, 100.0, interval);
    }
}
