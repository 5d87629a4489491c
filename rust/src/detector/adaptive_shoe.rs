//! SHOE with a threshold that follows the stride.
//!
//! How still a foot gets in stance depends on the person, the gait and the sensor, by factors of a thousand; that it gets stiller there than anywhere else in the
//! stride does not.  So a sample is stationary where its statistic is within a small factor of the least one around it, or below a floor that no moving foot
//! reaches; and never above a ceiling that no standing foot reaches.
//!
//! A swing that lasts longer than the detector looks has a least statistic too.  But a stance is stiller than the swing next to it by orders of magnitude, and a
//! pause of a slow swing is not: above the floor, a stationary sample's statistic must also be small against the greatest one around it.

use std::collections::VecDeque;

use crate::config::AdaptiveShoeConfig;
use crate::detector::extremes::{Extremes, SlidingExtremes};
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
    /// Statistics whose look-ahead is not complete.
    waiting: VecDeque<f64>,
    look_ahead: usize,
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
        Self {
            statistic: ShoeStatistic::new(config.window, config.accel_std, config.gyro_std, rate_hz, gravity),
            around: SlidingExtremes::new(span),
            waiting: VecDeque::with_capacity(look_ahead + 1),
            look_ahead,
            factor: config.factor,
            floor: config.floor,
            ceiling: config.ceiling,
            contrast: config.contrast,
        }
    }

    fn take_in(&mut self, statistic: f64) -> Option<Decision> {
        let around = self.around.push(statistic);
        self.waiting.push_back(statistic);
        if self.waiting.len() <= self.look_ahead {
            return None;
        }
        self.waiting.pop_front().map(|statistic| self.decide(statistic, &around))
    }

    fn decide(&self, statistic: f64, around: &Extremes) -> Decision {
        let threshold = (self.factor * around.least).min(self.contrast * around.greatest);
        Decision::up_to(threshold.max(self.floor).min(self.ceiling), statistic)
    }
}

impl Detector for AdaptiveShoe {
    fn latency(&self) -> usize {
        self.statistic.latency() + self.look_ahead
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        self.statistic.push(sample).and_then(|statistic| self.take_in(statistic))
    }

    fn drain(&mut self) -> Option<Decision> {
        while let Some(statistic) = self.statistic.drain() {
            if let Some(decision) = self.take_in(statistic) {
                return Some(decision);
            }
        }
        let around = self.around.push(f64::NAN);
        self.waiting.pop_front().map(|statistic| self.decide(statistic, &around))
    }

    fn reset(&mut self) {
        self.statistic.reset();
        self.around.reset();
        self.waiting.clear();
    }
}
