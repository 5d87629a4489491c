//! SHOE with an adaptive threshold.
//!
//! The level of the statistic in stance varies by factors of a thousand with the person, the gait
//! and the sensor, but the stance is always the minimum of the stride.  A sample is therefore
//! stationary where its statistic is within a small factor of the local minimum, or below a noise
//! floor that a moving foot never reaches; it is never stationary above an upper bound that a
//! standing foot never reaches.
//!
//! A swing longer than the search window also has a local minimum.  In stance the statistic is
//! orders of magnitude below that of the adjacent swing; in a pause of a slow swing it is not.
//! Above the noise floor, the statistic of a stationary sample must therefore also be small
//! relative to the local maximum.

use crate::detectors::delay::Delay;
use crate::detectors::detector::{Decision, Detector, DetectorSettings};
use crate::detectors::latency_counter::LatencyCounter;
use crate::detectors::shoe::ShoeStatistic;
use crate::detectors::sliding_min_max::{MinMax, SlidingMinMax, max, min};
use crate::detectors::sliding_window::WINDOW_LIMITS;
use crate::error::ConfigError;
use crate::limits::Limits;
use crate::settings::settings;
use crate::types::rate::samples;
use crate::types::sample::ImuSample;

settings! {
    /// SHOE with a threshold that follows the stride: a multiple of the statistic's local minimum.
    pub struct AdaptiveShoeConfig: "detector", also bounds_in_order {
        /// Length of the statistic's window.
        window: f64 = 0.05, "s", WINDOW_LIMITS;
        /// Standard deviation that weights the specific force.
        accel_std: f64 = 0.02, "m/s²", Limits::Positive;
        /// Standard deviation that weights the angular rate.
        gyro_std: f64 = 8.7e-3, "rad/s", Limits::Positive;
        /// Time before the sample over which the minimum is taken.
        look_behind: f64 = 0.6, "s", Limits::Between(0.0, 10.0);
        /// Time after the sample over which the minimum is taken; the latency is this and half a
        /// window.
        look_ahead: f64 = 0.6, "s", Limits::Between(0.0, 10.0);
        /// Multiple of the minimum up to which a sample is stationary.
        min_factor: f64 = 1.5, "", Limits::AtLeast(1.0);
        /// Statistic up to which a sample is stationary however low the minimum is: at rest the
        /// minimum is noise alone.
        noise_floor: f64 = 500.0, "", Limits::NonNegative;
        /// Statistic above which a sample is never stationary; at least `noise_floor`.
        upper_bound: f64 = 2.0e5, "", Limits::NonNegative;
        /// Fraction of the local maximum up to which a sample is stationary: a slow swing has
        /// minima too.
        max_fraction: f64 = 0.015, "", Limits::Between(0.0, 1.0);
    }
}

impl AdaptiveShoeConfig {
    /// Settings for streaming with a latency below 0.3 s.
    ///
    /// A look-ahead of a quarter of a second contains at most the end of a swing, so a stance is
    /// often compared with the preceding swing only; the smaller fraction of the maximum
    /// compensates for it.
    #[must_use]
    pub fn live() -> Self {
        Self { look_ahead: 0.25, max_fraction: 0.01, ..Self::default() }
    }

    fn bounds_in_order(&self) -> Result<(), ConfigError> {
        if self.upper_bound >= self.noise_floor {
            return Ok(());
        }
        Err(ConfigError::OutOfRange {
            key: "detector.upper_bound",
            value: self.upper_bound.to_string(),
            expected: "at least detector.noise_floor".into(),
        })
    }
}

impl DetectorSettings for AdaptiveShoeConfig {
    fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector> {
        Box::new(AdaptiveShoe::new(self, rate_hz, gravity))
    }
}

/// SHOE with a threshold that is a multiple of the local minimum of the statistic.
///
/// At both ends of the data the minimum is over the available samples.
#[derive(Clone, Debug)]
pub struct AdaptiveShoe {
    statistic: ShoeStatistic,
    around: SlidingMinMax,
    /// Aligns a statistic with the sliding window around it.
    delay: Delay,
    latency_counter: LatencyCounter,
    min_factor: f64,
    noise_floor: f64,
    upper_bound: f64,
    max_fraction: f64,
}

impl AdaptiveShoe {
    /// A detector for samples at `rate_hz`, with gravity in m/s².
    #[must_use]
    pub fn new(config: &AdaptiveShoeConfig, rate_hz: f64, gravity: f64) -> Self {
        let look_ahead = samples(config.look_ahead * rate_hz);
        let span = samples(config.look_behind * rate_hz) + 1 + look_ahead;
        let statistic =
            ShoeStatistic::new(config.window, config.accel_std, config.gyro_std, rate_hz, gravity);
        Self {
            around: SlidingMinMax::new(span),
            delay: Delay::new(look_ahead),
            latency_counter: LatencyCounter::new(statistic.latency() + look_ahead),
            statistic,
            min_factor: config.min_factor,
            noise_floor: config.noise_floor,
            upper_bound: config.upper_bound,
            max_fraction: config.max_fraction,
        }
    }

    /// Processes the next statistic; decides about the sample at the reference point of the window,
    /// if it exists.
    #[expect(clippy::inline_always, reason = "cheaper than a call, and called for every sample")]
    #[inline(always)]
    fn push_statistic(&mut self, statistic: f64) -> Option<Decision> {
        let around = self.around.push(statistic);
        let statistic = self.delay.push(statistic);
        self.latency_counter
            .push()
            .then(|| Decision::threshold_at(self.threshold(&around), statistic))
    }

