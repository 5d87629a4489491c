//! Settings of every stage, in the order in which a sample meets the stages.
//!
//! The defaults here are the only ones: the Python layer shows the same values and a test compares
//! the two.  Angles are in degrees only where the name says so.

use serde::{Deserialize, Serialize};

use crate::calibration::Calibration;
use crate::error::ConfigError;
use crate::ins::earth;
use crate::ins::strapdown::MechanizationKind;
use crate::limits::{at_least_zero, positive, within};

mod detector;
mod filter;
mod magnetometer;
mod presets;
mod refinement;

pub use detector::{
    AccelerationMagnitudeConfig, AdaptiveShoeConfig, AngularRateEnergyConfig, Condition,
    DetectorConfig, GraphTheoreticConfig, MagnitudeDebouncedConfig, MagnitudeVarianceConfig,
    MovingVarianceConfig, ShoeConfig, ThreeConditionConfig, WindowedEnergiesConfig,
};
pub use filter::{AttitudeUpdate, FilterConfig, FilterKind};
pub use magnetometer::MagnetometerConfig;
pub use presets::PRESETS;
pub use refinement::{CorrectionConfig, CorrectionKind, SmootherConfig, SmootherKind};

/// Latitude (degrees) that gravity is taken from when neither gravity, latitude nor origin is
/// known.  Gravity changes by 0.026 m/s² from there to the equator or the poles, which the
/// accelerometer biases absorb at the first rest.
pub const DEFAULT_LATITUDE_DEG: f64 = 45.0;

/// All settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// What is known of the inertial measurement unit.
    pub sensor: SensorConfig,
    /// Corrections of the raw readings.
    pub calibration: Calibration,
    /// The start: rest, levelling, heading.
    pub alignment: AlignmentConfig,
    /// The strapdown integration and the Earth that it runs on.
    pub mechanization: MechanizationConfig,
    /// The stance detector.
    pub detector: DetectorConfig,
    /// The error-state filter.
    pub filter: FilterConfig,
    /// The heading that a magnetometer holds.
    pub magnetometer: MagnetometerConfig,
    /// Corrections of whole gait cycles.
    pub correction: CorrectionConfig,
    /// Estimates from what came later.
    pub smoother: SmootherConfig,
    /// When the solution is called degraded or invalid.
    pub health: HealthConfig,
    /// Where the track lies on the Earth and in which frame files are written.
    pub output: OutputConfig,
}

/// Noise, biases and ranges of the sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorConfig {
    /// White noise density of the gyroscope, rad/s/√Hz.
    pub gyro_noise_density: f64,
    /// White noise density of the accelerometer, m/s²/√Hz.
    pub accel_noise_density: f64,
    /// Random walk of the gyroscope's bias, rad/s/√s.
    pub gyro_bias_walk: f64,
    /// Random walk of the accelerometer's bias, m/s²/√s.
    pub accel_bias_walk: f64,
    /// Standard deviation of the gyroscope's bias before any rest was seen, rad/s.
    pub gyro_bias_std: f64,
    /// Standard deviation of the accelerometer's bias, m/s².
    pub accel_bias_std: f64,
    /// Standard deviation of the gyroscope's scale factors and misalignments (rad) that no
    /// calibration took out.
    pub gyro_scale_std: f64,
    /// The same of the accelerometer.
    pub accel_scale_std: f64,
    /// Full scale of the gyroscope, rad/s; unknown when absent.
    pub gyro_range: Option<f64>,
    /// Full scale of the accelerometer, m/s²; unknown when absent.
    pub accel_range: Option<f64>,
}

impl Default for SensorConfig {
    fn default() -> Self {
        Self {
            gyro_noise_density: 1.0e-4,
            accel_noise_density: 4.0e-3,
            gyro_bias_walk: 1.0e-5,
            accel_bias_walk: 1.0e-4,
            gyro_bias_std: 0.02,
            accel_bias_std: 0.15,
            gyro_scale_std: 0.0,
            accel_scale_std: 0.0,
            gyro_range: None,
            accel_range: None,
        }
    }
}

/// Form of the levelling equations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Levelling {
    /// Two-argument arctangents: valid in any mounting, upside down too.
    #[default]
    Arctangent,
    /// Arcsines (Wu et al., eq. 1): for a sensor that is mounted within 90 degrees of upright.
    Arcsine,
}

/// An axis of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axis {
    /// Along x.
    #[default]
    #[serde(rename = "x")]
    X,
    /// Along y.
    #[serde(rename = "y")]
    Y,
    /// Along z.
    #[serde(rename = "z")]
    Z,
    /// Against x.
    #[serde(rename = "-x")]
    MinusX,
    /// Against y.
    #[serde(rename = "-y")]
    MinusY,
    /// Against z.
    #[serde(rename = "-z")]
    MinusZ,
}

