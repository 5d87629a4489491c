//! Settings of every stage, in the order in which a sample meets the stages.
//!
//! The defaults here are the only ones: the Python layer shows the same values and a test compares the two.  Angles are in degrees only where the name says so.

use std::fmt::Display;

use serde::{Deserialize, Serialize};

use crate::calibration::Calibration;
use crate::earth;
use crate::error::ConfigError;
use crate::strapdown::MechanizationKind;

mod presets;

pub use presets::PRESETS;

/// Latitude (degrees) that gravity is taken from when neither gravity, latitude nor origin is known.  Gravity changes by 0.026 m/s² from there to
/// the equator or the poles, which the accelerometer biases absorb at the first rest.
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
    /// Rest that is averaged at the most, s.  A walk that starts sooner is aligned on the rest that there is.
    pub duration: f64,
    /// Form of the levelling equations.
    pub levelling: Levelling,
    /// Heading of `forward_axis` at the start, degrees clockwise from true north.  When it is absent and no magnetic field is given, n x is where
    /// `forward_axis` points.
    pub heading_deg: Option<f64>,
    /// Magnetic field at the start in the sensor frame, any unit: gives the heading instead of `heading_deg`.
    pub magnetic_field: Option<[f64; 3]>,
    /// Declination of the magnetic field, degrees east of true north.
    pub declination_deg: f64,
    /// Axis of the sensor that the heading belongs to.
    pub forward_axis: Axis,
    /// Greatest standard deviation of the specific force that still counts as rest, m/s².
    pub rest_accel_std: f64,
    /// Greatest standard deviation of the angular rate that still counts as rest, rad/s.
    pub rest_gyro_std: f64,
    /// Standard deviation of the gyroscope's bias after `duration` of rest, rad/s: a standing person sways.
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
            gyro_bias_std: 3.0e-3,
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
    /// Whether the Earth turns.  Needs a heading; a foot at rest resets what its rotation does in a stride.
    pub earth_rate: bool,
    /// Gravity, m/s²; from latitude and height when absent.
    pub gravity: Option<f64>,
    /// Geodetic latitude, degrees; from `output.origin`, or else [`DEFAULT_LATITUDE_DEG`], when absent.
    pub latitude_deg: Option<f64>,
    /// Height above the ellipsoid, m; from `output.origin`, or else 0, when absent.
    pub height: Option<f64>,
}

/// Which stance detector, and its settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum DetectorConfig {
    /// SHOE with a threshold that follows the stride: no tuning.
    AdaptiveShoe(AdaptiveShoeConfig),
    /// SHOE with a fixed threshold.
    Shoe(ShoeConfig),
    /// Magnitude and sliding variance of the specific force.
    MagnitudeVariance(MagnitudeVarianceConfig),
    /// Energies of specific force and angular rate.
    WindowedEnergies(WindowedEnergiesConfig),
    /// Magnitude of the specific force, without isolated detections and gaps.
    MagnitudeDebounced(MagnitudeDebouncedConfig),
    /// Magnitude, variance and rate, together or any of them.
    ThreeCondition(ThreeConditionConfig),
    /// Energy of the angular rate (ARE).
    AngularRateEnergy(AngularRateEnergyConfig),
    /// Moving variance of the specific force (MV).
    MovingVariance(MovingVarianceConfig),
    /// Magnitude of the specific force (MAG).
    AccelerationMagnitude(AccelerationMagnitudeConfig),
}

impl Default for DetectorConfig {
    fn default() -> Self {
        Self::AdaptiveShoe(AdaptiveShoeConfig::default())
    }
}

/// SHOE whose threshold is a multiple of the statistic's minimum around the sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AdaptiveShoeConfig {
    /// Length of the statistic's window, s.
    pub window: f64,
    /// Standard deviation that the specific force is weighed with, m/s².
    pub accel_std: f64,
    /// Standard deviation that the angular rate is weighed with, rad/s.
    pub gyro_std: f64,
    /// How far back the minimum is sought, s.
    pub look_behind: f64,
    /// How far ahead the minimum is sought, s; the detector's latency is this and half a window.
    pub look_ahead: f64,
    /// Multiple of the minimum up to which a sample is stationary.
    pub factor: f64,
    /// Statistic below which a sample is stationary however low the minimum is: at rest the minimum is mere noise.
    pub floor: f64,
    /// Statistic above which a sample is never stationary: a foot that is shaken all the time has minima too.
    pub ceiling: f64,
}

