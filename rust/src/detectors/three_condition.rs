//! Three conditions that must hold together: magnitude, variance, rate.
//!
//! # References
//! Wang, Yang, Luo, Pi, "Pedestrian navigation algorithm based on MEMS-IMU", J. Chinese Inertial
//! Technology 24(4):460, 2016: conditions C1 (AMD), C2 (AMVD) and C3 (ARMD); fig. 3 compares them.

use crate::config::{Condition, ThreeConditionConfig};
use crate::detectors::detector::{Decision, magnitude_excess};
use crate::detectors::sliding_window::variance;
use crate::detectors::window_test::WindowTest;
use crate::types::sample::ImuSample;

/// Stationary where |f| is near gravity, its variance around the sample is low, and |ω| is low; or
/// where those of them hold that are used.
///
/// The statistic is the largest of the three quantities in units of their thresholds, so its
/// threshold is one.
#[derive(Clone, Debug)]
pub(crate) struct ThreeCondition {
    gravity: f64,
    /// Thresholds; infinite for a condition that is not used, which always holds then.
    magnitude_band: f64,
    variance_threshold: f64,
    rate_threshold: f64,
}

impl ThreeCondition {
    pub(crate) fn new(config: &ThreeConditionConfig, gravity: f64) -> Self {
        let used = |condition, threshold| {
            if config.conditions.contains(&condition) { threshold } else { f64::INFINITY }
        };
        Self {
            gravity,
            magnitude_band: used(Condition::Magnitude, config.magnitude_band),
            variance_threshold: used(Condition::Variance, config.variance_threshold),
            rate_threshold: used(Condition::Rate, config.rate_threshold),
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
