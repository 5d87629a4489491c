//! Initial alignment: levelling, heading and gyroscope bias from the rest at the start.
//!
//! Rest is gathered in blocks of a tenth of a second (see [`crate::ins::rest`]).  The first block
//! in motion ends it: a walk that starts early is aligned on the rest so far; a start in motion
//! gives a coarse alignment and is flagged.
//!
//! # References
//! - Wu, Lu, Chen, "Research on Foot-Mounted Personal Navigation Algorithm based on MEMS Inertial
//!   Sensors": eq. 1 (coarse alignment).
//! - P. D. Groves, "Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems",
//!   2nd ed., 2013: sec. 5.6.2 (levelling).

use std::f64::consts::FRAC_PI_2;

use nalgebra::{UnitQuaternion, UnitVector3, Vector3};

use crate::error::{ConfigError, DataError};
pub(crate) use crate::ins::rest::BlockState as Gathered;
use crate::ins::rest::{RestDetector, RestLimits};
use crate::ins::strapdown::Strapdown;
use crate::limits::Limits;
use crate::math::rotation;
use crate::settings::{choices, settings};
use crate::types::sample::ImuSample;

choices! {
    /// Form of the levelling equations.
    pub enum Levelling {
        /// Two-argument arctangents: valid in any mounting, upside down too.
        Arctangent = "arctangent",
        /// Arcsines (Wu et al., eq. 1): for a sensor mounted within 90 degrees of upright.
        Arcsine = "arcsine",
    }
}

choices! {
    /// An axis of the sensor.
    pub enum Axis {
        /// Along x.
        X = "x",
        /// Along y.
        Y = "y",
        /// Along z.
        Z = "z",
        /// Against x.
        MinusX = "-x",
        /// Against y.
        MinusY = "-y",
        /// Against z.
        MinusZ = "-z",
    }
}

settings! {
    /// The start of the walk.
    pub struct AlignmentConfig: "alignment", also has_one_heading {
        /// Longest rest that is averaged; a walk that starts sooner is aligned on a shorter one.
        duration: f64 = 1.0, "s", Limits::Positive;
        /// Shortest rest whose mean angular rate is taken for the gyroscope's bias, at most
        /// `duration`.
        min_rest: f64 = 0.2, "s", Limits::NonNegative;
        /// Form of the levelling equations.
        levelling: Levelling = Levelling::Arctangent;
        /// Heading of `forward_axis` at the start, clockwise from true north.  Without it and
        /// without a magnetic field, n x is the direction of `forward_axis`.
        heading_deg: Option<f64> = None, "degrees", Limits::Between(-360.0, 360.0);
        /// Magnetic field at the start in the sensor frame, in any unit; gives the heading instead
        /// of `heading_deg`.
        magnetic_field: Option<[f64; 3]> = None, "", Limits::Finite;
        /// Declination of the magnetic field, east of true north.
        declination_deg: f64 = 0.0, "degrees", Limits::Between(-180.0, 180.0);
        /// Axis of the sensor that the heading refers to.
        forward_axis: Axis = Axis::X;
        /// Largest standard deviation of the specific force at rest.
        rest_accel_std: f64 = 0.25, "m/s²", Limits::Positive;
        /// Largest standard deviation of the angular rate at rest.
        rest_gyro_std: f64 = 0.06, "rad/s", Limits::Positive;
        /// Longest rest after that over which the filter levels finely before the walk begins (Wu
        /// et al.).
        fine_duration: f64 = 0.0, "s", Limits::NonNegative;
        /// Standard deviation of the gyroscope's bias after `duration` of rest, in addition to the
        /// measured sway of the foot.
        gyro_bias_std: f64 = 1.0e-3, "rad/s", Limits::Positive;
        /// Standard deviation of roll and pitch in addition to the effect of the accelerometer's
        /// bias.
        tilt_std: f64 = 0.01, "rad", Limits::Positive;
        /// Standard deviation of the heading; zero when the heading only defines the direction of
        /// n x.
        heading_std_deg: f64 = 0.0, "degrees", Limits::Between(0.0, 180.0);
    }
}

impl AlignmentConfig {
    fn has_one_heading(&self) -> Result<(), ConfigError> {
        if self.heading_deg.is_some() && self.magnetic_field.is_some() {
            return Err(ConfigError::Inconsistent(
                "alignment.heading_deg and alignment.magnetic_field both give the heading: \
                 keep one of them"
                    .into(),
            ));
        }
        Ok(())
    }
}