impl Default for AdaptiveShoeConfig {
    fn default() -> Self {
        Self {
            window: 0.05,
            accel_std: 0.02,
            gyro_std: 8.7e-3,
            look_behind: 0.6,
            look_ahead: 0.6,
            factor: 1.5,
            floor: 500.0,
            ceiling: 2.0e5,
        }
    }
}

/// SHOE with a fixed threshold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShoeConfig {
    /// Length of the window, s.
    pub window: f64,
    /// Standard deviation that the specific force is weighed with, m/s².
    pub accel_std: f64,
    /// Standard deviation that the angular rate is weighed with, rad/s.
    pub gyro_std: f64,
    /// Statistic below which a sample is stationary.
    pub threshold: f64,
}

impl Default for ShoeConfig {
    fn default() -> Self {
        Self { window: 0.025, accel_std: 0.02, gyro_std: 8.7e-3, threshold: 3.0e3 }
    }
}

/// Magnitude and sliding variance of the specific force.
///
/// The gates are the paper's 0.06, which it prints without a unit; in m/s² and m²/s⁴ they work on real recordings of an MPU6050, in g they do not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MagnitudeVarianceConfig {
    /// Length of the variance's window, s: 11 samples at 200 Hz in the paper.
    pub window: f64,
    /// Deviation of the magnitude from gravity (`Gate_B`) from which a sample moves, m/s².
    pub magnitude_gate: f64,
    /// Variance of the magnitude (`Gate_V`) from which a sample moves, m²/s⁴.
    pub variance_gate: f64,
}

impl Default for MagnitudeVarianceConfig {
    fn default() -> Self {
        Self { window: 0.055, magnitude_gate: 0.06, variance_gate: 0.06 }
    }
}

/// Energies of specific force and angular rate.
///
/// The window is the paper's, the rest was chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WindowedEnergiesConfig {
    /// Length of the window, s: 15 samples at 100 Hz in the paper.
    pub window: f64,
    /// Standard deviation that the specific force is weighed with, m/s².
    pub accel_std: f64,
    /// Standard deviation that the angular rate is weighed with, rad/s.
    pub gyro_std: f64,
    /// Energy of the specific force (`T_a`) from which a sample moves.
    pub accel_threshold: f64,
    /// Energy of the angular rate (`T_w`) from which a sample moves.
    pub gyro_threshold: f64,
}

impl Default for WindowedEnergiesConfig {
    fn default() -> Self {
        Self { window: 0.15, accel_std: 0.02, gyro_std: 8.7e-3, accel_threshold: 3.0e3, gyro_threshold: 6.0e3 }
    }
}

/// Magnitude of the specific force, without isolated detections and gaps.
///
/// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU; the paper prints none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MagnitudeDebouncedConfig {
    /// Deviation of the magnitude from gravity from which a sample moves, m/s².
    pub magnitude_gate: f64,
    /// Gap between detections up to which it is not believed, s.
    pub longest_gap: f64,
    /// Detection below which it is not believed, s; the detector's latency is this and the longest gap.
    pub shortest_stance: f64,
}

impl Default for MagnitudeDebouncedConfig {
    fn default() -> Self {
        Self { magnitude_gate: 0.3, longest_gap: 0.02, shortest_stance: 0.15 }
    }
}

/// A condition of the three-condition detector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Condition {
    /// C1: |f| within a band around gravity.
    Magnitude,
    /// C2: variance of |f| below a threshold.
    Variance,
    /// C3: |ω| below a threshold.
    Rate,
}

