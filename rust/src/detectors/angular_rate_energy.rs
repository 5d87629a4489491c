//! ARE: the angular rate's energy.
//!
//! # References
//! Skog, Händel, Nilsson, Rantakokko 2010: the angular rate energy detector, with the gyroscope's
//! variance left to the threshold.

use crate::config::AngularRateEnergyConfig;
use crate::detectors::detector::Decision;
use crate::detectors::window_test::WindowTest;
use crate::types::sample::ImuSample;

/// Stationary where the mean of |ω|² over the window is low.
#[derive(Clone, Debug)]
pub(crate) struct AngularRateEnergy {
    threshold: f64,
}

impl AngularRateEnergy {
    pub(crate) fn new(config: &AngularRateEnergyConfig) -> Self {
        Self { threshold: config.threshold }
    }
}

impl WindowTest<1> for AngularRateEnergy {
    fn row(&self, sample: &ImuSample) -> [f64; 1] {
        [sample.angular_rate.norm_squared()]
    }

    fn decide(&self, size: f64, &[energy]: &[f64; 1], _: &[f64; 1]) -> Decision {
        Decision::threshold_at(self.threshold, energy / size)
    }
}
