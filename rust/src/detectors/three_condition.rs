//! Conjunction of three conditions: magnitude, variance, rate.
//!
//! # References
//! Wang, Yang, Luo, Pi, "Pedestrian navigation algorithm based on MEMS-IMU", J. Chinese Inertial
//! Technology 24(4):460, 2016: conditions C1 (AMD), C2 (AMVD) and C3 (ARMD); fig. 3 compares them.

use crate::detectors::detector::{Decision, Detector, DetectorSettings, magnitude_excess};
use crate::detectors::sliding_window::{WINDOW_LIMITS, variance};
use crate::detectors::windowed_detector::{WindowTest, WindowedDetector};
use crate::error::ConfigError;
use crate::limits::Limits;
use crate::settings::{Value, choices, settings};
use crate::types::sample::ImuSample;

choices! {
    /// A condition of the three-condition detector.
    pub enum Condition {
        /// C1: |f| within a band around gravity.
        Magnitude = "magnitude",
        /// C2: variance of |f| below a threshold.
        Variance = "variance",
        /// C3: |ω| below a threshold.
        Rate = "rate",
    }
}

settings! {
    /// Magnitude, variance and rate, together or any of them (Wang Libing et al. 2016).
    ///
    /// The defaults were chosen for all three together on real walks with a VN-100, an MPU6050, an
    /// NGIMU and OpenShoe's IMU; the paper prints none.
    pub struct ThreeConditionConfig: "detector", also has_distinct_conditions {
        /// Conditions that must hold: one or more, each once.
        conditions: Vec<Condition> = ALL.to_vec();
        /// Length of the variance's window; the other conditions are those of its centre.
        window: f64 = 0.15, "s", WINDOW_LIMITS;
        /// Deviation of the magnitude from gravity from which a sample moves.
        magnitude_band: f64 = 0.3, "m/s²", Limits::Positive;
        /// Variance of the magnitude from which a sample moves.
        variance_threshold: f64 = 0.5, "m²/s⁴", Limits::Positive;
        /// Angular rate from which a sample moves.
        rate_threshold: f64 = 0.5, "rad/s", Limits::Positive;
    }
}

const ALL: [Condition; 3] = [Condition::Magnitude, Condition::Variance, Condition::Rate];

impl ThreeConditionConfig {
    fn has_distinct_conditions(&self) -> Result<(), ConfigError> {
        let used = ALL.iter().filter(|condition| self.conditions.contains(condition)).count();
        if used > 0 && used == self.conditions.len() {
            return Ok(());
        }
        Err(ConfigError::OutOfRange {
            key: "detector.conditions",
            value: self.conditions.literal().to_string(),
            expected: "one or more of magnitude, variance and rate, each once".into(),
        })
    }
}

impl DetectorSettings for ThreeConditionConfig {
    fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector> {
        let test = ThreeCondition::new(self, gravity);
        Box::new(WindowedDetector::new(self.window, rate_hz, test))
    }
}

/// Stationary where |f| is near gravity, its variance in the window is low and |ω| is low, or where
/// the selected conditions hold.
///
/// The statistic is the largest of the three quantities in units of their thresholds, with the
/// threshold 1.
#[derive(Clone, Debug)]
pub(crate) struct ThreeCondition {
    gravity: f64,
    /// Thresholds; infinite for a condition that is not selected.
    magnitude_band: f64,
    variance_threshold: f64,
    rate_threshold: f64,
}

impl ThreeCondition {
    pub(crate) fn new(config: &ThreeConditionConfig, gravity: f64) -> Self {
        let selected = |condition, threshold| {
            if config.conditions.contains(&condition) { threshold } else { f64::INFINITY }
        };
        Self {
            gravity,
            magnitude_band: selected(Condition::Magnitude, config.magnitude_band),
            variance_threshold: selected(Condition::Variance, config.variance_threshold),
            rate_threshold: selected(Condition::Rate, config.rate_threshold),
        }
    }
}

impl WindowTest<3> for ThreeCondition {
    fn row(&self, sample: &ImuSample) -> [f64; 3] {
        let excess = magnitude_excess(sample, self.gravity);
        [excess, excess * excess, sample.angular_rate.norm()]
    }

    fn decide(
        &self,
        size: f64,
        &[sum, squares, _]: &[f64; 3],
        &[excess, _, rate]: &[f64; 3],
    ) -> Decision {
        let variance = variance(sum, squares, size);
        Decision::all_below([
            excess.abs() / self.magnitude_band,
            variance / self.variance_threshold,
            rate / self.rate_threshold,
        ])
    }
}
