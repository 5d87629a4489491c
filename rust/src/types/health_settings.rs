//! Settings of the solution's health.

use crate::error::ConfigError;
use crate::limits::Limits;
use crate::settings::settings;

settings! {
    /// Limits beyond which a solution is degraded or invalid.
    pub struct HealthConfig: "health", also timeouts_in_order {
        /// Interval that counts as a gap, in nominal intervals.
        gap_intervals: f64 = 1.8, "", Limits::AtLeast(1.5);
        /// Time for which a gap, a clipped sample or a rejected update degrades the solution.
        memory: f64 = 1.0, "s", Limits::NonNegative;
        /// Time without a zero velocity after which the solution is degraded.
        degraded_after: f64 = 3.0, "s", Limits::Positive;
        /// Time without a zero velocity after which the solution is invalid, for the rest of the
        /// walk; at least `degraded_after`.
        invalid_after: f64 = 15.0, "s", Limits::Positive;
        /// Longest gap that is bridged.  After a longer one the walk continues from the last state,
        /// and is invalid.
        longest_gap: f64 = 1.0, "s", Limits::Positive;
        /// Roll and pitch uncertainty above which a start in motion degrades the solution.
        tilt_limit: f64 = 0.03, "rad", Limits::Positive;
    }
}

impl HealthConfig {
    fn timeouts_in_order(&self) -> Result<(), ConfigError> {
        if self.invalid_after >= self.degraded_after {
            return Ok(());
        }
        Err(ConfigError::OutOfRange {
            key: "health.invalid_after",
            value: self.invalid_after.to_string(),
            expected: "at least health.degraded_after".into(),
        })
    }
}
