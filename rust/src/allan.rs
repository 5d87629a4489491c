//! Overlapping Allan deviation of a sensor record.
//!
//! With N samples y and their N + 1 cumulative sums X, with the mean of y removed, the Allan
//! variance at an averaging time of m samples is
//!
//! ```text
//! s²(m) = 1 / (2 m² (N - 2m + 1)) · Σ (X[k + 2m] - 2 X[k + m] + X[k])²
//! ```
//!
//! # References
//! - W. J. Riley, D. A. Howe, "Handbook of Frequency Stability Analysis", NIST Special Publication
//!   1065, 2008: eq. 11 (the estimator) and table 5 (degrees of freedom); its frequency is the
//!   sensor reading here, and its phase the cumulative sum.
//! - A. Neumaier, "Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen", ZAMM
//!   54, 1974: the compensated sum.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::{iter, sync::mpsc, thread};

/// Averaging times per decade, as far as integer numbers of samples allow.
const PER_DECADE: i32 = 10;
/// Minimum number of intervals at the longest averaging time.
const MIN_CLUSTERS: usize = 10;
/// Number of squares per partial sum; partial sums keep the rounding error independent of the
/// length of the record.
const BLOCK: usize = 1024;
/// Number of parallel sums.
const LANES: usize = 8;
/// Averaging times on each side over which the local slope is computed: half an octave or more.
const SLOPE_REACH: usize = 2;

/// Noise process that dominates the Allan deviation at an averaging time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// Quantization noise: the variance falls with the square of the averaging time.
    Quantization,
    /// White noise: angle or velocity random walk.
    White,
    /// Bias instability (1/f noise): the floor of the curve.
    BiasInstability,
    /// Bias random walk or drift: the variance grows.
    BiasWalk,
}

impl Noise {
    /// The noise whose Allan variance has this slope in log-log axes, approximately.
    #[must_use]
    pub fn of_slope(slope: f64) -> Self {
        match slope {
            ..-1.5 => Self::Quantization,
            -1.5..-0.5 => Self::White,
            -0.5..0.5 => Self::BiasInstability,
            _ => Self::BiasWalk,
        }
    }

    /// Equivalent degrees of freedom of the overlapping estimate from `samples` samples at an
    /// averaging time of `factor` samples (NIST SP 1065, table 5).
    ///
    /// The estimated variance divided by the true one is distributed as chi-squared over its
    /// degrees of freedom.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "no record has 2^52 samples")]
    pub fn degrees_of_freedom(self, samples: usize, factor: usize) -> f64 {
        let (n, m) = ((samples + 1) as f64, factor as f64);
        match self {
            Self::Quantization => (n + 1.0) * (n - 2.0 * m) / (2.0 * (n - m)),
            Self::White => {
                (3.0 * (n - 1.0) / (2.0 * m) - 2.0 * (n - 2.0) / n) * 4.0 * m.powi(2)
                    / (4.0 * m.powi(2) + 5.0)
            }
            Self::BiasInstability if factor == 1 => 2.0 * (n - 2.0).powi(2) / (2.3 * n - 4.9),
            Self::BiasInstability => 5.0 * n.powi(2) / (4.0 * m * (n + 3.0 * m)),
            Self::BiasWalk => {
                (n - 2.0) / m * ((n - 1.0).powi(2) - 3.0 * m * (n - 1.0) + 4.0 * m.powi(2))
                    / (n - 3.0).powi(2)
            }
        }
    }
}

/// Averaging times (samples) of a record of `samples` samples: ten per decade, up to a tenth of the
/// record.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounded, positive, and limited by the record"
)]
pub fn averaging_factors(samples: usize) -> Vec<usize> {
    let spaced = (0..).map(|k| 10_f64.powf(f64::from(k) / f64::from(PER_DECADE)).round() as usize);
    let mut factors: Vec<usize> =
        spaced.take_while(|factor| factor * MIN_CLUSTERS <= samples).collect();
    factors.dedup();
    factors
}

/// Cumulative sums of a record with its mean removed.
#[derive(Clone, Debug)]
pub struct Integral {
    sums: Vec<f64>,
}

impl Integral {
    /// Sums `samples` with compensation: each sum is rounded once, for any length of the record.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "no record has 2^52 samples")]
    pub fn new(samples: &[f64]) -> Self {
        let mut total = CompensatedSum::default();
        for &sample in samples {
            total.add(sample);
        }
        let mean = total.value() / samples.len() as f64;
        let mut sum = CompensatedSum::default();
        let sums = samples.iter().map(|sample| {
            sum.add(sample - mean);
            sum.value()
        });
        Self { sums: iter::once(0.0).chain(sums).collect() }
    }

