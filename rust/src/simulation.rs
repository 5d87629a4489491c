//! A walk that never was: samples of a sensor on a shoe, and the truth behind them.
//!
//! The motion of the foot is a smooth function of time, its velocity the true derivative of its
//! position.  The samples are found from it by [`Strapdown::inverse`], so that the strapdown that
//! they were made for leads back to the truth to rounding: what a navigator gets wrong is its own
//! doing, or the sensor's.
//!
//! - [`Route`]: where to;  [`Gait`]: how;  [`SensorErrors`]: with what sensor;
//!   [`SimulationSettings`]: how often, and on what Earth.
//! - [`simulate`] makes the [`Walk`];  [`rest`] leaves the sensor on a table;  [`corrupt`] passes
//!   samples of any other motion through the sensor.
//!
//! The walk, the errors of the sensor and the jitter of the stamps have random streams of their
//! own: a change of the sensor does not change the walk.

mod draw;
mod flicker;
mod footing;
mod gait;
mod lift;
mod motion;
mod route;
mod sensor;
mod settings;
mod stride;
mod timed;
mod tremor;

use nalgebra::{UnitQuaternion, Vector3};

pub use self::gait::Gait;
pub use self::route::{Route, Waypoint};
pub use self::sensor::{SensorErrors, TriadErrors};
pub use self::settings::SimulationSettings;

use self::draw::Cause;
use self::motion::Motion;
use self::sensor::Sensor;
use crate::error::ConfigError;
use crate::ins::strapdown::{Increments, Strapdown};
use crate::limits;
use crate::progress::{CHUNK, no_progress};
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;

/// Longest rest that is simulated, s.
const LONGEST_REST: f64 = 1e6;

/// Samples and truth of a simulated walk, one row per sample in each.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// What the sensor reads: means over the interval that the sample ends, b frame.
    pub samples: Vec<ImuSample>,
    /// State of the sensor at each stamp, the position from where it was at the first.
    ///
    /// Velocity and attitude are those of the moving foot; the position is their integral by the
    /// rule of the mechanization that the samples are made for.
    pub truth: Vec<NavState>,
    /// Whether the foot stands flat on ground that is at rest, from the end of its roll over the
    /// heel to heel-off.
    pub stance: Vec<bool>,
    /// Bias of the gyroscopes in each sample, b frame, rad/s.
    pub gyro_bias: Vec<Vector3<f64>>,
    /// Bias of the accelerometers in each sample, b frame, m/s².
    pub accel_bias: Vec<Vector3<f64>>,
}

/// Walks along `route` and records it.
///
/// The first sample is the mean over one nominal interval before its stamp.  With
/// [`SensorErrors::ideal`], [`Strapdown::advance`] from `truth[0]` over [`Strapdown::increments`]
/// of the samples gives `truth` again, when the first sample times the nominal interval is what
/// came before.
///
/// # Errors
/// [`ConfigError::OutOfRange`] with the first parameter that makes no sense.
///
/// # Examples
/// ```
/// use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};
///
/// let walk = simulate(&Route::straight(5.0), &Gait::walk(), &SensorErrors::mpu6050(), &SimulationSettings::default())?;
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

