//! MV: the moving variance of the specific force.
//!
//! # References
//! Skog, Händel, Nilsson, Rantakokko 2010: the acceleration-moving variance detector, with the
//! accelerometer's variance left to the threshold.  The sum over
//! |f - mean(f)|² is Σ|f|² - |Σf|²/W.

use nalgebra::Vector3;

use crate::detectors::detector::{Decision, Detector, DetectorSettings};
use crate::detectors::sliding_window::{WINDOW_LIMITS, at_least_zero};
use crate::detectors::windowed_detector::{WindowTest, WindowedDetector};
use crate::limits::Limits;
use crate::settings::settings;
use crate::types::sample::ImuSample;

settings! {
    /// Moving variance of the specific force: MV of Skog et al. 2010.
    ///
    /// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's
    /// IMU.
    pub struct MovingVarianceConfig: "detector" {
        /// Length of the window.
        window: f64 = 0.15, "s", WINDOW_LIMITS;
        /// Variance of the specific force, summed over the axes, up to which a sample is
        /// stationary.
        threshold: f64 = 0.2, "m²/s⁴", Limits::Positive;
    }
}

impl DetectorSettings for MovingVarianceConfig {
    fn build(&self, rate_hz: f64, _: f64) -> Box<dyn Detector> {
        Box::new(WindowedDetector::new(self.window, rate_hz, MovingVariance::new(self)))
    }
}

/// Stationary where the variance of the vector f over the window, the sum of its axes', is low.
#[derive(Clone, Debug)]
pub(crate) struct MovingVariance {
    threshold: f64,
}

impl MovingVariance {
    pub(crate) fn new(config: &MovingVarianceConfig) -> Self {
        Self { threshold: config.threshold }
    }
}

impl WindowTest<4> for MovingVariance {
    fn row(&self, sample: &ImuSample) -> [f64; 4] {
        let f = &sample.specific_force;
        [f.x, f.y, f.z, f.norm_squared()]
    }

    fn decide(&self, size: f64, &[x, y, z, squares]: &[f64; 4], _: &[f64; 4]) -> Decision {
        let mean = Vector3::new(x, y, z) / size;
        Decision::threshold_at(self.threshold, at_least_zero(squares / size - mean.norm_squared()))
    }
}
