//! Gait parameters.

use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::error::ConfigError;
use crate::limits;

/// Gait of the instrumented foot, a left foot.
///
/// The foot frame has x to the toes, y to the left and z up; its origin is the point of the sole
/// below the sensor.  The default is a walking person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gait {
    /// Distance between consecutive footholds of the same foot, m; the strides are scaled to fill
    /// the length of the path.
    pub stride_length: f64,
    /// Time from one heel-off to the next, s.
    pub stride_duration: f64,
    /// Fraction of the stride from heel strike to toe-off.
    pub stance_share: f64,
    /// Height of the sole in mid-swing in addition to that from the pitch of the foot, m.
    pub swing_clearance: f64,
    /// Pitch of the foot at toe-off, rad, toes up positive.
    pub heel_off_pitch: f64,
    /// Pitch of the foot at heel strike, rad, toes up positive.
    pub heel_strike_pitch: f64,
    /// Peak of the oscillation after heel strike, m/s².
    pub impact: f64,
    /// Inward roll of the foot in flat stance, rad.
    pub stance_roll: f64,
    /// RMS angular rate of the tremor about each axis, rad/s.
    pub tremor: f64,
    /// Position of the sensor in the foot frame, m.
    pub sensor_position: Vector3<f64>,
    /// Rotation vector from the foot frame to the sensor frame b, rad.
    pub mounting: Vector3<f64>,
    /// Time at rest before the first stride, s.
    pub rest_before: f64,
    /// Time at rest after the last stride, s.
    pub rest_after: f64,
    /// Relative standard deviation from stride to stride of length, duration, angles and impact.
    pub variation: f64,
    /// Maximum change of direction at a corner that is walked as a curve, rad; sharper corners are
    /// turned in place.
    pub sharpest_curve: f64,
}

impl Default for Gait {
    fn default() -> Self {
        Self::walk()
    }
}

impl Gait {
    /// Names of the presets.
    pub const PRESETS: [&'static str; 3] = ["walk", "slow", "run"];

    /// Walking at 1.25 m/s.
    #[must_use]
    pub fn walk() -> Self {
        Self {
            stride_length: 1.35,
            stride_duration: 1.08,
            stance_share: 0.6,
            swing_clearance: 0.04,
            heel_off_pitch: -1.05,
            heel_strike_pitch: 0.35,
            impact: 18.0,
            stance_roll: 0.03,
            tremor: 0.01,
            sensor_position: Vector3::new(0.0, 0.0, 0.07),
            mounting: Vector3::zeros(),
            rest_before: 3.0,
            rest_after: 2.0,
            variation: 0.03,
            sharpest_curve: 0.9,
        }
    }

    /// Strolling at 0.6 m/s.
    #[must_use]
    pub fn slow() -> Self {
        Self {
            stride_length: 0.95,
            stride_duration: 1.55,
            stance_share: 0.66,
            heel_off_pitch: -0.8,
            heel_strike_pitch: 0.25,
            impact: 9.0,
            ..Self::walk()
        }
    }

    /// Running at 2.7 m/s.
    #[must_use]
    pub fn run() -> Self {
        Self {
            stride_length: 2.0,
            stride_duration: 0.74,
            stance_share: 0.35,
            swing_clearance: 0.1,
            heel_off_pitch: -0.85,
            heel_strike_pitch: 0.1,
            impact: 35.0,
            stance_roll: 0.04,
            ..Self::walk()
        }
    }

    /// The preset of a name from [`PRESETS`](Self::PRESETS).
    ///
    /// # Errors
    /// [`ConfigError::UnknownPreset`] for any other name.
    pub fn preset(name: &str) -> Result<Self, ConfigError> {
        match name {
            "walk" => Ok(Self::walk()),
            "slow" => Ok(Self::slow()),
            "run" => Ok(Self::run()),
            _ => Err(ConfigError::UnknownPreset {
                name: name.to_owned(),
                known: Self::PRESETS.join(", "),
            }),
        }
    }

    /// Strides per second.
    #[must_use]
    pub fn cadence(&self) -> f64 {
        1.0 / self.stride_duration
    }

    /// The same gait at `cadence` strides per second.
    #[must_use]
    pub fn with_cadence(self, cadence: f64) -> Self {
        Self { stride_duration: 1.0 / cadence, ..self }
    }

    /// Rotation from the sensor frame b to the foot frame.
    #[must_use]
    pub fn sensor_to_foot(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(self.mounting)
    }

    /// Checks every parameter.
    ///
    /// # Errors
    /// [`ConfigError::OutOfRange`] with the first parameter outside its limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.validate_stride()?;
        self.validate_foot()?;
        self.validate_walk()
    }

    fn validate_stride(&self) -> Result<(), ConfigError> {
        limits::within("gait.stride_length", self.stride_length, 0.1..=4.0, "0.1 to 4 m")?;
        limits::within("gait.stride_duration", self.stride_duration, 0.3..=5.0, "0.3 to 5 s")?;
        limits::within("gait.stance_share", self.stance_share, 0.2..=0.85, "0.2 to 0.85")?;
        limits::within("gait.swing_clearance", self.swing_clearance, 0.0..=0.5, "0 to 0.5 m")?;
        limits::within("gait.heel_off_pitch", self.heel_off_pitch, -1.4..=0.0, "-1.4 to 0 rad")?;
        limits::within("gait.heel_strike_pitch", self.heel_strike_pitch, 0.0..=0.8, "0 to 0.8 rad")
    }

    fn validate_foot(&self) -> Result<(), ConfigError> {
        limits::within("gait.impact", self.impact, 0.0..=500.0, "0 to 500 m/s^2")?;
        limits::within("gait.stance_roll", self.stance_roll, 0.0..=0.3, "0 to 0.3 rad")?;
        limits::within("gait.tremor", self.tremor, 0.0..=0.5, "0 to 0.5 rad/s")?;
        limits::finite("gait.sensor_position", self.sensor_position.as_slice())?;
        let reach = self.sensor_position.norm();
        limits::within("gait.sensor_position", reach, 0.0..=0.5, "within 0.5 m of the sole")?;
        limits::finite("gait.mounting", self.mounting.as_slice())
    }

    fn validate_walk(&self) -> Result<(), ConfigError> {
        limits::within("gait.rest_before", self.rest_before, 0.0..=3600.0, "0 to 3600 s")?;
        limits::within("gait.rest_after", self.rest_after, 0.0..=3600.0, "0 to 3600 s")?;
        limits::within("gait.variation", self.variation, 0.0..=0.2, "0 to 0.2")?;
        limits::within("gait.sharpest_curve", self.sharpest_curve, 0.0..=2.5, "0 to 2.5 rad")
    }
}
