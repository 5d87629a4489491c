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
    minimum: SlidingMinimum,
    /// Of the statistics with their sign reversed: minus their maximum.
    reversed_minimum: SlidingMinimum,
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
            minimum: SlidingMinimum::new(span),
            reversed_minimum: SlidingMinimum::new(span),
            waiting: VecDeque::with_capacity(look_ahead + 1),
            look_ahead,
            factor: config.factor,
            floor: config.floor,
            ceiling: config.ceiling,
            contrast: config.contrast,
        }
    }

    fn take_in(&mut self, statistic: f64) -> Option<Decision> {
        self.minimum.push(statistic);
        self.reversed_minimum.push(-statistic);
        self.waiting.push_back(statistic);
        if self.waiting.len() <= self.look_ahead {
            return None;
        }
        self.waiting.pop_front().map(|statistic| self.decide(statistic))
    }

    fn decide(&self, statistic: f64) -> Decision {
        let below_swing = self.reversed_minimum.get().map_or(f64::NAN, |reversed| -self.contrast * reversed);
        let threshold = self.minimum.get().map_or(f64::NAN, |minimum| self.factor * minimum);
        Decision::up_to(threshold.min(below_swing).max(self.floor).min(self.ceiling), statistic)
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
        self.minimum.advance();
        self.reversed_minimum.advance();
        self.waiting.pop_front().map(|statistic| self.decide(statistic))
    }

    fn reset(&mut self) {
        self.statistic.reset();
        self.minimum.reset();
        self.reversed_minimum.reset();
        self.waiting.clear();
    }
}

/// The least of the last `span` values, in constant time on average: values that can never be the minimum again are dropped.
#[derive(Clone, Debug)]
struct SlidingMinimum {
    span: u64,
    next: u64,
    candidates: VecDeque<(u64, f64)>,
}

impl SlidingMinimum {
    fn new(span: usize) -> Self {
        Self { span: span as u64, next: 0, candidates: VecDeque::with_capacity(span) }
    }

    /// Takes the next value; NaN only makes the window move on.
    fn push(&mut self, value: f64) {
        self.advance();
        if value.is_nan() {
            return;
        }
        while self.candidates.back().is_some_and(|&(_, candidate)| candidate >= value) {
            self.candidates.pop_back();
        }
        self.candidates.push_back((self.next, value));
    }

    /// Moves the window on by one.
    fn advance(&mut self) {
        self.next += 1;
        while self.candidates.front().is_some_and(|&(index, _)| index + self.span <= self.next) {
            self.candidates.pop_front();
        }
    }

    fn get(&self) -> Option<f64> {
        self.candidates.front().map(|&(_, value)| value)
    }

    fn reset(&mut self) {
        self.next = 0;
        self.candidates.clear();
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_sliding_minimum_is_the_minimum_of_the_window(values in prop::collection::vec(0.0..9.0, 1..60), span in 1usize..12) {
            let mut sliding = SlidingMinimum::new(span);
            for end in 1..=values.len() {
                sliding.push(values[end - 1]);
                let window = &values[end.saturating_sub(span)..end];
                prop_assert_eq!(sliding.get(), window.iter().copied().reduce(f64::min));
            }
        }
    }
}
