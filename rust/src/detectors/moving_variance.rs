//! MV: the moving variance of the specific force.
//!
//! # References
//! Skog, Händel, Nilsson, Rantakokko 2010: the acceleration-moving variance detector, with the
//! accelerometer's variance left to the threshold.  The sum over
//! |f - mean(f)|² is Σ|f|² - |Σf|²/W.

use nalgebra::Vector3;

use crate::config::MovingVarianceConfig;
use crate::detectors::detector::Decision;
use crate::detectors::sliding_window::at_least_zero;
use crate::detectors::window_test::WindowTest;
use crate::types::sample::ImuSample;

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
