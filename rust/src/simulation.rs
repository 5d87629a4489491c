//! Simulation of a foot-mounted inertial sensor: samples and ground truth.
//!
//! The motion of the foot is a smooth function of time; its velocity is the exact derivative of its
//! position.  [`Strapdown::inverse`] computes the samples from the motion, so the strapdown with
//! the same settings reproduces the truth to rounding.  Every error of a navigator therefore comes
//! from the navigator itself or from the sensor model.
//!
//! - [`Route`] is the path, [`Gait`] the motion of the foot, [`SensorErrors`] the sensor model;
//!   [`SimulationSettings`] gives the sample rate, the mechanization and the Earth model.
//! - [`simulate`] simulates a [`Walk`], [`rest`] a static sensor; [`corrupt`] applies the sensor
//!   model to the samples of any other motion.
//!
//! The walk, the sensor errors and the timing jitter use separate random streams: a change of the
//! sensor model does not change the walk.

mod draw;
mod dual;
mod flicker;
mod footing;
mod gait;
mod lift;
mod motion;
mod route;
mod sensor;
mod settings;
mod stride;
mod tremor;

use nalgebra::{UnitQuaternion, Vector3};

pub use self::gait::Gait;
pub use self::route::{Route, Waypoint};
pub use self::sensor::{SensorErrors, TriadErrors};
pub use self::settings::SimulationSettings;

use self::draw::Stream;
use self::motion::Motion;
use self::sensor::Sensor;
use crate::error::ConfigError;
use crate::ins::strapdown::{Increments, Strapdown};
use crate::limits;
use crate::progress::{CHUNK, no_progress};
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;

/// Maximum duration of a simulated rest, s.
const MAX_REST: f64 = 1e6;

/// Samples and truth of a simulated walk, one row per sample in each.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// Sensor readings: means over the interval that ends at the stamp, b frame.
    pub samples: Vec<ImuSample>,
    /// True state of the sensor at each stamp; the position is relative to that at the first stamp.
    ///
    /// Velocity and attitude are those of the foot; the position is the integral of the velocity
    /// in the mechanization of the settings.
    pub truth: Vec<NavState>,
    /// Whether the foot is flat on static ground, from foot flat to heel-off.
    pub stance: Vec<bool>,
    /// Bias of the gyroscopes in each sample, b frame, rad/s.
    pub gyro_bias: Vec<Vector3<f64>>,
    /// Bias of the accelerometers in each sample, b frame, m/s².
    pub accel_bias: Vec<Vector3<f64>>,
}

/// Simulates a walk along `route`.
///
/// The first sample is the mean over one nominal interval before its stamp.  With
/// [`SensorErrors::ideal`], [`Strapdown::advance`] from `truth[0]` over [`Strapdown::increments`]
/// of the samples reproduces `truth`; the increments before the second sample are the first sample
/// times the nominal interval.
///
/// # Errors
/// [`ConfigError::OutOfRange`] with the first invalid parameter.
///
/// # Examples
/// ```
/// use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};
///
/// let (route, gait, errors) = (Route::straight(5.0), Gait::walk(), SensorErrors::mpu6050());
/// let walk = simulate(&route, &gait, &errors, &SimulationSettings::default())?;
/// let last = walk.truth[walk.truth.len() - 1];
/// assert!((last.position.x - 5.0).abs() < 0.01);
/// # Ok::<(), footnav::error::ConfigError>(())
/// ```
pub fn simulate(
    route: &Route,
    gait: &Gait,
    errors: &SensorErrors,
    settings: &SimulationSettings,
) -> Result<Walk, ConfigError> {
    simulate_with_progress(route, gait, errors, settings, no_progress)
}

/// As [`simulate`]; `progress` is called every 10,000 samples, and its error cancels the work.
///
/// # Errors
/// That of `progress`, and those of [`simulate`].
pub fn simulate_with_progress<E: From<ConfigError>>(
    route: &Route,
    gait: &Gait,
    errors: &SensorErrors,
    settings: &SimulationSettings,
    mut progress: impl FnMut() -> Result<(), E>,
) -> Result<Walk, E> {
    route.validate()?;
    gait.validate()?;
    errors.validate()?;
    settings.validate()?;
    let motion = Motion::plan(route, gait, &mut draw::stream(settings.seed, Stream::Gait));
    let stamps =
        settings.stamps(motion.duration(), &mut draw::stream(settings.seed, Stream::Clock));
    let mut tracer = Tracer::new(&motion, gait.sensor_to_foot(), settings.strapdown(), stamps[0]);
    let mut sensor = Sensor::draw(errors, draw::stream(settings.seed, Stream::Sensor));
    let mut walk = Walk::with_capacity(stamps.len());
    for chunk in stamps.chunks(CHUNK) {
        progress()?;
        for &time in chunk {
            let (sample, truth, dt) = tracer.step(time);
            let (gyro_bias, accel_bias) = sensor.biases();
            walk.samples.push(sensor.read(&sample, dt));
            walk.truth.push(truth);
            walk.stance.push(motion.is_flat(time));
            walk.gyro_bias.push(gyro_bias);
            walk.accel_bias.push(accel_bias);
        }
    }
    Ok(walk)
}

/// Simulates a static sensor with its z axis up for `duration` (s).
///
/// # Errors
/// [`ConfigError::OutOfRange`] with the first invalid parameter.
pub fn rest(
    duration: f64,
    errors: &SensorErrors,
    settings: &SimulationSettings,
) -> Result<Vec<ImuSample>, ConfigError> {
    rest_with_progress(duration, errors, settings, no_progress)
}

