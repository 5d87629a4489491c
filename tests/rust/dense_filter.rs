//! The navigator against a dense reference filter: the same mechanization, and 15x15 covariances in
//! textbook form.

use std::path::PathBuf;

use footnav::config::FilterConfig;
use footnav::decide_all;
use footnav::detectors::Decision;
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

/// Zero-velocity updates with correlated errors only, without gate and other aids.
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

/// Reference filter: F P Fᵀ + Q, batched in swing, and the update in Joseph form.
struct DenseFilter {
    strapdown: Strapdown,
    estimate: Estimate,
    /// Covariance before the pending steps.
    covariance: Dense,
    pending: Option<PendingSteps>,
    previous: ImuSample,
    increments: Increments,
    /// Time since the last zero-velocity update, s.
    time_since_zupt: f64,
    /// Variance to be added to the position in the next step, m².
    pending_position_variance: f64,
}

/// Steps over which the covariance has not been propagated.
#[derive(Clone, Copy)]
struct PendingSteps {
    steps: f64,
    total: StrapdownStep,
    noise: Dense,
}

impl PendingSteps {
    /// Composition of the two: the sums of the increments, and the noise of the first propagated
    /// over the second.
    fn compose(&self, next: &Self) -> Self {
        let (first, second) = (&self.total, &next.total);
        let dt = first.dt + second.dt;
        let total = StrapdownStep {
            dt,
            velocity_increment_n: first.velocity_increment_n + second.velocity_increment_n,
            attitude: (first.dt * first.attitude + second.dt * second.attitude) / dt,
        };
        let phi = shear(POSITION, VELOCITY, Matrix3::from_diagonal_element(second.dt));
        Self {
            steps: self.steps + next.steps,
            total,
            noise: phi * self.noise * phi.transpose() + next.noise,
        }
    }

    fn predict(&self, covariance: &Dense) -> Dense {
        let f = transition(&self.total);
        f * covariance * f.transpose() + self.noise
    }
}

impl DenseFilter {
    /// Covariance after all steps.
    fn covariance(&self) -> Dense {
        self.pending.map_or(self.covariance, |pending| pending.predict(&self.covariance))
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
            noise[(i, i)] += self.pending_position_variance;
        }
        let stance = decision.stationary && step.velocity_increment_n.z > 0.0;
        let newest = PendingSteps { steps: 1.0, total: step, noise };
        let pending = self.pending.take().map_or(newest, |pending| pending.compose(&newest));
        let batch_size = config.filter.covariance_interval / self.strapdown.nominal_interval;
        if !stance && pending.steps < batch_size.round() {
            self.pending = Some(pending);
        } else {
            self.covariance = pending.predict(&self.covariance);
        }
        if stance {
            self.update_zero_velocity(config.filter.zero_velocity_std.powi(2));
            (self.time_since_zupt, self.pending_position_variance) = (0.0, 0.0);
        } else {
            self.propagate_zupt_error(config, step.dt);
        }
    }

    /// Propagates the velocity error correlated with the last zero-velocity update.
    fn propagate_zupt_error(&mut self, config: &Config, dt: f64) {
        let position_variance = |time: f64| {
            (config.filter.zupt_correlation * config.filter.zero_velocity_std * time).powi(2)
        };
        self.pending_position_variance =
            position_variance(self.time_since_zupt + dt) - position_variance(self.time_since_zupt);
        self.time_since_zupt += dt;
    }

    fn update_zero_velocity(&mut self, variance: f64) {
        let mut h = SMatrix::<f64, 3, STATES>::zeros();
        h.fixed_columns_mut::<3>(VELOCITY).fill_with_identity();
        let (p, r) = (self.covariance, Matrix3::from_diagonal_element(variance));
        let k = p * h.transpose() * (h * p * h.transpose() + r).try_inverse().unwrap();
        let i_kh = Dense::identity() - k * h;
        self.covariance = i_kh * p * i_kh.transpose() + k * r * k.transpose();
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

/// Transition matrix: half of the position step before and half after the velocity step, then the
/// attitude step.
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

/// Covariance intervals: each step separately, the default, and a longer one, s.
const INTERVALS: [f64; 3] = [0.0, 0.02, 0.07];

/// Compares both filters over a recording; the dense one is initialized from the navigator at the
/// third row.
fn assert_dense_filter_agrees(samples: &[ImuSample], rate: f64, covariance_interval: f64) {
    let config = config(covariance_interval);
    let decisions = decide_all(&config, rate, samples).unwrap();
    let mut navigator = Navigator::new(config.clone(), rate).unwrap();
    let latency = navigator.latency();
    let (mut rows, mut compared) = (0, 0);
    let mut dense: Option<DenseFilter> = None;
    for newest in 0..samples.len() {
        let before = navigator.latest().map(|solution| solution.estimate);
        if navigator.push(&samples[newest]).unwrap().is_none() {
            continue;
        }
        let Some(covariance) = navigator.covariance() else { continue };
        let (index, estimate) = (newest - latency, navigator.latest().unwrap().estimate);
        rows += 1;
        if rows <= 3 {
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
                pending: None,
                previous,
                increments,
                time_since_zupt: 0.0,
                pending_position_variance: 0.0,
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
        let difference = (estimate.nav.position - dense.estimate.nav.position).norm();
        assert!(difference < 1e-9, "row {index}: positions differ by {difference:e} m");
        compared += 1;
    }
    assert!(compared > samples.len() / 2, "{compared} rows of {}", samples.len());
}

#[test]
fn navigator_equals_the_dense_filter_on_a_simulated_walk() {
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
fn navigator_equals_the_dense_filter_on_a_recorded_walk() {
    let Some(samples) = recording() else { return };
    for interval in INTERVALS {
        assert_dense_filter_agrees(&samples, 100.0, interval);
    }
}