/// Magnitude, variance and rate, together or any of them.
///
/// The defaults were chosen for all three together on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU; the paper prints none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ThreeConditionConfig {
    /// The conditions that must hold: one or more, each once.
    pub conditions: Vec<Condition>,
    /// Length of the variance's window, s; the other conditions look at its centre.
    pub window: f64,
    /// Deviation of the magnitude from gravity from which a sample moves, m/s².
    pub magnitude_band: f64,
    /// Variance of the magnitude from which a sample moves, m²/s⁴.
    pub variance_threshold: f64,
    /// Angular rate from which a sample moves, rad/s.
    pub rate_threshold: f64,
}

impl Default for ThreeConditionConfig {
    fn default() -> Self {
        Self {
            conditions: vec![Condition::Magnitude, Condition::Variance, Condition::Rate],
            window: 0.15,
            magnitude_band: 0.3,
            variance_threshold: 0.5,
            rate_threshold: 0.5,
        }
    }
}

/// Energy of the angular rate (ARE).
///
/// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AngularRateEnergyConfig {
    /// Length of the window, s.
    pub window: f64,
    /// Mean square of the angular rate up to which a sample is stationary, rad²/s².
    pub threshold: f64,
}

impl Default for AngularRateEnergyConfig {
    fn default() -> Self {
        Self { window: 0.1, threshold: 0.8 }
    }
}

/// Moving variance of the specific force (MV).
///
/// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MovingVarianceConfig {
    /// Length of the window, s.
    pub window: f64,
    /// Variance of the specific force, summed over the axes, up to which a sample is stationary, m²/s⁴.
    pub threshold: f64,
}

impl Default for MovingVarianceConfig {
    fn default() -> Self {
        Self { window: 0.15, threshold: 0.2 }
    }
}

/// Magnitude of the specific force (MAG).
///
/// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AccelerationMagnitudeConfig {
    /// Length of the window, s.
    pub window: f64,
    /// Mean square of |f| - g up to which a sample is stationary, m²/s⁴.
    pub threshold: f64,
}

impl Default for AccelerationMagnitudeConfig {
    fn default() -> Self {
        Self { window: 0.1, threshold: 0.1 }
    }
}

/// The error-state filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FilterConfig {
    /// Noise density of the specific force beyond the sensor's own, m/s²/√Hz: shock, bandwidth, scale and timing of a foot in motion.
    pub specific_force_noise: f64,
    /// Noise density of the angular rate beyond the sensor's own, rad/s/√Hz.
    pub angular_rate_noise: f64,
    /// Factor by which both grow at a sample that clips.
    pub clipped_noise_factor: f64,
    /// Standard deviation of a foot's velocity in stance, m/s.
    pub zero_velocity_std: f64,
    /// Distance (m) of the sensor from what the foot rolls about: the velocity of a foot in stance is uncertain by this times its angular rate.
    pub zero_velocity_lever: f64,
    /// Squared Mahalanobis distance of a zero velocity or zero angular rate from the prediction beyond which it is rejected.
    pub innovation_gate: f64,
    /// Time in stance, over one or several of them, with nothing but rejections after which a zero velocity is believed all the same, s: the foot stands and
    /// the filter is wrong.
    pub rejection_limit: f64,
    /// Whether rest corrects the gyroscope's bias.
    pub zero_angular_rate: bool,
    /// Standard deviation of a foot's angular rate at rest, rad/s.
    pub zero_angular_rate_std: f64,
    /// Angular rate below which the foot may be at rest, rad/s.
    pub rest_rate: f64,
    /// How long the angular rate must have stayed below that, s.
    pub rest_duration: f64,
}

impl Default for FilterConfig {
    fn default() -> Self {
        Self {
            specific_force_noise: 0.1,
            angular_rate_noise: 6.0e-4,
            clipped_noise_factor: 30.0,
            zero_velocity_std: 0.01,
            zero_velocity_lever: 0.03,
            innovation_gate: 1.0e3,
            rejection_limit: 0.1,
            zero_angular_rate: true,
            zero_angular_rate_std: 0.02,
            rest_rate: 0.05,
            rest_duration: 0.5,
        }
    }
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
    /// Time without a zero velocity after which it is invalid, s, and stays so: where the foot went meanwhile is not known.
    pub invalid_after: f64,
    /// Longest gap that is bridged, s.  After a longer one the walk goes on from where it was, but is invalid.
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
}