/// As [`rest`]; `progress` is called every 10,000 samples, and its error cancels the work.
///
/// # Errors
/// That of `progress`, and those of [`rest`].
pub fn rest_with_progress<E: From<ConfigError>>(
    duration: f64,
    errors: &SensorErrors,
    settings: &SimulationSettings,
    mut progress: impl FnMut() -> Result<(), E>,
) -> Result<Vec<ImuSample>, E> {
    limits::within("duration", duration, 0.0..=MAX_REST, "0 to 1e6 s")?;
    errors.validate()?;
    settings.validate()?;
    let mut sensor = Sensor::draw(errors, draw::stream(settings.seed, Stream::Sensor));
    let stamps = settings.stamps(duration, &mut draw::stream(settings.seed, Stream::Clock));
    let mut previous = stamps[0] - 1.0 / settings.rate_hz;
    let mut reading = |&time: &f64| {
        let dt = time - previous;
        previous = time;
        sensor.read(&ImuSample::new(time, [0.0, 0.0, settings.gravity], [0.0; 3]), dt)
    };
    let mut samples = Vec::with_capacity(stamps.len());
    for chunk in stamps.chunks(CHUNK) {
        progress()?;
        samples.extend(chunk.iter().map(&mut reading));
    }
    Ok(samples)
}

/// Applies the sensor model to error-free samples.
///
/// The same seed and errors give the same sensor here and in [`simulate`].  The interval of the
/// first sample is taken to be that of the second.
///
/// # Errors
/// [`ConfigError::OutOfRange`] with the first invalid parameter.
pub fn corrupt(
    truth: &[ImuSample],
    errors: &SensorErrors,
    seed: u64,
) -> Result<Vec<ImuSample>, ConfigError> {
    errors.validate()?;
    let mut sensor = Sensor::draw(errors, draw::stream(seed, Stream::Sensor));
    let mut intervals: Vec<f64> =
        truth.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
    intervals.insert(0, intervals.first().copied().unwrap_or(1.0));
    if let Some(&interval) = intervals.iter().find(|&&interval| interval <= 0.0) {
        return Err(ConfigError::Inconsistent(format!(
            "samples {interval} s apart: the stamps must increase"
        )));
    }
    Ok(truth.iter().zip(intervals).map(|(sample, dt)| sensor.read(sample, dt)).collect())
}

impl Walk {
    fn with_capacity(count: usize) -> Self {
        Self {
            samples: Vec::with_capacity(count),
            truth: Vec::with_capacity(count),
            stance: Vec::with_capacity(count),
            gyro_bias: Vec::with_capacity(count),
            accel_bias: Vec::with_capacity(count),
        }
    }
}

/// Computes the samples from the motion by the inverse strapdown.
struct Tracer<'a> {
    motion: &'a Motion,
    sensor_to_foot: UnitQuaternion<f64>,
    strapdown: Strapdown,
    /// State of the strapdown.  Rounding separates it from the motion; the next sample corrects the
    /// difference.
    state: NavState,
    previous: Option<(ImuSample, Increments)>,
}

impl<'a> Tracer<'a> {
    fn new(
        motion: &'a Motion,
        sensor_to_foot: UnitQuaternion<f64>,
        strapdown: Strapdown,
        first_stamp: f64,
    ) -> Self {
        let state = NavState::at_rest(0.0, UnitQuaternion::identity());
        let mut tracer = Self { motion, sensor_to_foot, strapdown, state, previous: None };
        tracer.state = tracer.target(first_stamp - strapdown.nominal_interval);
        tracer
    }

    /// Attitude and velocity of the sensor at `time` (s), with the position of the strapdown.
    fn target(&self, time: f64) -> NavState {
        let foot = self.motion.at(time);
        NavState {
            time,
            position: self.state.position,
            velocity: foot.velocity,
            attitude: foot.attitude * self.sensor_to_foot,
        }
    }

    /// The sample with the stamp `time`, the true state, and the length of the interval (s).
    fn step(&mut self, time: f64) -> (ImuSample, NavState, f64) {
        let target = self.target(time);
        match self.previous {
            None => self.first(&target),
            Some((previous, before)) => self.next(&target, &previous, &before),
        }
    }

    fn first(&mut self, target: &NavState) -> (ImuSample, NavState, f64) {
        let dt = self.strapdown.nominal_interval;
        let sample =
            mean(&self.strapdown.inverse(&Increments::NONE, &self.state, target), target.time);
        let before = Increments {
            dt,
            angle: dt * sample.angular_rate,
            velocity: dt * sample.specific_force,
        };
        self.state = *target;
        self.previous = Some((sample, before));
        (sample, *target, dt)
    }

    fn next(
        &mut self,
        target: &NavState,
        previous: &ImuSample,
        before: &Increments,
    ) -> (ImuSample, NavState, f64) {
        self.state.time = previous.time;
        let sample = mean(&self.strapdown.inverse(before, &self.state, target), target.time);
        let now = self.strapdown.increments(previous, &sample);
        self.strapdown.advance(&mut self.state, before, &now);
        self.previous = Some((sample, now));
        (sample, NavState { position: self.state.position, ..*target }, now.dt)
    }
}

/// The sample with the mean rate and specific force of the interval that ends at `time` (s).
fn mean(increments: &Increments, time: f64) -> ImuSample {
    ImuSample {
        time,
        specific_force: increments.velocity / increments.dt,
        angular_rate: increments.angle / increments.dt,
    }
}
