//! ARE: the angular rate's energy.
//!
//! # References
//! Skog, Händel, Nilsson, Rantakokko 2010: the angular rate energy detector, with the gyroscope's
//! variance left to the threshold.

use crate::detectors::detector::{Decision, Detector, DetectorSettings};
use crate::detectors::sliding_window::WINDOW_LIMITS;
use crate::detectors::windowed_detector::{WindowTest, WindowedDetector};
use crate::limits::Limits;
use crate::settings::settings;
use crate::types::sample::ImuSample;

settings! {
    /// Energy of the angular rate: ARE of Skog et al. 2010.
    ///
    /// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's
    /// IMU.
    pub struct AngularRateEnergyConfig: "detector" {
        /// Length of the window.
        window: f64 = 0.1, "s", WINDOW_LIMITS;
        /// Mean square of the angular rate up to which a sample is stationary.
        threshold: f64 = 0.8, "rad²/s²", Limits::Positive;
    }
}

impl DetectorSettings for AngularRateEnergyConfig {
    fn build(&self, rate_hz: f64, _: f64) -> Box<dyn Detector> {
        Box::new(WindowedDetector::new(self.window, rate_hz, AngularRateEnergy::new(self)))
    }
}

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