/// The start of the walk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AlignmentConfig {
    /// Rest that is averaged at the most, s.  A walk that starts sooner is aligned on the rest that
    /// there is.
    pub duration: f64,
    /// Form of the levelling equations.
    pub levelling: Levelling,
    /// Heading of `forward_axis` at the start, degrees clockwise from true north.  When it is
    /// absent and no magnetic field is given, n x is where `forward_axis` points.
    pub heading_deg: Option<f64>,
    /// Magnetic field at the start in the sensor frame, any unit: gives the heading instead of
    /// `heading_deg`.
    pub magnetic_field: Option<[f64; 3]>,
    /// Declination of the magnetic field, degrees east of true north.
    pub declination_deg: f64,
    /// Axis of the sensor that the heading belongs to.
    pub forward_axis: Axis,
    /// Greatest standard deviation of the specific force that still counts as rest, m/s².
    pub rest_accel_std: f64,
    /// Greatest standard deviation of the angular rate that still counts as rest, rad/s.
    pub rest_gyro_std: f64,
    /// Rest after that, at the most, over which the filter levels finely before the walk begins, s.
    pub fine_duration: f64,
    /// Standard deviation of the gyroscope's bias after `duration` of rest, rad/s, beside what the
    /// foot was seen to sway.
    pub gyro_bias_std: f64,
    /// Standard deviation of roll and pitch beyond what the accelerometer's bias explains, rad.
    pub tilt_std: f64,
    /// Standard deviation of the heading, degrees: zero when it only defines where n x points.
    pub heading_std_deg: f64,
}

impl Default for AlignmentConfig {
    fn default() -> Self {
        Self {
            duration: 1.0,
            levelling: Levelling::default(),
            heading_deg: None,
            magnetic_field: None,
            declination_deg: 0.0,
            forward_axis: Axis::default(),
            rest_accel_std: 0.25,
            rest_gyro_std: 0.06,
            fine_duration: 0.0,
            gyro_bias_std: 1.0e-3,
            tilt_std: 0.01,
            heading_std_deg: 0.0,
        }
    }
}

/// The strapdown integration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MechanizationConfig {
    /// Form of the update.
    pub kind: MechanizationKind,
    /// Whether the Earth turns.  Needs a heading; a foot at rest resets what its rotation does in a
    /// stride.
    pub earth_rate: bool,
    /// Gravity, m/s²; from latitude and height when absent.
    pub gravity: Option<f64>,
    /// Geodetic latitude, degrees; from `output.origin`, or else [`DEFAULT_LATITUDE_DEG`], when
    /// absent.
    pub latitude_deg: Option<f64>,
    /// Height above the ellipsoid, m; from `output.origin`, or else 0, when absent.
    pub height: Option<f64>,
}

/// Limits beyond which a solution is degraded or invalid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HealthConfig {
    /// Interval that counts as a gap, in nominal intervals.
    pub gap_intervals: f64,
    /// How long a gap, a clipped or a refused sample degrades the solution, s.
    pub memory: f64,
    /// Time without a zero velocity after which the solution is degraded, s.
    pub degraded_after: f64,
    /// Time without a zero velocity after which it is invalid, s, and stays so: where the foot went
    /// meanwhile is not known.
    pub invalid_after: f64,
    /// Longest gap that is bridged, s.  After a longer one the walk goes on from where it was, but
    /// is invalid.
    pub longest_gap: f64,
    /// Roll and pitch uncertainty above which a start in motion still degrades the solution, rad.
    pub tilt_limit: f64,
}

impl Default for HealthConfig {
    fn default() -> Self {
        Self {
            gap_intervals: 1.8,
            memory: 1.0,
            degraded_after: 3.0,
            invalid_after: 15.0,
            longest_gap: 1.0,
            tilt_limit: 0.03,
        }
    }
}

/// Frame in which files are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Frame {
    /// East, north, up.
    #[default]
    Enu,
    /// North, east, down.
    Ned,
}

/// Where the track lies and how it is written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OutputConfig {
    /// Geodetic latitude (degrees), longitude (degrees) and ellipsoidal height (m) of the start.
    pub origin: Option<[f64; 3]>,
    /// Frame of positions, velocities and attitudes in files.
    pub frame: Frame,
    /// Whether the strides are kept, with the covariance of each.
    pub strides: bool,
}

