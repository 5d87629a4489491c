//! Rest detection: whether the sensor is at rest, block by block.
//!
//! Calibrated samples are gathered in blocks.  A block is at rest if it has no gap, if the standard
//! deviations of specific force and angular rate stay within their limits, and if its means do not
//! drift away from those of the rest so far.
//!
//! # References
//! - D. Tedaldi, A. Pretto, E. Menegatti, "A robust and easy to implement method for IMU
//!   calibration without external equipments", ICRA 2014: sec. V-A (the variance over a window as
//!   the test).

use nalgebra::Vector3;

use crate::ins::sample_statistics::SampleStatistics;
use crate::types::sample::ImuSample;

/// Limits within which a sensor counts as at rest; an infinite one is no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestLimits {
    /// Length of a block, s.
    pub block: f64,
    /// Longest time that the samples of a block may span, s: with more of them missing the motion
    /// in between is unknown.
    pub max_span: f64,
    /// Shortest rest, s.
    pub min_duration: f64,
    /// Greatest standard deviation of an axis of the specific force within a block, m/s².
    pub accel_std: f64,
    /// Greatest standard deviation of an axis of the angular rate within a block, rad/s.
    pub gyro_std: f64,
    /// Greatest difference of the mean specific force of a block from that of the rest so far,
    /// m/s².
    pub accel_drift: f64,
    /// Greatest difference of the mean angular rate of a block from that of the rest so far, rad/s.
    pub gyro_drift: f64,
}

/// State of the newest block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockState {
    /// Part of a block: more samples are needed.
    Part,
    /// Complete and at rest.
    Rest,
    /// Complete and not at rest.
    Moving,
}

/// Decides block by block whether the sensor is at rest.
///
/// The caller extends the rest by a block, or restarts after one in motion.
#[derive(Clone, Debug)]
pub struct RestDetector {
    limits: RestLimits,
    nominal_interval: f64,
    rest: SampleStatistics,
    block_means: SampleStatistics,
    duration: f64,
    anchor: Option<ImuSample>,
    block: Vec<ImuSample>,
}

impl RestDetector {
    /// For samples `nominal_interval` (s) apart.
    #[must_use]
    pub fn new(limits: RestLimits, nominal_interval: f64) -> Self {
        Self {
            limits,
            nominal_interval,
            rest: SampleStatistics::default(),
            block_means: SampleStatistics::default(),
            duration: 0.0,
            anchor: None,
            block: Vec::new(),
        }
    }

    /// Adds the next calibrated sample; one with a repeated stamp is left out.
    pub fn push(&mut self, sample: &ImuSample) -> BlockState {
        let anchor = *self.anchor.get_or_insert(*sample);
        let newest = self.block.last().unwrap_or(&anchor);
        if sample.time <= newest.time {
            return BlockState::Part;
        }
        self.block.push(*sample);
        let elapsed = sample.time - anchor.time;
        if elapsed < self.limits.block - 0.5 * self.nominal_interval || self.block.len() < 2 {
            BlockState::Part
        } else if self.block_is_at_rest() {
            BlockState::Rest
        } else {
            BlockState::Moving
        }
    }

    /// Whether the samples since the anchor are at rest, be they a complete block or not.
    #[must_use]
    pub fn block_is_at_rest(&self) -> bool {
        let (Some(anchor), Some(newest)) = (self.anchor, self.block.last()) else { return true };
        let (block, limits) = (self.block_statistics(), &self.limits);
        let (accel_drift, gyro_drift) = self.drift(&block);
        newest.time - anchor.time <= limits.max_span
            && block.accel_std().max() <= limits.accel_std
            && block.gyro_std().max() <= limits.gyro_std
            && accel_drift.norm() <= limits.accel_drift
            && gyro_drift.norm() <= limits.gyro_drift
    }

    /// Differences of the means of a block from those of the rest so far, m/s² and rad/s; zero at
    /// the beginning of a rest.
    #[must_use]
    pub fn drift(&self, block: &SampleStatistics) -> (Vector3<f64>, Vector3<f64>) {
        if self.rest.count() == 0.0 {
            return (Vector3::zeros(), Vector3::zeros());
        }
        (
            block.specific_force() - self.rest.specific_force(),
            block.angular_rate() - self.rest.angular_rate(),
        )
    }

    /// Adds the newest block to the rest.
    pub fn extend_rest(&mut self) {
        let (Some(anchor), Some(newest)) = (self.anchor, self.block.last()) else { return };
        let block = self.block_statistics();
        self.rest.merge(&block);
        self.block_means.add(&block.specific_force(), &block.angular_rate());
        self.duration += newest.time - anchor.time;
        self.anchor = Some(*newest);
        self.block.clear();
    }

    /// Ends the rest: the next one may begin with the newest sample.
    pub fn restart(&mut self) {
        let anchor = self.block.last().copied().or(self.anchor);
        *self = Self { anchor, ..Self::new(self.limits, self.nominal_interval) };
    }

    /// Whether there is a rest that lasts long enough.
    #[must_use]
    pub fn has_rest(&self) -> bool {
        self.rest.count() > 0.0 && self.duration >= self.limits.min_duration
    }

    /// Statistics of the samples of the rest so far.
    #[must_use]
    pub fn rest(&self) -> &SampleStatistics {
        &self.rest
    }

