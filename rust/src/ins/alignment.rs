//! The start of a walk: is it rest, which way is up, where does the foot point, what does the
//! gyroscope read when nothing turns.
//!
//! Rest is gathered in blocks of a tenth of a second.  The first block that moves ends it, so that
//! a person who steps off early is aligned on the rest that there was, and one who is already
//! walking is aligned roughly and told so.
//!
//! # References
//! - Wu, Lu, Chen, "Research on Foot-Mounted Personal Navigation Algorithm based on MEMS Inertial
//!   Sensors": eq. 1 (coarse alignment).
//! - P. D. Groves, "Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems",
//!   2nd ed., 2013: sec. 5.6.2 (levelling).

use std::f64::consts::FRAC_PI_2;

use nalgebra::{UnitQuaternion, UnitVector3, Vector3};

use crate::error::{ConfigError, DataError};
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
                "alignment.heading_deg and alignment.magnetic_field both give the heading: keep one of them".into(),
            ));
        }
        Ok(())
    }
}

/// Length of a block of rest, s.
const BLOCK: f64 = 0.1;
/// Longest time that the samples of a block may span, s: with more missing nobody knows whether it
/// was rest.
const LONGEST_BLOCK: f64 = 0.2;
/// How long a standing foot takes to sway one way, s.
const SWAY: f64 = 1.0;
/// Rest from which on the gyroscope's mean is believed to be its bias, s.
const SHORTEST_REST: f64 = 0.2;
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

/// The start as the alignment found it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aligned {
    /// Rotation from the sensor frame to n.
    pub attitude: UnitQuaternion<f64>,
    /// Gyroscope bias, rad/s; zero when the start was not at rest.
    pub gyro_bias: Vector3<f64>,
    /// Whether the start was at rest.
    pub at_rest: bool,
    /// How long the rest was, s.
    pub rest: f64,
    /// Standard deviation of the average angular rate of the rest, rad/s, from how much the foot
    /// swayed.
    pub sway: f64,
}

/// What a sample completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Gathered {
    /// Nothing yet.
    Part,
    /// A block of rest.
    Rest,
    /// A block that is no rest.
    Moving,
}

/// Gathers the rest at the start.
#[derive(Clone, Debug)]
pub(crate) struct Alignment {
    config: AlignmentConfig,
    strapdown: Strapdown,
    rest: Means,
    /// The means of the blocks of the rest.
    blocks: Means,
    rest_time: f64,
    /// The sample that ended the last block of rest, or the first of all.
    anchor: Option<ImuSample>,
    /// Samples since the anchor.
    block: Vec<ImuSample>,
}

impl Alignment {
    pub(crate) fn new(config: AlignmentConfig, strapdown: &Strapdown) -> Self {
        Self {
            config,
            strapdown: *strapdown,
            rest: Means::default(),
            blocks: Means::default(),
            rest_time: 0.0,
            anchor: None,
            block: Vec::new(),
        }
    }

    /// Seconds of samples that are needed at the most.
    pub(crate) fn duration(&self) -> f64 {
        self.config.duration
    }

    /// Takes the next sample; answers once the start is known.
    ///
    /// # Errors
    /// [`DataError`] when the samples are not those of an accelerometer near rest, or carry no
    /// heading although one was asked for.
    pub(crate) fn push(&mut self, sample: &ImuSample) -> Result<Option<Aligned>, DataError> {
        match self.gather(sample) {
            Gathered::Part => Ok(None),
            Gathered::Moving => self.finish().map(Some),
            Gathered::Rest => {
                self.accept_block();
                if self.rest_time < self.config.duration - 0.5 * BLOCK {
                    Ok(None)
                } else {
                    self.finish().map(Some)
                }
            }
        }
    }

    /// Takes the next sample; tells of the block that it completes.
    pub(crate) fn gather(&mut self, sample: &ImuSample) -> Gathered {
        let anchor = *self.anchor.get_or_insert(*sample);
        let newest = self.block.last().unwrap_or(&anchor);
        if sample.time <= newest.time {
            return Gathered::Part;
        }
        self.block.push(*sample);
        let elapsed = sample.time - anchor.time;
        if elapsed < BLOCK - 0.5 * self.strapdown.nominal_interval || self.block.len() < 2 {
            return Gathered::Part;
        }
        if elapsed > LONGEST_BLOCK || !self.rests(&Means::of(&self.block)) {
            Gathered::Moving
        } else {
            Gathered::Rest
        }
    }

