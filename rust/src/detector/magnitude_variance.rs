//! Magnitude and sliding variance of the specific force.
//!
//! # References
//! Wu, Lu, Chen, "Research on Foot-Mounted Personal Navigation Algorithm based on MEMS Inertial Sensors": eqs. 4-5.

use crate::config::MagnitudeVarianceConfig;
use crate::detector::window::{Centred, Window};
use crate::detector::{Decision, Detector};
use crate::sample::ImuSample;

/// Stationary where the magnitude is near gravity and varies little around the sample.
///
/// The statistic is the larger of both quantities in units of their gates, so its threshold is one.
#[derive(Clone, Debug)]
pub struct MagnitudeVariance {
    /// Sums of |f| - g and its square.
    window: Window<2>,
    gravity: f64,
    magnitude_gate: f64,
    variance_gate: f64,
}

impl MagnitudeVariance {
    /// A detector for samples at `rate_hz`, with gravity in m/s².
    #[must_use]
    pub fn new(config: &MagnitudeVarianceConfig, rate_hz: f64, gravity: f64) -> Self {
        Self {
            window: Window::new(config.window, rate_hz),
            gravity,
            magnitude_gate: config.magnitude_gate,
            variance_gate: config.variance_gate,
        }
    }
}

impl Detector for MagnitudeVariance {
    fn latency(&self) -> usize {
        self.window.half()
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        let size = self.window.size();
        let excess = sample.specific_force.norm() - self.gravity;
        match self.window.push([excess, excess * excess])? {
            Centred::Filling => Some(Decision::UNKNOWN),
            Centred::Full { sums: [sum, squares], centre: [bias, _] } => {
                let variance = squares / size - (sum / size).powi(2);
                let statistic = (bias.abs() / self.magnitude_gate).max(variance / self.variance_gate);
                Some(Decision { statistic, threshold: 1.0, stationary: statistic < 1.0 })
            }
        }
    }

    fn drain(&mut self) -> Option<Decision> {
        self.window.drain().then_some(Decision::UNKNOWN)
    }

    fn reset(&mut self) {
        self.window.reset();
    }
}