impl Config {
    /// Reads a configuration from TOML; absent settings keep their defaults.
    ///
    /// # Errors
    /// [`ConfigError`] for text that is not TOML, an unknown key, a value of the wrong type or out
    /// of range.
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        let config: Self =
            toml::from_str(text).map_err(|error| ConfigError::Syntax(error.to_string()))?;
        config.validate()?;
        Ok(config)
    }

    /// Gravity at the start, m/s².
    #[must_use]
    pub fn gravity(&self) -> f64 {
        let height = self.mechanization.height.or(self.output.origin.map(|o| o[2])).unwrap_or(0.0);
        self.mechanization
            .gravity
            .unwrap_or_else(|| earth::normal_gravity(self.latitude_deg().to_radians(), height))
    }

    /// Geodetic latitude that gravity and Earth rate are taken at, degrees.
    #[must_use]
    pub fn latitude_deg(&self) -> f64 {
        self.mechanization
            .latitude_deg
            .or(self.output.origin.map(|o| o[0]))
            .unwrap_or(DEFAULT_LATITUDE_DEG)
    }

    /// Whether anything is done to the track after the filter.
    pub(crate) fn post_processes(&self) -> bool {
        self.correction.kind != CorrectionKind::None || self.smoother.kind != SmootherKind::None
    }

    /// Checks that every stage can run in a stream.
    pub(crate) fn validate_for_streaming(&self) -> Result<(), ConfigError> {
        refinement::validate_for_streaming(&self.correction, &self.smoother)
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`ConfigError`] with the first setting that makes no sense, its value and what is allowed.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.sensor.validate()?;
        self.calibration.validate()?;
        self.alignment.validate()?;
        self.mechanization.validate()?;
        self.detector.validate()?;
        self.filter.validate()?;
        self.magnetometer.validate(&self.filter)?;
        self.smoother.validate()?;
        self.health.validate()?;
        self.output.validate()?;
        refinement::validate(&self.filter, &self.correction, &self.smoother)?;
        let heading_known =
            self.alignment.heading_deg.is_some() || self.alignment.magnetic_field.is_some();
        if self.mechanization.earth_rate && self.mechanization.kind == MechanizationKind::FirstOrder
        {
            return Err(ConfigError::Inconsistent(
                "mechanization.kind = \"first-order\" knows no rotation of the Earth: choose another kind or leave earth_rate out".into(),
            ));
        }
        if self.mechanization.earth_rate && !heading_known {
            return Err(ConfigError::Inconsistent(
                "mechanization.earth_rate needs to know where north is: set alignment.heading_deg or alignment.magnetic_field".into(),
            ));
        }
        Ok(())
    }
}

impl SensorConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        at_least_zero("sensor.gyro_noise_density", self.gyro_noise_density)?;
        at_least_zero("sensor.accel_noise_density", self.accel_noise_density)?;
        at_least_zero("sensor.gyro_bias_walk", self.gyro_bias_walk)?;
        at_least_zero("sensor.accel_bias_walk", self.accel_bias_walk)?;
        positive("sensor.gyro_bias_std", self.gyro_bias_std)?;
        positive("sensor.accel_bias_std", self.accel_bias_std)?;
        within("sensor.gyro_scale_std", self.gyro_scale_std, 0.0..=0.1, "between 0 and 0.1")?;
        within("sensor.accel_scale_std", self.accel_scale_std, 0.0..=0.1, "between 0 and 0.1")?;
        self.gyro_range.map_or(Ok(()), |range| positive("sensor.gyro_range", range))?;
        self.accel_range.map_or(Ok(()), |range| positive("sensor.accel_range", range))
    }
}

impl AlignmentConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        positive("alignment.duration", self.duration)?;
        within(
            "alignment.heading_deg",
            self.heading_deg.unwrap_or(0.0),
            -360.0..=360.0,
            "a number between -360 and 360",
        )?;
        within(
            "alignment.declination_deg",
            self.declination_deg,
            -180.0..=180.0,
            "a number between -180 and 180",
        )?;
        positive("alignment.rest_accel_std", self.rest_accel_std)?;
        positive("alignment.rest_gyro_std", self.rest_gyro_std)?;
        at_least_zero("alignment.fine_duration", self.fine_duration)?;
        positive("alignment.gyro_bias_std", self.gyro_bias_std)?;
        positive("alignment.tilt_std", self.tilt_std)?;
        within(
            "alignment.heading_std_deg",
            self.heading_std_deg,
            0.0..=180.0,
            "between 0 and 180",
        )?;
        if self.heading_deg.is_some() && self.magnetic_field.is_some() {
            return Err(ConfigError::Inconsistent(
                "alignment.heading_deg and alignment.magnetic_field both give the heading: keep one of them".into(),
            ));
        }
        Ok(())
    }
}

impl MechanizationConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        within(
            "mechanization.gravity",
            self.gravity.unwrap_or(9.8),
            9.0..=10.5,
            "between 9.0 and 10.5 m/s^2",
        )?;
        within(
            "mechanization.latitude_deg",
            self.latitude_deg.unwrap_or(0.0),
            -90.0..=90.0,
            "between -90 and 90",
        )?;
        within(
            "mechanization.height",
            self.height.unwrap_or(0.0),
            -12_000.0..=100_000.0,
            "metres between -12000 and 100000",
        )
    }
}

impl HealthConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        within("health.gap_intervals", self.gap_intervals, 1.5..=f64::MAX, "at least 1.5")?;
        at_least_zero("health.memory", self.memory)?;
        positive("health.degraded_after", self.degraded_after)?;
        positive("health.longest_gap", self.longest_gap)?;
        positive("health.tilt_limit", self.tilt_limit)?;
        within(
            "health.invalid_after",
            self.invalid_after,
            self.degraded_after..=f64::MAX,
            "at least health.degraded_after",
        )
    }
}

impl OutputConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        let [latitude, longitude, height] = self.origin.unwrap_or([0.0; 3]);
        within("output.origin latitude", latitude, -90.0..=90.0, "between -90 and 90")?;
        within("output.origin longitude", longitude, -180.0..=180.0, "between -180 and 180")?;
        within(
            "output.origin height",
            height,
            -12_000.0..=100_000.0,
            "metres between -12000 and 100000",
        )
    }
}
