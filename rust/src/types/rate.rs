//! Sample rates, and durations as numbers of samples.

use crate::error::ConfigError;
use crate::types::sample::ImuSample;

/// Slowest sample rate at which a foot's swing is still resolved, Hz.
const SLOWEST_RATE: f64 = 20.0;
/// Fastest sample rate that makes sense, Hz.
const FASTEST_RATE: f64 = 20_000.0;

/// The rate rounded to whole hertz.
pub(crate) fn whole_hertz(rate_hz: f64) -> Result<f64, ConfigError> {
    if (SLOWEST_RATE..=FASTEST_RATE).contains(&rate_hz) {
        return Ok(rate_hz.round());
    }
    Err(ConfigError::OutOfRange {
        key: "rate_hz",
        value: rate_hz.to_string(),
        expected: "between 20 and 20000 samples per second".into(),
    })
}

/// Samples per second: the inverse of the median of the intervals that are not zero; none when
/// there is no such interval.
#[must_use]
pub fn sample_rate(samples: &[ImuSample]) -> Option<f64> {
    let intervals = samples
        .windows(2)
        .map(|pair| pair[1].time - pair[0].time)
        .filter(|&interval| interval > 0.0);
    // Positive numbers are in the order of their bits, which are compared with less work.
    let mut intervals: Vec<u64> = intervals.map(f64::to_bits).collect();
    let middle = intervals.len() / 2;
    if intervals.is_empty() {
        return None;
    }
    let even = intervals.len().is_multiple_of(2);
    let (below, &mut upper, _) = intervals.select_nth_unstable(middle);
    let lower = if even { below.iter().copied().fold(0, u64::max) } else { upper };
    Some(2.0 / (f64::from_bits(lower) + f64::from_bits(upper)))
}

/// A number of samples as a divisor.
#[expect(clippy::cast_precision_loss, reason = "a window holds few samples")]
pub(crate) fn number(samples: usize) -> f64 {
    samples as f64
}

/// A duration times a rate as a number of samples.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "validated settings: zero or positive and small"
)]
pub(crate) fn samples(duration_times_rate: f64) -> usize {
    duration_times_rate.round().max(0.0) as usize
}