    fn threshold(&self, around: &MinMax) -> f64 {
        let relative = min(self.min_factor * around.min, self.max_fraction * around.max);
        min(max(relative, self.noise_floor), self.upper_bound)
    }
}

impl Detector for AdaptiveShoe {
    fn latency(&self) -> usize {
        self.latency_counter.latency()
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        let statistic = self.statistic.push(sample);
        self.push_statistic(statistic)
    }

    fn drain(&mut self) -> Option<Decision> {
        let steps = self.latency_counter.drain()?;
        (0..steps).filter_map(|_| self.push_statistic(f64::NAN)).last()
    }

    fn reset(&mut self) {
        self.statistic.reset();
        self.around.reset();
        self.delay.reset();
        self.latency_counter.reset();
    }
}

#[cfg(test)]
mod tests {
    use std::iter;

    use nalgebra::Vector3;
    use proptest::prelude::*;

    use super::*;

    const RATE: f64 = 100.0;
    const GRAVITY: f64 = 9.8;
    const CONFIG: AdaptiveShoeConfig = AdaptiveShoeConfig {
        window: 0.05,
        accel_std: 0.02,
        gyro_std: 8.7e-3,
        look_behind: 0.11,
        look_ahead: 0.07,
        min_factor: 1.5,
        noise_floor: 500.0,
        upper_bound: 2.0e5,
        max_fraction: 0.4,
    };
    /// `CONFIG`'s durations in samples.
    const HALF: usize = 2;
    const BEHIND: usize = 11;
    const AHEAD: usize = 7;

    /// Skog et al. 2010, eq. 15, of the window around sample `k`; NaN where the data do not fill
    /// it.
    fn statistic(samples: &[ImuSample], k: usize) -> f64 {
        if k < HALF || k + HALF >= samples.len() {
            return f64::NAN;
        }
        let window = &samples[k - HALF..=k + HALF];
        let gravity =
            GRAVITY * window.iter().map(|s| s.specific_force).sum::<Vector3<f64>>().normalize();
        let force = window.iter().map(|s| (s.specific_force - gravity).norm_squared()).sum::<f64>();
        let rate = window.iter().map(|s| s.angular_rate.norm_squared()).sum::<f64>();
        (force / CONFIG.accel_std.powi(2) + rate / CONFIG.gyro_std.powi(2)) / 5.0
    }

    /// Statistic and threshold of sample `k` from all statistics; NaN where there is no statistic.
    fn expected_decision(statistics: &[f64], k: usize) -> (f64, f64) {
        let around = &statistics[k.saturating_sub(BEHIND)..(k + AHEAD + 1).min(statistics.len())];
        let min = around.iter().copied().fold(f64::NAN, f64::min);
        let max = around.iter().copied().fold(f64::NAN, f64::max);
        let relative = (CONFIG.min_factor * min).min(CONFIG.max_fraction * max);
        let threshold = if statistics[k].is_nan() {
            f64::NAN
        } else {
            relative.clamp(CONFIG.noise_floor, CONFIG.upper_bound)
        };
        (statistics[k], threshold)
    }

    fn agrees(found: f64, expected: f64) -> bool {
        (found.is_nan() && expected.is_nan()) || (found - expected).abs() <= 1e-9 * (1e5 + expected)
    }

    /// Recordings with swing and stance, shorter and longer than the latency of the detector.
    fn samples() -> impl Strategy<Value = Vec<ImuSample>> {
        let vibration = prop_oneof![Just(0.01), Just(0.3), Just(5.0)];
        let row = (vibration, prop::array::uniform3(-1.0..1.0), prop::array::uniform3(-1.0..1.0));
        prop::collection::vec(row, 0..60).prop_map(|rows| {
            let sample = |(scale, force, rate): (f64, [f64; 3], [f64; 3])| ImuSample {
                time: 0.0,
                specific_force: Vector3::new(0.0, 0.0, GRAVITY) + scale * Vector3::from(force),
                angular_rate: scale * Vector3::from(rate),
            };
            rows.into_iter().map(sample).collect()
        })
    }

    proptest! {
        #[test]
        fn decisions_equal_those_of_the_whole_data(samples in samples(), before in samples()) {
            let mut detector = AdaptiveShoe::new(&CONFIG, RATE, GRAVITY);
            prop_assert_eq!(detector.latency(), HALF + AHEAD);
            for sample in &before {
                detector.push(sample);
            }
            detector.reset();
            let mut decisions: Vec<_> =
                samples.iter().filter_map(|sample| detector.push(sample)).collect();
            prop_assert_eq!(decisions.len(), samples.len().saturating_sub(HALF + AHEAD));
            decisions.extend(iter::from_fn(|| detector.drain()));
            prop_assert_eq!(decisions.len(), samples.len());
            let statistics: Vec<f64> = (0..samples.len()).map(|k| statistic(&samples, k)).collect();
            for (k, found) in decisions.iter().enumerate() {
                let (statistic, threshold) = expected_decision(&statistics, k);
                prop_assert!(agrees(found.statistic, statistic), "{k}: {found:?} {statistic}");
                prop_assert!(agrees(found.threshold, threshold), "{k}: {found:?} {threshold}");
                prop_assert_eq!(found.stationary, found.statistic <= found.threshold);
            }
        }
    }
}
