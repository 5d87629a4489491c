//! SHOE: the generalized likelihood ratio test for "the foot stands still under gravity alone".
//!
//! # References
//! Skog, Händel, Nilsson, Rantakokko 2010: eq. 15.  With the window's mean direction u the sum over |f - g u|² is Σ|f|² - 2 g |Σf| + W g².

use nalgebra::Vector3;

use crate::config::ShoeConfig;
use crate::detector::window::{Centred, Window, at_least_zero};
use crate::detector::{Decision, Detector};
use crate::sample::ImuSample;

/// The statistic alone.
#[derive(Clone, Debug)]
pub(super) struct ShoeStatistic {
    /// Sums of f (three), |f|², |ω|².
    window: Window<5>,
    gravity: f64,
    accel_weight: f64,
    gyro_weight: f64,
}

impl ShoeStatistic {
    pub(super) fn new(window: f64, accel_std: f64, gyro_std: f64, rate_hz: f64, gravity: f64) -> Self {
        let window = Window::new(window, rate_hz);
        let accel_weight = 1.0 / (window.size() * accel_std * accel_std);
        let gyro_weight = 1.0 / (window.size() * gyro_std * gyro_std);
        Self { window, gravity, accel_weight, gyro_weight }
    }

    pub(super) fn latency(&self) -> usize {
        self.window.half()
    }

    /// The statistic of the sample half a window back; NaN while the window is not full.
    pub(super) fn push(&mut self, sample: &ImuSample) -> Option<f64> {
        let (f, rate_squared) = (&sample.specific_force, sample.angular_rate.norm_squared());
        let size = self.window.size();
        match self.window.push([f.x, f.y, f.z, f.norm_squared(), rate_squared])? {
            Centred::Filling => Some(f64::NAN),
            Centred::Full { sums: &[x, y, z, force, rate], .. } => {
                let resultant = Vector3::new(x, y, z).norm();
                let residual = force - 2.0 * self.gravity * resultant + size * self.gravity * self.gravity;
                Some(self.accel_weight * at_least_zero(residual) + self.gyro_weight * rate)
            }
        }
    }

    pub(super) fn drain(&mut self) -> Option<f64> {
        self.window.drain().then_some(f64::NAN)
    }

    pub(super) fn reset(&mut self) {
        self.window.reset();
    }
}

/// SHOE with a fixed threshold.
#[derive(Clone, Debug)]
pub struct Shoe {
    statistic: ShoeStatistic,
    threshold: f64,
}

impl Shoe {
    /// A detector for samples at `rate_hz`, with gravity in m/s².
    #[must_use]
    pub fn new(config: &ShoeConfig, rate_hz: f64, gravity: f64) -> Self {
        let statistic = ShoeStatistic::new(config.window, config.accel_std, config.gyro_std, rate_hz, gravity);
        Self { statistic, threshold: config.threshold }
    }
}

impl Detector for Shoe {
    fn latency(&self) -> usize {
        self.statistic.latency()
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        self.statistic.push(sample).map(|statistic| Decision::up_to(self.threshold, statistic))
    }

    fn drain(&mut self) -> Option<Decision> {
        self.statistic.drain().map(|statistic| Decision::up_to(self.threshold, statistic))
    }

    fn reset(&mut self) {
        self.statistic.reset();
    }
}
