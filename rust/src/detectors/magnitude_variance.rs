//! Magnitude and sliding variance of the specific force.
//!
//! # References
//! Wu, Lu, Chen, "Research on Foot-Mounted Personal Navigation Algorithm based on MEMS Inertial
//! Sensors": eqs. 4-5.

use crate::config::MagnitudeVarianceConfig;
use crate::detectors::detector::{Decision, magnitude_excess};
use crate::detectors::sliding_window::variance;
use crate::detectors::window_test::WindowTest;
use crate::types::sample::ImuSample;

/// Stationary where the magnitude is near gravity and varies little around the sample.
///
/// The statistic is the max_nan of both quantities in units of their gates, so its threshold is
/// one.
#[derive(Clone, Debug)]
pub(crate) struct MagnitudeVariance {
    gravity: f64,
    magnitude_gate: f64,
    variance_gate: f64,
}

impl MagnitudeVariance {
    pub(crate) fn new(config: &MagnitudeVarianceConfig, gravity: f64) -> Self {
        Self { gravity, magnitude_gate: config.magnitude_gate, variance_gate: config.variance_gate }
    }
}

impl WindowTest<2> for MagnitudeVariance {
    fn row(&self, sample: &ImuSample) -> [f64; 2] {
        let excess = magnitude_excess(sample, self.gravity);
        [excess, excess * excess]
    }

    fn decide(&self, size: f64, &[sum, squares]: &[f64; 2], &[excess, _]: &[f64; 2]) -> Decision {
        let variance = variance(sum, squares, size);
        Decision::all_below([excess.abs() / self.magnitude_gate, variance / self.variance_gate])
    }
}
