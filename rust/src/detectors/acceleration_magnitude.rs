//! MAG: the magnitude of the specific force.
//!
//! # References
//! Skog, Händel, Nilsson, Rantakokko 2010: the acceleration-magnitude detector, with the
//! accelerometer's variance left to the threshold.

use crate::config::AccelerationMagnitudeConfig;
use crate::detectors::detector::{Decision, magnitude_excess};
use crate::detectors::window_test::WindowTest;
use crate::types::sample::ImuSample;

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