    /// Statistics of the means of the blocks of the rest so far.
    #[must_use]
    pub fn block_means(&self) -> &SampleStatistics {
        &self.block_means
    }

    /// Statistics of the samples since the anchor.
    #[must_use]
    pub fn block_statistics(&self) -> SampleStatistics {
        SampleStatistics::of(&self.block)
    }

    /// How long the rest so far is, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The last sample of the rest so far, or the one with which it may begin.
    #[must_use]
    pub fn anchor(&self) -> Option<&ImuSample> {
        self.anchor.as_ref()
    }

    /// Samples since the anchor.
    #[must_use]
    pub fn block(&self) -> &[ImuSample] {
        &self.block
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const INTERVAL: f64 = 0.005;
    const LIMITS: RestLimits = RestLimits {
        block: 0.1,
        max_span: 0.2,
        min_duration: 0.15,
        accel_std: 0.25,
        gyro_std: 0.06,
        accel_drift: 0.25,
        gyro_drift: 0.06,
    };

    fn sample(time: f64, force: f64, rate: f64) -> ImuSample {
        ImuSample::new(time, [0.0, force, 9.8], [rate, 0.0, 0.0])
    }

    /// States of all complete blocks; the rest continues, or restarts after motion.
    fn states(limits: RestLimits, samples: impl IntoIterator<Item = ImuSample>) -> Vec<BlockState> {
        let mut detector = RestDetector::new(limits, INTERVAL);
        let mut next = |sample: &ImuSample| {
            let state = detector.push(sample);
            match state {
                BlockState::Part => return None,
                BlockState::Rest => detector.extend_rest(),
                BlockState::Moving => detector.restart(),
            }
            Some(state)
        };
        samples.into_iter().filter_map(|sample| next(&sample)).collect()
    }

    fn times(count: u32) -> impl Iterator<Item = f64> {
        (0..count).map(|k| f64::from(k) * INTERVAL)
    }

    #[test]
    fn a_block_ends_after_its_length_and_the_next_begins_with_its_last_sample() {
        let mut detector = RestDetector::new(LIMITS, INTERVAL);
        for time in times(20) {
            assert_eq!(detector.push(&sample(time, 0.0, 0.0)), BlockState::Part);
        }
        assert_eq!(detector.push(&sample(0.1, 0.0, 0.0)), BlockState::Rest);
        assert!(!detector.has_rest());
        detector.extend_rest();
        assert_eq!(detector.anchor().map(|anchor| anchor.time), Some(0.1));
        assert!((detector.duration() - 0.1).abs() < 1e-12 && !detector.has_rest());
        let second = times(41).skip(21).map(|time| detector.push(&sample(time, 0.0, 0.0)));
        assert_eq!(second.last(), Some(BlockState::Rest));
        detector.extend_rest();
        assert!(detector.has_rest());
    }

    #[test]
    fn standard_deviations_beyond_their_limits_are_motion() {
        let alternating =
            |amplitude: f64, k: u32| if k.is_multiple_of(2) { amplitude } else { -amplitude };
        for (force, rate, expected) in [
            (0.24, 0.0, BlockState::Rest),
            (0.27, 0.0, BlockState::Moving),
            (0.0, 0.058, BlockState::Rest),
            (0.0, 0.062, BlockState::Moving),
        ] {
            let samples = (0..21).map(|k| {
                sample(f64::from(k) * INTERVAL, alternating(force, k), alternating(rate, k))
            });
            assert_eq!(states(LIMITS, samples), [expected], "{force} {rate}");
        }
    }

    #[test]
    fn a_mean_that_drifts_away_from_the_rest_is_motion_and_may_begin_a_new_rest() {
        let step = |time: f64| if time > 0.2 + 1e-9 { 0.3 } else { 0.0 };
        let expected = [BlockState::Rest, BlockState::Rest, BlockState::Moving, BlockState::Rest];
        let samples = times(81).map(|time| sample(time, step(time), 0.0));
        assert_eq!(states(LIMITS, samples), expected);
        let unlimited = RestLimits { accel_drift: f64::INFINITY, ..LIMITS };
        let samples = times(81).map(|time| sample(time, step(time), 0.0));
        assert_eq!(states(unlimited, samples), [BlockState::Rest; 4]);
    }

    #[test]
    fn a_block_with_a_gap_is_motion() {
        let samples = times(61).filter(|time| !(0.051..0.249).contains(time));
        let samples = samples.map(|time| sample(time, 0.0, 0.0));
        assert_eq!(states(LIMITS, samples), [BlockState::Moving]);
    }

    #[test]
    fn a_single_lost_sample_is_no_motion() {
        for lost in 1..40 {
            let kept = (0..41).filter(|&k| k != lost);
            let samples = kept.map(|k| sample(f64::from(k) * INTERVAL, 0.0, 0.0));
            assert!(states(LIMITS, samples).iter().all(|&state| state == BlockState::Rest));
        }
    }

    proptest! {
        #[test]
        fn repeated_stamps_change_nothing(repeats in prop::collection::vec(1_usize..4, 81)) {
            let wave = |time: f64| sample(time, (time * 9.0).sin(), (time * 7.0).cos() * 0.1);
            let repeated = times(81).zip(repeats)
                .flat_map(|(time, count)| std::iter::repeat_n(wave(time), count));
            prop_assert_eq!(states(LIMITS, repeated), states(LIMITS, times(81).map(wave)));
        }
    }
}
