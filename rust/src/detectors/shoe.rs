//! SHOE: the generalized likelihood ratio test for "the foot stands still under gravity alone".
//!
//! # References
//! Skog, Händel, Nilsson, Rantakokko 2010: eq. 15.  With the window's mean direction u the sum over
//! |f - g u|² is Σ|f|² - 2 g |Σf| + W g².

use nalgebra::Vector3;

use crate::detectors::detector::{Decision, Detector, DetectorSettings};
use crate::detectors::latency_counter::LatencyCounter;
use crate::detectors::sliding_window::{WINDOW_LIMITS, Window, at_least_zero};
use crate::limits::Limits;
use crate::settings::settings;
use crate::types::sample::ImuSample;

settings! {
    /// SHOE with a fixed threshold (Skog et al. 2010).
    pub struct ShoeConfig: "detector" {
        /// Length of the window.
        window: f64 = 0.025, "s", WINDOW_LIMITS;
        /// Standard deviation that weights the specific force.
        accel_std: f64 = 0.02, "m/s²", Limits::Positive;
        /// Standard deviation that weights the angular rate.
        gyro_std: f64 = 8.7e-3, "rad/s", Limits::Positive;
        /// Statistic up to which a sample is stationary.
        threshold: f64 = 3.0e3, "", Limits::Positive;
    }
}

impl DetectorSettings for ShoeConfig {
    fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector> {
        Box::new(Shoe::new(self, rate_hz, gravity))
    }
}

/// The statistic alone.
#[derive(Clone, Debug)]
pub(crate) struct ShoeStatistic {
    /// Sums of f (three), |f|², |ω|².
    window: Window<5>,
    /// 2 g.
    twice_gravity: f64,
    /// W g².
    gravity_alone: f64,
    accel_weight: f64,
    gyro_weight: f64,
}

impl ShoeStatistic {
    pub(crate) fn new(
        window: f64,
        accel_std: f64,
        gyro_std: f64,
        rate_hz: f64,
        gravity: f64,
    ) -> Self {
        let window = Window::new(window, rate_hz);
        let accel_weight = 1.0 / (window.size() * accel_std * accel_std);
        let gyro_weight = 1.0 / (window.size() * gyro_std * gyro_std);
        let (twice_gravity, gravity_alone) = (2.0 * gravity, window.size() * gravity * gravity);
        Self { window, twice_gravity, gravity_alone, accel_weight, gyro_weight }
    }

    pub(crate) fn latency(&self) -> usize {
        self.window.half()
    }

    /// The statistic of the sample half a window back; NaN while the window is not full.
    #[expect(
        clippy::inline_always,
        reason = "small beside a call, and two detectors call it for every sample"
    )]
    #[inline(always)]
    pub(crate) fn push(&mut self, sample: &ImuSample) -> f64 {
        let (f, rate_squared) = (&sample.specific_force, sample.angular_rate.norm_squared());
        let &[x, y, z, force, rate] =
            self.window.push([f.x, f.y, f.z, f.norm_squared(), rate_squared]);
        let resultant = Vector3::new(x, y, z).norm();
        let residual = force - self.twice_gravity * resultant + self.gravity_alone;
        self.accel_weight * at_least_zero(residual) + self.gyro_weight * rate
    }

    pub(crate) fn reset(&mut self) {
        self.window.reset();
    }
}

/// SHOE with a fixed threshold.
#[derive(Clone, Debug)]
pub struct Shoe {
    statistic: ShoeStatistic,
    latency_counter: LatencyCounter,
    threshold: f64,
}

impl Shoe {
    /// A detector for samples at `rate_hz`, with gravity in m/s².
    #[must_use]
    pub fn new(config: &ShoeConfig, rate_hz: f64, gravity: f64) -> Self {
        let statistic =
            ShoeStatistic::new(config.window, config.accel_std, config.gyro_std, rate_hz, gravity);
        Self {
            latency_counter: LatencyCounter::new(statistic.latency()),
            statistic,
            threshold: config.threshold,
        }
    }
}

impl Detector for Shoe {
    fn latency(&self) -> usize {
        self.latency_counter.latency()
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        let statistic = self.statistic.push(sample);
        self.latency_counter.push().then(|| Decision::threshold_at(self.threshold, statistic))
    }

    fn drain(&mut self) -> Option<Decision> {
        self.latency_counter.drain().map(|_| Decision::UNKNOWN)
    }

    fn reset(&mut self) {
        self.statistic.reset();
        self.latency_counter.reset();
    }
}
