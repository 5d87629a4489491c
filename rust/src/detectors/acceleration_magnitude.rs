//! MAG: the magnitude of the specific force.
//!
//! # References
//! Skog, Händel, Nilsson, Rantakokko 2010: the acceleration-magnitude detector, with the
//! accelerometer's variance left to the threshold.

use crate::detectors::detector::{Decision, Detector, DetectorSettings, magnitude_excess};
use crate::detectors::sliding_window::WINDOW_LIMITS;
use crate::detectors::windowed_detector::{WindowTest, WindowedDetector};
use crate::limits::Limits;
use crate::settings::settings;
use crate::types::sample::ImuSample;

settings! {
    /// Magnitude of the specific force: MAG of Skog et al. 2010.
    ///
    /// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's
    /// IMU.
    pub struct AccelerationMagnitudeConfig: "detector" {
        /// Length of the window.
        window: f64 = 0.1, "s", WINDOW_LIMITS;
        /// Mean square of the magnitude less gravity up to which a sample is stationary.
        threshold: f64 = 0.1, "m²/s⁴", Limits::Positive;
    }
}

impl DetectorSettings for AccelerationMagnitudeConfig {
    fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector> {
        let test = AccelerationMagnitude::new(self, gravity);
        Box::new(WindowedDetector::new(self.window, rate_hz, test))
    }
}

/// Stationary where the mean of (|f| - g)² over the window is low.
#[derive(Clone, Debug)]
pub(crate) struct AccelerationMagnitude {
    gravity: f64,
    threshold: f64,
}

impl AccelerationMagnitude {
    pub(crate) fn new(config: &AccelerationMagnitudeConfig, gravity: f64) -> Self {
        Self { gravity, threshold: config.threshold }
    }
}

impl WindowTest<1> for AccelerationMagnitude {
    fn row(&self, sample: &ImuSample) -> [f64; 1] {
        [magnitude_excess(sample, self.gravity).powi(2)]
    }

    fn decide(&self, size: f64, &[squares]: &[f64; 1], _: &[f64; 1]) -> Decision {
        Decision::threshold_at(self.threshold, squares / size)
    }
}