impl Config {
    /// Reads a configuration from TOML; absent settings keep their defaults.
    ///
    /// # Errors
    /// [`ConfigError`] for text that is not TOML, an unknown key, a value of the wrong type or out of range.
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        let config: Self = toml::from_str(text).map_err(|error| ConfigError::Syntax(error.to_string()))?;
        config.validate()?;
        Ok(config)
    }

    /// Gravity at the start, m/s².
    #[must_use]
    pub fn gravity(&self) -> f64 {
        let height = self.mechanization.height.or(self.output.origin.map(|o| o[2])).unwrap_or(0.0);
        self.mechanization.gravity.unwrap_or_else(|| earth::normal_gravity(self.latitude_deg().to_radians(), height))
    }

    /// Geodetic latitude that gravity and Earth rate are taken at, degrees.
    #[must_use]
    pub fn latitude_deg(&self) -> f64 {
        self.mechanization.latitude_deg.or(self.output.origin.map(|o| o[0])).unwrap_or(DEFAULT_LATITUDE_DEG)
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
        self.health.validate()?;
        self.output.validate()?;
        let heading_known = self.alignment.heading_deg.is_some() || self.alignment.magnetic_field.is_some();
        if self.mechanization.earth_rate && self.mechanization.kind == MechanizationKind::FirstOrder {
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
            -360.0,
            360.0,
            "a number between -360 and 360",
        )?;
        within("alignment.declination_deg", self.declination_deg, -180.0, 180.0, "a number between -180 and 180")?;
        positive("alignment.rest_accel_std", self.rest_accel_std)?;
        positive("alignment.rest_gyro_std", self.rest_gyro_std)?;
        positive("alignment.gyro_bias_std", self.gyro_bias_std)?;
        positive("alignment.tilt_std", self.tilt_std)?;
        within("alignment.heading_std_deg", self.heading_std_deg, 0.0, 180.0, "between 0 and 180")?;
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
        within("mechanization.gravity", self.gravity.unwrap_or(9.8), 9.0, 10.5, "between 9.0 and 10.5 m/s^2")?;
        within("mechanization.latitude_deg", self.latitude_deg.unwrap_or(0.0), -90.0, 90.0, "between -90 and 90")?;
        within(
            "mechanization.height",
            self.height.unwrap_or(0.0),
            -12_000.0,
            100_000.0,
            "metres between -12000 and 100000",
        )
    }
}

impl DetectorConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        match self {
            Self::AdaptiveShoe(shoe) => shoe.validate(),
            Self::Shoe(shoe) => shoe.validate(),
            Self::MagnitudeVariance(settings) => settings.validate(),
            Self::WindowedEnergies(settings) => settings.validate(),
            Self::MagnitudeDebounced(settings) => settings.validate(),
            Self::ThreeCondition(settings) => settings.validate(),
            Self::AngularRateEnergy(settings) => settings.validate(),
            Self::MovingVariance(settings) => settings.validate(),
            Self::AccelerationMagnitude(settings) => settings.validate(),
        }
    }
}

impl AdaptiveShoeConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.accel_std", self.accel_std)?;
        positive("detector.gyro_std", self.gyro_std)?;
        within("detector.look_behind", self.look_behind, 0.0, 10.0, "between 0 and 10 s")?;
        within("detector.look_ahead", self.look_ahead, 0.0, 10.0, "between 0 and 10 s")?;
        within("detector.factor", self.factor, 1.0, f64::MAX, "at least 1")?;
        at_least_zero("detector.floor", self.floor)?;
        within("detector.ceiling", self.ceiling, self.floor, f64::MAX, "at least detector.floor")
    }
}

impl ShoeConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.accel_std", self.accel_std)?;
        positive("detector.gyro_std", self.gyro_std)?;
        positive("detector.threshold", self.threshold)
    }
}

impl MagnitudeVarianceConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.magnitude_gate", self.magnitude_gate)?;
        positive("detector.variance_gate", self.variance_gate)
    }
}