/// Length of a block of rest, s.
const BLOCK: f64 = 0.1;
/// Longest time that the samples of a block may span, s: two blocks' worth, beyond which the motion
/// in the gap is unknown.
const MAX_BLOCK_SPAN: f64 = 0.2;
/// Half period of the sway of a standing foot, s.
const SWAY: f64 = 1.0;
/// Elevation of the forward axis beyond which it has no heading, rad.
const STEEPEST_FORWARD_AXIS: f64 = 1.2;
/// Bounds on the mean specific force at the start in units of gravity; a badly calibrated sensor
/// stays inside, a wrong unit or range does not.
const PLAUSIBLE_GRAVITY: std::ops::Range<f64> = 0.6..1.6;

/// Roll and pitch from the mean specific force at rest by two-argument arctangents, valid in any
/// mounting; n x lies below the sensor's x axis.
#[must_use]
pub fn level_by_arctangent(f: &Vector3<f64>) -> UnitQuaternion<f64> {
    let about_x = f.y.atan2(f.z);
    let about_y = (-f.x).atan2(f.y.hypot(f.z));
    UnitQuaternion::from_euler_angles(about_x, about_y, 0.0)
}

/// Roll and pitch by the arcsines of Wu et al., eq. 1: the same as [`level_by_arctangent`] within
/// 90 degrees of upright, wrong upside down.
///
/// A magnitude above gravity would leave the arcsine's domain, so the mean is divided by its own
/// magnitude rather than by g.
#[must_use]
pub fn level_by_arcsine(f: &Vector3<f64>) -> UnitQuaternion<f64> {
    let up = f.try_normalize(0.0).unwrap_or_else(Vector3::z);
    let about_y = (-up.x).asin();
    let about_x = (up.y / about_y.cos()).clamp(-1.0, 1.0).asin();
    UnitQuaternion::from_euler_angles(about_x, about_y, 0.0)
}

/// Result of the alignment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aligned {
    /// Rotation from the sensor frame to n.
    pub attitude: UnitQuaternion<f64>,
    /// Gyroscope bias, rad/s; zero when the start was not at rest.
    pub gyro_bias: Vector3<f64>,
    /// Whether the start was at rest.
    pub at_rest: bool,
    /// Duration of the rest, s.
    pub rest: f64,
    /// Standard deviation of the average angular rate of the rest, rad/s, from the sway of the foot.
    pub sway: f64,
}

impl AlignmentConfig {
    /// Limits of the rest at the start.
    ///
    /// The means may drift as far as the samples scatter: a standing foot that sways more has
    /// stepped off.
    pub(crate) fn rest_limits(&self) -> RestLimits {
        RestLimits {
            block: BLOCK,
            max_span: MAX_BLOCK_SPAN,
            min_duration: self.min_rest.min(self.duration) - 0.5 * BLOCK,
            accel_std: self.rest_accel_std,
            gyro_std: self.rest_gyro_std,
            accel_drift: self.rest_accel_std,
            gyro_drift: self.rest_gyro_std,
        }
    }
}

/// Gathers the rest at the start.
#[derive(Clone, Debug)]
pub(crate) struct Alignment {
    config: AlignmentConfig,
    strapdown: Strapdown,
    detector: RestDetector,
}

impl Alignment {
    pub(crate) fn new(config: AlignmentConfig, strapdown: &Strapdown) -> Self {
        let detector = RestDetector::new(config.rest_limits(), strapdown.nominal_interval);
        Self { config, strapdown: *strapdown, detector }
    }

    /// Longest rest that is averaged, s.
    pub(crate) fn duration(&self) -> f64 {
        self.config.duration
    }

    /// Adds the next sample; returns the start once it is known.
    ///
    /// # Errors
    /// [`DataError`] when the samples are not those of an accelerometer near rest, or carry no
    /// heading although the settings need one.
    pub(crate) fn push(&mut self, sample: &ImuSample) -> Result<Option<Aligned>, DataError> {
        match self.gather(sample) {
            Gathered::Part => Ok(None),
            Gathered::Moving => self.finish().map(Some),
            Gathered::Rest => {
                self.accept_block();
                if self.detector.duration() < self.config.duration - 0.5 * BLOCK {
                    Ok(None)
                } else {
                    self.finish().map(Some)
                }
            }
        }
    }

    /// Adds the next sample; returns the state of the block.
    pub(crate) fn gather(&mut self, sample: &ImuSample) -> Gathered {
        self.detector.push(sample)
    }

    /// Adds the newest block to the rest.
    pub(crate) fn accept_block(&mut self) {
        self.detector.extend_rest();
    }

    /// Samples since the rest so far.
    pub(crate) fn block(&self) -> &[ImuSample] {
        self.detector.block()
    }

    /// Where the walk begins: the last sample of the rest, with the moving ones after it; the
    /// newest sample when there was no rest.
    pub(crate) fn handover(&self, newest: &ImuSample) -> (ImuSample, &[ImuSample]) {
        match self.detector.anchor() {
            Some(anchor) if self.detector.has_rest() => (*anchor, self.detector.block()),
            _ => (*newest, &[]),
        }
    }

