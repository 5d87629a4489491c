//! SHOE with a threshold that follows the stride.
//!
//! How still a foot gets in stance depends on the person, the gait and the sensor, by factors of a thousand; that it gets stiller there than anywhere else in the
//! stride does not.  So a sample is stationary where its statistic is within a small factor of the least one around it, or below a floor that no moving foot
//! reaches; and never above a ceiling that no standing foot reaches.
//!
//! A swing that lasts longer than the detector looks has a least statistic too.  But a stance is stiller than the swing next to it by orders of magnitude, and a
//! pause of a slow swing is not: above the floor, a stationary sample's statistic must also be small against the greatest one around it.

use crate::config::AdaptiveShoeConfig;
use crate::detector::backlog::Backlog;
use crate::detector::delay::Delay;
use crate::detector::extremes::{Extremes, SlidingExtremes, greater, lesser};
use crate::detector::shoe::ShoeStatistic;
use crate::detector::window::samples;
use crate::detector::{Decision, Detector};
use crate::sample::ImuSample;

/// SHOE whose threshold is a multiple of the statistic's minimum around the sample.
///
/// At both ends of the data the minimum is taken over the samples that there are.
#[derive(Clone, Debug)]
pub struct AdaptiveShoe {
    statistic: ShoeStatistic,
    around: SlidingExtremes,
    /// Brings a statistic to the middle of what is around it.
    delay: Delay,
    backlog: Backlog,
    factor: f64,
    floor: f64,
    ceiling: f64,
    contrast: f64,
}

impl AdaptiveShoe {
    /// A detector for samples at `rate_hz`, with gravity in m/s².
    #[must_use]
    pub fn new(config: &AdaptiveShoeConfig, rate_hz: f64, gravity: f64) -> Self {
        let look_ahead = samples(config.look_ahead * rate_hz);
        let span = samples(config.look_behind * rate_hz) + 1 + look_ahead;
        let statistic = ShoeStatistic::new(config.window, config.accel_std, config.gyro_std, rate_hz, gravity);
        Self {
            around: SlidingExtremes::new(span),
            delay: Delay::new(look_ahead),
            backlog: Backlog::new(statistic.latency() + look_ahead),
            statistic,
            factor: config.factor,
            floor: config.floor,
            ceiling: config.ceiling,
            contrast: config.contrast,
        }
    }

    /// Takes the next statistic; decides about the one that has come to the middle, if a sample stands behind it.
    fn take_in(&mut self, statistic: f64) -> Option<Decision> {
        let around = self.around.push(statistic);
        let statistic = self.delay.push(statistic);
        self.backlog.push().then(|| Decision::up_to(self.threshold(&around), statistic))
    }

    fn threshold(&self, around: &Extremes) -> f64 {
        let relative = lesser(self.factor * around.least, self.contrast * around.greatest);
        lesser(greater(relative, self.floor), self.ceiling)
    }
}

impl Detector for AdaptiveShoe {
    fn latency(&self) -> usize {
        self.backlog.latency()
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        let statistic = self.statistic.push(sample);
        self.take_in(statistic)
    }

    fn drain(&mut self) -> Option<Decision> {
        let steps = self.backlog.drain()?;
        (0..steps).filter_map(|_| self.take_in(f64::NAN)).last()
    }

    fn reset(&mut self) {
        self.statistic.reset();
        self.around.reset();
        self.delay.reset();
        self.backlog.reset();
    }
}