/// As [`simulate`]; `progress` is asked every 10,000 samples and can end the work.
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
    let motion = Motion::plan(route, gait, &mut draw::stream(settings.seed, Cause::Gait));
    let stamps = settings.stamps(motion.duration(), &mut draw::stream(settings.seed, Cause::Clock));
    let mut tracer = Tracer::new(&motion, gait.sensor_to_foot(), settings.strapdown(), stamps[0]);
    let mut sensor = Sensor::draw(errors, draw::stream(settings.seed, Cause::Sensor));
    let mut walk = Walk::with_capacity(stamps.len());
    for stretch in stamps.chunks(CHUNK) {
        progress()?;
        for &time in stretch {
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

/// What a sensor that lies still with its z axis up reads for `duration` (s), as on a table.
///
/// # Errors
/// [`ConfigError::OutOfRange`] with the first parameter that makes no sense.
pub fn rest(
    duration: f64,
    errors: &SensorErrors,
    settings: &SimulationSettings,
) -> Result<Vec<ImuSample>, ConfigError> {
    rest_with_progress(duration, errors, settings, no_progress)
}

/// As [`rest`]; `progress` is asked every 10,000 samples and can end the work.
///
/// # Errors
/// That of `progress`, and those of [`rest`].
pub fn rest_with_progress<E: From<ConfigError>>(
    duration: f64,
    errors: &SensorErrors,
    settings: &SimulationSettings,
    mut progress: impl FnMut() -> Result<(), E>,
) -> Result<Vec<ImuSample>, E> {
    limits::within("duration", duration, 0.0..=LONGEST_REST, "0 to 1e6 s")?;
    errors.validate()?;
    settings.validate()?;
    let mut sensor = Sensor::draw(errors, draw::stream(settings.seed, Cause::Sensor));
    let stamps = settings.stamps(duration, &mut draw::stream(settings.seed, Cause::Clock));
    let mut before = stamps[0] - 1.0 / settings.rate_hz;
    let mut reading = |&time: &f64| {
        let dt = time - before;
        before = time;
        sensor.read(&ImuSample::new(time, [0.0, 0.0, settings.gravity], [0.0; 3]), dt)
    };
    let mut samples = Vec::with_capacity(stamps.len());
    for stretch in stamps.chunks(CHUNK) {
        progress()?;
        samples.extend(stretch.iter().map(&mut reading));
    }
    Ok(samples)
}

/// What a sensor with errors makes of samples without any.
///
/// Sensors of one seed and the same errors are the same, here and in [`simulate`].  The first
/// sample lasts as long as the second.
///
/// # Errors
/// [`ConfigError::OutOfRange`] with the first parameter that makes no sense.
pub fn corrupt(
    truth: &[ImuSample],
    errors: &SensorErrors,
    seed: u64,
) -> Result<Vec<ImuSample>, ConfigError> {
    errors.validate()?;
    let mut sensor = Sensor::draw(errors, draw::stream(seed, Cause::Sensor));
    let mut intervals: Vec<f64> =
        truth.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
    intervals.insert(0, intervals.first().copied().unwrap_or(1.0));
    if let Some(&interval) = intervals.iter().find(|&&interval| interval <= 0.0) {
        return Err(ConfigError::Inconsistent(format!(
            "samples {interval} s apart: a simulated sensor needs time to go on"
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

/// Follows the motion with the strapdown, one sample at a time.
struct Tracer<'a> {
    motion: &'a Motion,
    sensor_to_foot: UnitQuaternion<f64>,
    strapdown: Strapdown,
    /// Where the strapdown is, which rounding keeps a little apart from the motion; the next sample
    /// takes it back.
    reached: NavState,
    previous: Option<(ImuSample, Increments)>,
}

impl<'a> Tracer<'a> {
    fn new(
        motion: &'a Motion,
        sensor_to_foot: UnitQuaternion<f64>,
        strapdown: Strapdown,
        first_stamp: f64,
    ) -> Self {
        let reached = NavState::at_rest(0.0, UnitQuaternion::identity());
        let mut tracer = Self { motion, sensor_to_foot, strapdown, reached, previous: None };
        tracer.reached = tracer.aim(first_stamp - strapdown.nominal_interval);
        tracer
    }

    /// Attitude and velocity of the sensor at `time` (s), with the position reached so far.
    fn aim(&self, time: f64) -> NavState {
        let foot = self.motion.at(time);
        NavState {
            time,
            position: self.reached.position,
            velocity: foot.velocity,
            attitude: foot.attitude * self.sensor_to_foot,
        }
    }

    /// The sample that ends at `time`, the true state there, and the length of the interval (s).
    fn step(&mut self, time: f64) -> (ImuSample, NavState, f64) {
        let aim = self.aim(time);
        match self.previous {
            None => self.first(&aim),
            Some((previous, before)) => self.next(&aim, &previous, &before),
        }
    }

    fn first(&mut self, aim: &NavState) -> (ImuSample, NavState, f64) {
        let dt = self.strapdown.nominal_interval;
        let sample = mean(&self.strapdown.inverse(&Increments::NONE, &self.reached, aim), aim.time);
        let before = Increments {
            dt,
            angle: dt * sample.angular_rate,
            velocity: dt * sample.specific_force,
        };
        self.reached = *aim;
        self.previous = Some((sample, before));
        (sample, *aim, dt)
    }

    fn next(
        &mut self,
        aim: &NavState,
        previous: &ImuSample,
        before: &Increments,
    ) -> (ImuSample, NavState, f64) {
        self.reached.time = previous.time;
        let sample = mean(&self.strapdown.inverse(before, &self.reached, aim), aim.time);
        let now = self.strapdown.increments(previous, &sample);
        self.strapdown.advance(&mut self.reached, before, &now);
        self.previous = Some((sample, now));
        (sample, NavState { position: self.reached.position, ..*aim }, now.dt)
    }
}

/// The sample that holds the means of an interval that ends at `time` (s).
fn mean(increments: &Increments, time: f64) -> ImuSample {
    ImuSample {
        time,
        specific_force: increments.velocity / increments.dt,
        angular_rate: increments.angle / increments.dt,
    }
}
