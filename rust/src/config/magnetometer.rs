//! Settings of what a magnetometer tells.

use serde::{Deserialize, Serialize};

use crate::config::filter::{FilterConfig, FilterKind};
use crate::error::ConfigError;
use crate::limits::{positive, within};

/// The heading that a magnetometer holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MagnetometerConfig {
    /// Whether the field holds the heading.
    pub heading: bool,
    /// Standard deviation of the heading that the field of a stance shows, degrees: what bends it
    /// there and is not seen in its strength and dip.
    pub std_deg: f64,
    /// Share by which the strength of the field may differ from that at the start.
    pub strength_tolerance: f64,
    /// Angle by which its dip may, degrees.
    pub dip_tolerance_deg: f64,
}

impl Default for MagnetometerConfig {
    fn default() -> Self {
        Self { heading: false, std_deg: 10.0, strength_tolerance: 0.1, dip_tolerance_deg: 5.0 }
    }
}

impl MagnetometerConfig {
    pub(super) fn validate(&self, filter: &FilterConfig) -> Result<(), ConfigError> {
        within("magnetometer.std_deg", self.std_deg, 0.1..=90.0, "between 0.1 and 90")?;
        positive("magnetometer.strength_tolerance", self.strength_tolerance)?;
        positive("magnetometer.dip_tolerance_deg", self.dip_tolerance_deg)?;
        if self.heading && filter.kind != FilterKind::Kf {
            return Err(ConfigError::Inconsistent(
                "magnetometer.heading corrects the states of a Kalman filter: set filter.kind = \"kf\" or leave it out"
                    .into(),
            ));
        }
        Ok(())
    }
}