    /// Attitude from the samples so far; a heading that they do not carry is left out.
    pub(crate) fn attitude_so_far(&self) -> UnitQuaternion<f64> {
        let mut all = *self.detector.rest();
        all.merge(&self.detector.block_statistics());
        match (all.count() > 0.0, self.detector.anchor()) {
            (false, Some(first)) => self.attitude_of(&first.specific_force),
            _ => self.attitude_of(&all.specific_force()),
        }
    }

    /// Attitude from a specific force at rest; a heading that it does not carry is left out.
    pub(crate) fn attitude_of(&self, force: &Vector3<f64>) -> UnitQuaternion<f64> {
        let level = self.level(force);
        self.towards_heading(level).unwrap_or(level)
    }

    /// Standard deviation of the average angular rate: as much as the blocks' rates differ, of the
    /// axis where they do most, and less the longer the rest was.
    ///
    /// A foot that sways comes back, so the average falls with the time over which the angle is the
    /// same; within [`SWAY`] it does not average out.
    fn sway(&self) -> f64 {
        let (means, rest) = (self.detector.block_means(), self.detector.duration());
        let count = means.count();
        if count < 2.0 {
            return 0.0;
        }
        means.gyro_std().max() * (count / (count - 1.0)).sqrt() * (SWAY / rest).min(1.0)
    }

    fn finish(&self) -> Result<Aligned, DataError> {
        let at_rest = self.detector.has_rest();
        let means = if at_rest { *self.detector.rest() } else { self.detector.block_statistics() };
        let force = means.specific_force();
        if at_rest && !PLAUSIBLE_GRAVITY.contains(&(force.norm() / self.strapdown.gravity)) {
            return Err(DataError::NotGravity { magnitude: force.norm() });
        }
        let attitude = self.towards_heading(self.level(&force))?;
        let earth_rate = attitude.inverse() * self.strapdown.earth_rate;
        let gyro_bias = if at_rest { means.angular_rate() - earth_rate } else { Vector3::zeros() };
        Ok(Aligned {
            attitude,
            gyro_bias,
            at_rest,
            rest: self.detector.duration(),
            sway: self.sway(),
        })
    }

    fn level(&self, force: &Vector3<f64>) -> UnitQuaternion<f64> {
        match self.config.levelling {
            Levelling::Arctangent => level_by_arctangent(force),
            Levelling::Arcsine => level_by_arcsine(force),
        }
    }

    /// Turns a levelled attitude about the vertical to the heading of the settings.
    fn towards_heading(
        &self,
        level: UnitQuaternion<f64>,
    ) -> Result<UnitQuaternion<f64>, DataError> {
        if let Some(field) = self.config.magnetic_field {
            return toward_magnetic_north(level, field, self.config.declination_deg);
        }
        let axis = self.config.forward_axis;
        let (yaw, elevation) = rotation::yaw_and_elevation(&level, &axis.vector());
        let steep = elevation.abs() > STEEPEST_FORWARD_AXIS;
        match self.config.heading_deg {
            Some(_) if steep => Err(DataError::SteepForwardAxis {
                axis: axis.name(),
                elevation_deg: elevation.to_degrees(),
            }),
            Some(heading) => Ok(rotation::about_up(FRAC_PI_2 - heading.to_radians() - yaw) * level),
            None if steep => Ok(level),
            None => Ok(rotation::about_up(-yaw) * level),
        }
    }
}

/// Turns a levelled attitude until the horizontal field points `declination_deg` clockwise of true
/// north.
fn toward_magnetic_north(
    level: UnitQuaternion<f64>,
    field: [f64; 3],
    declination_deg: f64,
) -> Result<UnitQuaternion<f64>, DataError> {
    let Some(direction) = UnitVector3::try_new(Vector3::from(field), f64::MIN_POSITIVE) else {
        return Err(DataError::VerticalField { field });
    };
    let (yaw, elevation) = rotation::yaw_and_elevation(&level, &direction);
    if elevation.is_nan() || elevation.abs() > FRAC_PI_2 - 1.0e-3 {
        return Err(DataError::VerticalField { field });
    }
    Ok(rotation::about_up(FRAC_PI_2 - declination_deg.to_radians() - yaw) * level)
}

impl Axis {
    /// The axis as a unit vector of the sensor frame.
    #[must_use]
    pub fn vector(self) -> Vector3<f64> {
        match self {
            Self::X => Vector3::x(),
            Self::Y => Vector3::y(),
            Self::Z => Vector3::z(),
            Self::MinusX => -Vector3::x(),
            Self::MinusY => -Vector3::y(),
            Self::MinusZ => -Vector3::z(),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::MinusX => "-x",
            Self::MinusY => "-y",
            Self::MinusZ => "-z",
        }
    }
}

#[cfg(test)]
mod tests;