    /// Overlapping Allan deviation at an averaging time of `factor` samples, in the unit of the
    /// samples; NaN for a record shorter than two averaging times.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "no record has 2^52 samples")]
    pub fn deviation(&self, factor: usize) -> f64 {
        let Some(terms) =
            self.sums.len().checked_sub(2 * factor).filter(|&terms| terms > 0 && factor > 0)
        else {
            return f64::NAN;
        };
        let [first, middle, last] =
            [0, factor, 2 * factor].map(|start| self.sums[start..start + terms].chunks(BLOCK));
        let squares: f64 =
            first.zip(middle).zip(last).map(|((a, b), c)| sum_of_squares(a, b, c)).sum();
        (squares / (2.0 * terms as f64)).sqrt() / factor as f64
    }
}

/// Sum of the squared second differences of cumulative sums.
fn sum_of_squares(first: &[f64], middle: &[f64], last: &[f64]) -> f64 {
    let square = |a: &f64, b: &f64, c: &f64| ((c - b) - (b - a)).powi(2);
    let (first, first_rest) = first.as_chunks::<LANES>();
    let (middle, middle_rest) = middle.as_chunks::<LANES>();
    let (last, last_rest) = last.as_chunks::<LANES>();
    let mut lanes = [0.0; LANES];
    for ((a, b), c) in first.iter().zip(middle).zip(last) {
        for lane in 0..LANES {
            lanes[lane] += square(&a[lane], &b[lane], &c[lane]);
        }
    }
    let rest = first_rest.iter().zip(middle_rest).zip(last_rest).map(|((a, b), c)| square(a, b, c));
    lanes.into_iter().chain(rest).sum()
}

/// Compensated sum (Neumaier 1974): a sum and its accumulated rounding error.
#[derive(Default)]
struct CompensatedSum {
    sum: f64,
    compensation: f64,
}

impl CompensatedSum {
    fn add(&mut self, value: f64) {
        let before = self.sum;
        self.sum += value;
        let (large, small) =
            if before.abs() >= value.abs() { (before, value) } else { (value, before) };
        self.compensation += (large - self.sum) + small;
    }

    fn value(&self) -> f64 {
        self.sum + self.compensation
    }
}

/// Allan deviation of one channel as a function of averaging time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Averaging times, in samples.
    pub factors: Vec<usize>,
    /// Deviation at each averaging time, in the unit of the samples.
    pub deviation: Vec<f64>,
    /// Equivalent degrees of freedom of each deviation, for the noise identified by the local slope
    /// of the curve.
    pub degrees_of_freedom: Vec<f64>,
}

impl Curve {
    /// The curve of evenly spaced `samples`, computed on all processors.
    ///
    /// `progress` is called in the calling thread after each averaging time with the completed
    /// fraction; its error cancels the computation.
    ///
    /// # Errors
    /// That of `progress`.
    ///
    /// # Examples
    /// ```
    /// use footnav::allan::Curve;
    ///
    /// let ramp: Vec<f64> = (0..1000).map(|k| 0.1 * f64::from(k)).collect();
    /// let curve = Curve::of(&ramp, |_| Ok::<(), std::convert::Infallible>(()))?;
    /// assert!((curve.deviation[0] - 0.1 / 2_f64.sqrt()).abs() < 1e-9);
    /// # Ok::<(), std::convert::Infallible>(())
    /// ```
    pub fn of<E>(samples: &[f64], progress: impl FnMut(f64) -> Result<(), E>) -> Result<Self, E> {
        let factors = averaging_factors(samples.len());
        let deviation = deviations(&Integral::new(samples), &factors, progress)?;
        let degrees_of_freedom = noises(&factors, &deviation)
            .zip(&factors)
            .map(|(noise, &factor)| noise.degrees_of_freedom(samples.len(), factor))
            .collect();
        Ok(Self { factors, deviation, degrees_of_freedom })
    }
}