impl WindowedEnergiesConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.accel_std", self.accel_std)?;
        positive("detector.gyro_std", self.gyro_std)?;
        positive("detector.accel_threshold", self.accel_threshold)?;
        positive("detector.gyro_threshold", self.gyro_threshold)
    }
}

impl MagnitudeDebouncedConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        positive("detector.magnitude_gate", self.magnitude_gate)?;
        within("detector.longest_gap", self.longest_gap, 0.0, 10.0, "between 0 and 10 s")?;
        within("detector.shortest_stance", self.shortest_stance, 0.0, 10.0, "between 0 and 10 s")
    }
}

impl ThreeConditionConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        let all = [Condition::Magnitude, Condition::Variance, Condition::Rate];
        let used = all.iter().filter(|condition| self.conditions.contains(condition)).count();
        check(
            used > 0 && used == self.conditions.len(),
            "detector.conditions",
            format!("{:?}", self.conditions).to_lowercase(),
            "one or more of magnitude, variance and rate, each once",
        )?;
        window("detector.window", self.window)?;
        positive("detector.magnitude_band", self.magnitude_band)?;
        positive("detector.variance_threshold", self.variance_threshold)?;
        positive("detector.rate_threshold", self.rate_threshold)
    }
}

impl AngularRateEnergyConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.threshold", self.threshold)
    }
}

impl MovingVarianceConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.threshold", self.threshold)
    }
}

impl AccelerationMagnitudeConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.threshold", self.threshold)
    }
}

impl FilterConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        at_least_zero("filter.specific_force_noise", self.specific_force_noise)?;
        at_least_zero("filter.angular_rate_noise", self.angular_rate_noise)?;
        within("filter.clipped_noise_factor", self.clipped_noise_factor, 1.0, f64::MAX, "at least 1")?;
        positive("filter.zero_velocity_std", self.zero_velocity_std)?;
        at_least_zero("filter.zero_velocity_lever", self.zero_velocity_lever)?;
        positive("filter.innovation_gate", self.innovation_gate)?;
        at_least_zero("filter.rejection_limit", self.rejection_limit)?;
        positive("filter.zero_angular_rate_std", self.zero_angular_rate_std)?;
        positive("filter.rest_rate", self.rest_rate)?;
        positive("filter.rest_duration", self.rest_duration)
    }
}

impl HealthConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        within("health.gap_intervals", self.gap_intervals, 1.5, f64::MAX, "at least 1.5")?;
        at_least_zero("health.memory", self.memory)?;
        positive("health.degraded_after", self.degraded_after)?;
        positive("health.longest_gap", self.longest_gap)?;
        positive("health.tilt_limit", self.tilt_limit)?;
        within(
            "health.invalid_after",
            self.invalid_after,
            self.degraded_after,
            f64::MAX,
            "at least health.degraded_after",
        )
    }
}

impl OutputConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        let [latitude, longitude, height] = self.origin.unwrap_or([0.0; 3]);
        within("output.origin latitude", latitude, -90.0, 90.0, "between -90 and 90")?;
        within("output.origin longitude", longitude, -180.0, 180.0, "between -180 and 180")?;
        within("output.origin height", height, -12_000.0, 100_000.0, "metres between -12000 and 100000")
    }
}

fn check(allowed: bool, key: &'static str, value: impl Display, expected: &'static str) -> Result<(), ConfigError> {
    if allowed { Ok(()) } else { Err(ConfigError::OutOfRange { key, value: value.to_string(), expected }) }
}

fn positive(key: &'static str, value: f64) -> Result<(), ConfigError> {
    check(value > 0.0 && value.is_finite(), key, value, "a positive number")
}

fn at_least_zero(key: &'static str, value: f64) -> Result<(), ConfigError> {
    check(value >= 0.0 && value.is_finite(), key, value, "zero or a positive number")
}

fn within(key: &'static str, value: f64, low: f64, high: f64, expected: &'static str) -> Result<(), ConfigError> {
    check((low..=high).contains(&value), key, value, expected)
}

fn window(key: &'static str, value: f64) -> Result<(), ConfigError> {
    within(key, value, 1.0e-4, 10.0, "between 0.0001 and 10 s")
}