    /// Counts the newest block as rest.
    pub(crate) fn accept_block(&mut self) {
        let (Some(anchor), Some(newest)) = (self.anchor, self.block.last()) else { return };
        let block = Means::of(&self.block);
        self.rest.merge(&block);
        self.blocks.add(&block.as_sample(newest.time));
        self.rest_time += newest.time - anchor.time;
        self.anchor = Some(*newest);
        self.block.clear();
    }

    /// Samples since the rest that was counted.
    pub(crate) fn block(&self) -> &[ImuSample] {
        &self.block
    }

    /// Where the walk begins: the last sample of the rest, with the moving ones after it; the
    /// newest sample when there was no rest.
    pub(crate) fn handover(&self, newest: &ImuSample) -> (ImuSample, &[ImuSample]) {
        match self.anchor {
            Some(anchor) if self.is_rest() => (anchor, &self.block),
            _ => (*newest, &[]),
        }
    }

    /// Attitude from the samples so far; a heading that they do not carry is left out.
    pub(crate) fn attitude_so_far(&self) -> UnitQuaternion<f64> {
        let mut all = self.rest;
        all.merge(&Means::of(&self.block));
        match (all.count > 0.0, self.anchor) {
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
        let count = self.blocks.count;
        if count < 2.0 {
            return 0.0;
        }
        self.blocks.gyro_std() * (count / (count - 1.0)).sqrt() * (SWAY / self.rest_time).min(1.0)
    }

    fn is_rest(&self) -> bool {
        self.rest.count > 0.0
            && self.rest_time >= SHORTEST_REST.min(self.config.duration) - 0.5 * BLOCK
    }

    fn rests(&self, block: &Means) -> bool {
        let (accel_limit, gyro_limit) = (self.config.rest_accel_std, self.config.rest_gyro_std);
        let quiet = block.accel_std() <= accel_limit && block.gyro_std() <= gyro_limit;
        let drift_accel = (block.specific_force() - self.rest.specific_force()).norm();
        let drift_gyro = (block.angular_rate() - self.rest.angular_rate()).norm();
        quiet
            && (self.rest.count == 0.0 || (drift_accel <= accel_limit && drift_gyro <= gyro_limit))
    }

    fn finish(&self) -> Result<Aligned, DataError> {
        let at_rest = self.is_rest();
        let means = if at_rest { self.rest } else { Means::of(&self.block) };
        let force = means.specific_force();
        if at_rest && !PLAUSIBLE_GRAVITY.contains(&(force.norm() / self.strapdown.gravity)) {
            return Err(DataError::NotGravity { magnitude: force.norm() });
        }
        let attitude = self.towards_heading(self.level(&force))?;
        let earth_rate = attitude.inverse() * self.strapdown.earth_rate;
        let gyro_bias = if at_rest { means.angular_rate() - earth_rate } else { Vector3::zeros() };
        Ok(Aligned { attitude, gyro_bias, at_rest, rest: self.rest_time, sway: self.sway() })
    }

    fn level(&self, force: &Vector3<f64>) -> UnitQuaternion<f64> {
        match self.config.levelling {
            Levelling::Arctangent => level_by_arctangent(force),
            Levelling::Arcsine => level_by_arcsine(force),
        }
    }

    /// Turns a levelled attitude about the vertical until the heading is what was asked for.
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

/// Sums of samples and of their squares.
#[derive(Clone, Copy, Debug, Default)]
struct Means {
    count: f64,
    force: Vector3<f64>,
    force_squares: Vector3<f64>,
    rate: Vector3<f64>,
    rate_squares: Vector3<f64>,
}

impl Means {
    fn of(samples: &[ImuSample]) -> Self {
        let mut means = Self::default();
        for sample in samples {
            means.add(sample);
        }
        means
    }

    fn add(&mut self, sample: &ImuSample) {
        self.count += 1.0;
        self.force += sample.specific_force;
        self.force_squares += sample.specific_force.component_mul(&sample.specific_force);
        self.rate += sample.angular_rate;
        self.rate_squares += sample.angular_rate.component_mul(&sample.angular_rate);
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.force += other.force;
        self.force_squares += other.force_squares;
        self.rate += other.rate;
        self.rate_squares += other.rate_squares;
    }

    fn as_sample(&self, time: f64) -> ImuSample {
        ImuSample { time, specific_force: self.specific_force(), angular_rate: self.angular_rate() }
    }

    fn specific_force(&self) -> Vector3<f64> {
        self.force / self.count
    }

    fn angular_rate(&self) -> Vector3<f64> {
        self.rate / self.count
    }

    /// Greatest standard deviation of the three axes.
    fn accel_std(&self) -> f64 {
        greatest_std(&self.force, &self.force_squares, self.count)
    }

    fn gyro_std(&self) -> f64 {
        greatest_std(&self.rate, &self.rate_squares, self.count)
    }
}

fn greatest_std(sum: &Vector3<f64>, squares: &Vector3<f64>, count: f64) -> f64 {
    let mean = sum / count;
    (squares / count - mean.component_mul(&mean)).max().max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::ins::strapdown::MechanizationKind;

    const G: f64 = 9.806;

    fn config() -> AlignmentConfig {
        AlignmentConfig::default()
    }

    fn strapdown() -> Strapdown {
        let kind = MechanizationKind::default();
        Strapdown { kind, gravity: G, earth_rate: Vector3::zeros(), nominal_interval: 0.005 }
    }

    fn rest(attitude: &UnitQuaternion<f64>, k: u32) -> ImuSample {
        let force = attitude.inverse() * Vector3::new(0.0, 0.0, G);
        ImuSample::new(f64::from(k) * 0.005, force.into(), [0.01, -0.02, 0.03])
    }

    fn align(
        config: AlignmentConfig,
        mut sample: impl FnMut(u32) -> ImuSample,
    ) -> Result<Aligned, DataError> {
        let mut alignment = Alignment::new(config, &strapdown());
        for k in 0..1000 {
            if let Some(aligned) = alignment.push(&sample(k))? {
                return Ok(aligned);
            }
        }
        unreachable!("the alignment ends after its duration")
    }

    fn attitudes() -> impl Strategy<Value = UnitQuaternion<f64>> {
        [-3.1..3.1, -1.5..1.5, -3.1..3.1]
            .prop_map(|[x, y, z]: [f64; 3]| UnitQuaternion::from_euler_angles(x, y, z))
    }

    proptest! {
        #[test]
        fn any_mounting_is_levelled(attitude in attitudes()) {
            let aligned = align(config(), |k| rest(&attitude, k)).unwrap();
            let up = aligned.attitude.inverse() * Vector3::z();
            prop_assert!((up - attitude.inverse() * Vector3::z()).norm() < 1e-12);
            prop_assert!((aligned.gyro_bias - Vector3::new(0.01, -0.02, 0.03)).norm() < 1e-12);
            prop_assert!(aligned.at_rest);
        }

        #[test]
        fn a_given_heading_gives_the_whole_attitude(attitude in attitudes()) {
            let (yaw, elevation) = rotation::yaw_and_elevation(&attitude, &Vector3::x());
            prop_assume!(elevation.abs() < 1.1);
            let heading_deg = Some((FRAC_PI_2 - yaw).to_degrees());
            let aligned = align(AlignmentConfig { heading_deg, ..config() }, |k| rest(&attitude, k)).unwrap();
            prop_assert!(aligned.attitude.angle_to(&attitude) < 1e-7);
        }

        #[test]
        fn a_magnetic_field_gives_the_whole_attitude(attitude in attitudes(), declination_deg in -30.0..30.0) {
            let north = rotation::about_up(-f64::to_radians(declination_deg)) * Vector3::new(0.0, 18.0, -44.0);
            let magnetic_field = Some((attitude.inverse() * north).into());
            let settings = AlignmentConfig { magnetic_field, declination_deg, ..config() };
            let aligned = align(settings, |k| rest(&attitude, k)).unwrap();
            prop_assert!(aligned.attitude.angle_to(&attitude) < 1e-7);
        }

        #[test]
        fn arcsines_agree_with_arctangents_near_upright(x in -1.2..1.2, y in -1.2..1.2) {
            let force = UnitQuaternion::from_euler_angles(x, y, 0.0).inverse() * Vector3::new(0.0, 0.0, 10.1);
            prop_assert!(level_by_arcsine(&force).angle_to(&level_by_arctangent(&force)) < 1e-7);
        }
    }

    #[test]
    fn a_rest_may_be_asked_for_that_is_shorter_than_one_is_otherwise() {
        for duration in [0.001, 0.05, 0.1, 0.15] {
            let still = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.0);
            let aligned =
                align(AlignmentConfig { duration, ..config() }, |k| rest(&still, k)).unwrap();
            assert!(
                aligned.at_rest && aligned.attitude.angle_to(&still) < 1e-7,
                "{duration}: {aligned:?}"
            );
        }
    }

    #[test]
    fn stepping_off_early_shortens_the_rest() {
        let attitude = UnitQuaternion::identity();
        let moving = |k: u32| {
            if k < 110 {
                rest(&attitude, k)
            } else {
                ImuSample::new(f64::from(k) * 0.005, [3.0, 1.0, 12.0], [1.0, f64::from(k % 7), 0.5])
            }
        };
        let aligned = align(config(), moving).unwrap();
        assert!(aligned.at_rest && (aligned.rest - 0.5).abs() < 1e-9, "{aligned:?}");
        assert!((aligned.gyro_bias - Vector3::new(0.01, -0.02, 0.03)).norm() < 1e-12);
    }

    #[test]
    fn walking_from_the_first_sample_is_no_rest() {
        let aligned = align(config(), |k| {
            ImuSample::new(
                f64::from(k) * 0.005,
                [2.0, f64::from(k % 5), 9.0],
                [0.0, f64::from(k % 3), 0.0],
            )
        })
        .unwrap();
        assert!(!aligned.at_rest);
        assert_eq!(aligned.gyro_bias, Vector3::zeros());
    }

    #[test]
    fn repeated_stamps_are_no_rest() {
        let strapdown = strapdown();
        let mut alignment = Alignment::new(config(), &strapdown);
        let still = rest(&UnitQuaternion::identity(), 0);
        assert!((0..1000).all(|_| alignment.push(&still).unwrap().is_none()));
    }

    #[test]
    fn what_moves_at_the_end_of_the_rest_is_handed_over() {
        let attitude = UnitQuaternion::identity();
        let strapdown = strapdown();
        let mut alignment = Alignment::new(config(), &strapdown);
        let pushed =
            |k: u32| ImuSample::new(f64::from(k) * 0.005, [f64::from(k % 9), 1.0, 12.0], [1.0; 3]);
        let sample = |k: u32| if k < 110 { rest(&attitude, k) } else { pushed(k) };
        let end = (0..1000).find(|&k| alignment.push(&sample(k)).unwrap().is_some()).unwrap();
        let (anchor, moving) = alignment.handover(&sample(end));
        assert!((anchor.time - 0.5).abs() < 1e-9, "{anchor:?}");
        assert_eq!(moving.len(), 20);
        assert_eq!(moving.last(), Some(&sample(end)));
    }

    #[test]
    fn units_of_g_are_recognized() {
        let error =
            align(config(), |k| ImuSample::new(f64::from(k) * 0.005, [0.0, 0.0, 1.0], [0.0; 3]))
                .unwrap_err();
        assert!(error.to_string().contains("it looks like g"), "{error}");
    }

    #[test]
    fn an_upright_forward_axis_has_no_heading() {
        let settings =
            AlignmentConfig { heading_deg: Some(10.0), forward_axis: Axis::Z, ..config() };
        let error = align(settings, |k| rest(&UnitQuaternion::identity(), k)).unwrap_err();
        assert!(error.to_string().contains("z axis"), "{error}");
    }
}