/// Deviation at each of `factors`; the workers stop when the receiver of their results is dropped.
#[expect(clippy::cast_precision_loss, reason = "a few dozen averaging times")]
fn deviations<E>(
    integral: &Integral,
    factors: &[usize],
    mut progress: impl FnMut(f64) -> Result<(), E>,
) -> Result<Vec<f64>, E> {
    let workers = thread::available_parallelism().map_or(1, usize::from).min(factors.len());
    let next = AtomicUsize::new(0);
    let mut deviations = vec![f64::NAN; factors.len()];
    thread::scope(|scope| {
        let (sender, results) = mpsc::channel();
        for _ in 0..workers {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || {
                let indices = iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
                for k in indices.take_while(|&k| k < factors.len()) {
                    if sender.send((k, integral.deviation(factors[k]))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        for (done, (k, deviation)) in results.into_iter().enumerate() {
            deviations[k] = deviation;
            progress((done + 1) as f64 / factors.len() as f64)?;
        }
        Ok(())
    })?;
    Ok(deviations)
}

/// The dominant noise at each averaging time.
///
/// Quantization noise dominates a contiguous range from the shortest averaging time, or none.  At
/// long averaging times the slope is uncertain; a false identification as quantization noise would
/// give degrees of freedom that are thousands of times too large.
fn noises(factors: &[usize], deviation: &[f64]) -> impl Iterator<Item = Noise> {
    let slopes = (0..factors.len()).map(|k| slope(factors, deviation, k));
    slopes.map(Noise::of_slope).scan(true, |quantized, noise| {
        *quantized &= noise == Noise::Quantization;
        Some(if *quantized || noise != Noise::Quantization { noise } else { Noise::White })
    })
}

/// Local slope of the variance in log-log axes at the averaging time of index `k`.
#[expect(clippy::cast_precision_loss, reason = "no record has 2^52 samples")]
fn slope(factors: &[usize], deviation: &[f64], k: usize) -> f64 {
    let (from, to) = (k.saturating_sub(SLOPE_REACH), (k + SLOPE_REACH).min(factors.len() - 1));
    2.0 * (deviation[to] / deviation[from]).ln() / (factors[to] as f64 / factors[from] as f64).ln()
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use proptest::prelude::*;

    use super::*;

    fn curve(samples: &[f64]) -> Curve {
        Curve::of(samples, |_| Ok::<(), Infallible>(())).unwrap()
    }

    fn close(a: f64, b: f64) -> bool {
        (a / b - 1.0).abs() < 1e-9
    }

    #[test]
    fn deviation_of_four_samples_equals_the_hand_calculation() {
        let integral = Integral::new(&[1.0, 3.0, 2.0, 5.0]);
        assert!(close(integral.deviation(1), (14.0_f64 / 6.0).sqrt()));
        assert!(close(integral.deviation(2), 1.5 / 2_f64.sqrt()));
        assert!(integral.deviation(3).is_nan());
        assert!(integral.deviation(0).is_nan());
    }

    #[test]
    fn averaging_times_are_ten_per_decade_up_to_a_tenth_of_the_record() {
        assert!(averaging_factors(9).is_empty());
        assert_eq!(averaging_factors(100), [1, 2, 3, 4, 5, 6, 8, 10]);
        assert_eq!(averaging_factors(7_200_000).last(), Some(&630_957));
    }

    #[test]
    fn constant_offset_does_not_change_the_deviation() {
        let noise = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
        let deviation = |offset| {
            let samples: Vec<f64> = (0..200_000).map(|k| offset + noise(k)).collect();
            curve(&samples).deviation
        };
        for (plain, shifted) in deviation(0.0).into_iter().zip(deviation(1024.0)) {
            assert!((shifted / plain - 1.0).abs() < 1e-10, "{plain} {shifted}");
        }
    }

    #[test]
    fn progress_is_called_per_averaging_time_and_can_cancel() {
        let samples = [0.0, 1.0].repeat(500);
        let mut shares = Vec::new();
        let complete = Curve::of(&samples, |share| {
            shares.push(share);
            Ok::<(), Infallible>(())
        });
        assert_eq!(shares.len(), complete.unwrap().factors.len());
        assert!(close(shares[shares.len() - 1], 1.0));
        let mut calls = 0;
        let cancelled = Curve::of(&samples, |_| {
            calls += 1;
            Err("cancelled")
        });
        assert_eq!((cancelled, calls), (Err("cancelled"), 1));
    }

    #[test]
    fn quantization_noise_is_identified_at_the_shortest_averaging_times_only() {
        let factors = [1, 2, 4, 8, 16, 32, 64];
        let steep = [64.0, 32.0, 16.0, 8.0, 4.0, 2.0, 1.0];
        let steep_late = [4.0, 4.0, 4.0, 4.0, 4.0, 2.0, 1.0];
        assert!(noises(&factors, &steep).all(|noise| noise == Noise::Quantization));
        assert!(noises(&factors, &steep_late).all(|noise| noise != Noise::Quantization));
    }

    proptest! {
        #[test]
        fn deviation_of_a_ramp_is_slope_times_averaging_time_over_root_two(
            slope in 1e-3..1e3_f64, offset in -10.0..10.0_f64, factor in 1..100_u32,
        ) {
            let samples: Vec<f64> = (0..1000).map(|k| offset + slope * f64::from(k)).collect();
            let deviation = Integral::new(&samples).deviation(factor as usize);
            let expected = slope * f64::from(factor) / 2_f64.sqrt();
            prop_assert!((deviation / expected - 1.0).abs() < 1e-8);
        }

        #[test]
        fn deviation_at_factor_one_equals_the_rms_of_first_differences(
            samples in prop::collection::vec(-1.0..1.0_f64, 30..3000),
        ) {
            let (sum, terms) = samples.windows(2).fold((0.0, 0.0), |(sum, terms), pair| {
                (sum + (pair[1] - pair[0]).powi(2), terms + 1.0)
            });
            let expected = f64::sqrt(sum / (2.0 * terms));
            prop_assert!((Integral::new(&samples).deviation(1) / expected - 1.0).abs() < 1e-9);
        }
    }
}
