//! Magnitude and sliding variance of the specific force.
//!
//! # References
//! Wu, Lu, Chen, "Research on Foot-Mounted Personal Navigation Algorithm based on MEMS Inertial
//! Sensors": eqs. 4-5.

use crate::detectors::detector::{Decision, Detector, DetectorSettings, magnitude_excess};
use crate::detectors::sliding_window::{WINDOW_LIMITS, variance};
use crate::detectors::windowed_detector::{WindowTest, WindowedDetector};
use crate::limits::Limits;
use crate::settings::settings;
use crate::types::sample::ImuSample;

settings! {
    /// Magnitude and sliding variance of the specific force (Wu et al., eqs. 4-5).
    ///
    /// The gates are the paper's 0.06, which it prints without a unit; in m/s² and m²/s⁴ they work
    /// on real recordings of an MPU6050, in g they do not.
    pub struct MagnitudeVarianceConfig: "detector" {
        /// Length of the variance's window: 11 samples at 200 Hz in the paper.
        window: f64 = 0.055, "s", WINDOW_LIMITS;
        /// Deviation of the magnitude from gravity (`Gate_B`) from which a sample moves.
        magnitude_gate: f64 = 0.06, "m/s²", Limits::Positive;
        /// Variance of the magnitude (`Gate_V`) from which a sample moves.
        variance_gate: f64 = 0.06, "m²/s⁴", Limits::Positive;
    }
}

impl DetectorSettings for MagnitudeVarianceConfig {
    fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector> {
        let test = MagnitudeVariance::new(self, gravity);
        Box::new(WindowedDetector::new(self.window, rate_hz, test))
    }
}

/// Stationary where the magnitude is near gravity and its variance in the window is low.
///
/// The statistic is the larger of the two quantities in units of their gates; its threshold is 1.
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
