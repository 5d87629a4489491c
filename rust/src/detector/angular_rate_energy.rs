//! ARE: the angular rate's energy.
//!
//! # References
//! Skog, Händel, Nilsson, Rantakokko 2010: the angular rate energy detector, with the gyroscope's variance left to the threshold.

use crate::config::AngularRateEnergyConfig;
use crate::detector::Decision;
use crate::detector::windowed::Rule;
use crate::sample::ImuSample;

/// Stationary where the mean of |ω|² over the window is low.
#[derive(Clone, Debug)]
pub(super) struct AngularRateEnergy {
    threshold: f64,
}

impl AngularRateEnergy {
    pub(super) fn new(config: &AngularRateEnergyConfig) -> Self {
        Self { threshold: config.threshold }
    }
}

impl Rule<1> for AngularRateEnergy {
    fn row(&self, sample: &ImuSample) -> [f64; 1] {
        [sample.angular_rate.norm_squared()]
    }

    fn decide(&self, size: f64, &[energy]: &[f64; 1], _: &[f64; 1]) -> Decision {
        Decision::up_to(self.threshold, energy / size)
    }
}
