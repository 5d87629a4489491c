//! Settings of every stage, in processing order.
//!
//! Each section is declared next to the stage that uses it.  Angles are in rad, except in settings
//! whose name ends in `_deg`.

use serde::{Deserialize, Serialize};

use crate::error::ConfigError;
use crate::ins::earth;
use crate::limits::Limits;
use crate::settings::{Section, check, choices, settings};

mod consistency;
mod presets;

pub use crate::aiding::magnetometer_settings::MagnetometerConfig;
pub use crate::calibration::Calibration;
pub use crate::detectors::registry::*;
pub use crate::detectors::three_condition::Condition;
pub use crate::filter::settings::{AttitudeUpdate, FilterConfig, FilterKind};
pub use crate::gait::correction::{CorrectionConfig, CorrectionKind};
pub use crate::ins::alignment::{AlignmentConfig, Axis, Levelling};
pub use crate::ins::mechanization::MechanizationConfig;
pub use crate::smoother::settings::{SmootherConfig, SmootherKind};
pub use crate::types::health_settings::HealthConfig;
pub use crate::types::sensor::SensorConfig;
pub use presets::PRESETS;

/// Latitude (degrees) for gravity when neither gravity, latitude nor origin is set.  Gravity
/// differs by 0.026 m/s² at the equator and the poles; the accelerometer biases absorb the
/// difference at the first rest.
pub const DEFAULT_LATITUDE_DEG: f64 = 45.0;

/// All settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Noise, biases and ranges of the inertial measurement unit.
    pub sensor: SensorConfig,
    /// Calibration of the raw readings.
    pub calibration: Calibration,
    /// Initial alignment: rest, levelling, heading.
    pub alignment: AlignmentConfig,
    /// Strapdown mechanization and Earth model.
    pub mechanization: MechanizationConfig,
    /// The stance detector.
    pub detector: DetectorConfig,
    /// The error-state filter.
    pub filter: FilterConfig,
    /// Heading updates from a magnetometer.
    pub magnetometer: MagnetometerConfig,
    /// Corrections of each gait cycle.
    pub correction: CorrectionConfig,
    /// Smoothing of the estimates.
    pub smoother: SmootherConfig,
    /// Limits of a degraded and of an invalid solution.
    pub health: HealthConfig,
    /// Origin of the track and frame of the files.
    pub output: OutputConfig,
}

choices! {
    /// Frame of files.
    pub enum Frame {
        /// East, north, up.
        Enu = "enu",
        /// North, east, down.
        Ned = "ned",
    }
}

settings! {
    /// Location of the track on the Earth, and the content of files.
    pub struct OutputConfig: "output", also starts_on_earth {
        /// Geodetic latitude and longitude in degrees and ellipsoidal height in m of the start.
        origin: Option<[f64; 3]> = None, "", Limits::Finite;
        /// Frame of positions, velocities and attitudes in files.
        frame: Frame = Frame::Enu;
        /// Whether the strides are kept, with the covariance of each.
        strides: bool = false;
    }
}

impl OutputConfig {
    fn starts_on_earth(&self) -> Result<(), ConfigError> {
        let [latitude, longitude, height] = self.origin.unwrap_or_default();
        check("output.origin latitude", &latitude, "degrees", Limits::Between(-90.0, 90.0))?;
        check("output.origin longitude", &longitude, "degrees", Limits::Between(-180.0, 180.0))?;
        check("output.origin height", &height, "m", Limits::Between(-12_000.0, 100_000.0))
    }
}

impl Config {
    /// The default settings with the noise and bias figures of a known sensor.
    ///
    /// # Errors
    /// [`ConfigError::UnknownPreset`], listing the known names.
    pub fn preset(name: &str) -> Result<Self, ConfigError> {
        Ok(Self { sensor: presets::sensor(name)?, ..Self::default() })
    }

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

    /// Geodetic latitude for gravity and Earth rate, degrees.
    #[must_use]
    pub fn latitude_deg(&self) -> f64 {
        self.mechanization
            .latitude_deg
            .or(self.output.origin.map(|o| o[0]))
            .unwrap_or(DEFAULT_LATITUDE_DEG)
    }

    /// Whether a correction or a smoother runs after the filter.
    pub(crate) fn post_processes(&self) -> bool {
        self.correction.kind != CorrectionKind::None || self.smoother.kind != SmootherKind::None
    }

    /// Checks that every stage can run in a stream.
    pub(crate) fn validate_for_streaming(&self) -> Result<(), ConfigError> {
        consistency::streamable(&self.correction, &self.smoother)
    }

    /// Checks every setting, and the settings against each other.
    ///
    /// # Errors
    /// [`ConfigError`] with the first invalid setting, its value and its limits.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.sensor.validate()?;
        self.calibration.validate()?;
        self.alignment.validate()?;
        self.mechanization.validate()?;
        self.detector.validate()?;
        self.filter.validate()?;
        self.magnetometer.validate()?;
        self.correction.validate()?;
        self.smoother.validate()?;
        self.health.validate()?;
        self.output.validate()?;
        consistency::heading_is_filtered(&self.magnetometer, &self.filter)?;
        consistency::stances_are_used_once(&self.filter, &self.correction, &self.smoother)?;
        consistency::earth_rate_is_known(&self.mechanization, &self.alignment)
    }

    /// All sections in order, with one section per detector.
    #[must_use]
    pub fn schema() -> Vec<Section> {
        let mut sections = vec![
            SensorConfig::schema(),
            Calibration::schema(),
            AlignmentConfig::schema(),
            MechanizationConfig::schema(),
        ];
        sections.extend(DetectorConfig::schemas());
        sections.extend([
            FilterConfig::schema(),
            MagnetometerConfig::schema(),
            CorrectionConfig::schema(),
            SmootherConfig::schema(),
            HealthConfig::schema(),
            OutputConfig::schema(),
        ]);
        sections
    }
}
