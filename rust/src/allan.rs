//! Overlapping Allan deviation: how much the means over neighbouring intervals differ, for
//! intervals of every length.
//!
//! With N samples y and their sums X (N + 1 of them, the mean of y removed), the deviation at an
//! averaging time of m samples is
//!
//! ```text
//! s²(m) = 1 / (2 m² (N - 2m + 1)) · Σ (X[k + 2m] - 2 X[k + m] + X[k])²
//! ```
//!
//! # References
//! - W. J. Riley, D. A. Howe, "Handbook of Frequency Stability Analysis", NIST Special Publication
//!   1065, 2008: eq. 11 (the estimator) and table 5 (degrees of freedom); frequency is the rate
//!   here, and phase its sum.
//! - A. Neumaier, "Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen", ZAMM
//!   54, 1974: the compensated sum.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::{iter, sync::mpsc, thread};

/// Averaging times in a decade, where whole numbers of samples lie that close.
const PER_DECADE: i32 = 10;
/// Neighbouring intervals that the longest averaging time leaves.
const FEWEST_CLUSTERS: usize = 10;
/// Squares that are added before they join the total, so that rounding does not grow with the
/// length of the record.
const BLOCK: usize = 1024;
/// Additions that go on at a time.
const LANES: usize = 8;
/// Neighbours on each side that the local slope is taken over: half an octave or more.
const MAX_HOLD: usize = 2;

/// What noise governs the deviation at an averaging time, in the words for an inertial sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// White noise of the sum: the variance falls with the square of the averaging time.
    Quantization,
    /// White noise of the reading: angle or velocity random walk.
    White,
    /// 1/f noise of the reading: the floor.
    BiasInstability,
    /// A bias that walks, or drifts: the variance grows.
    BiasWalk,
}

impl Noise {
    /// The noise whose Allan variance has about this slope in log-log axes.
    #[must_use]
    pub fn of_slope(slope: f64) -> Self {
        match slope {
            ..-1.5 => Self::Quantization,
            -1.5..-0.5 => Self::White,
            -0.5..0.5 => Self::BiasInstability,
            _ => Self::BiasWalk,
        }
    }

    /// Equivalent degrees of freedom of the overlapping estimate from `samples` readings at an
    /// averaging time of `factor` of them (NIST SP 1065, table 5).
    ///
    /// The estimated variance is distributed as the true one times chi-squared over its degrees of
    /// freedom.
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

/// Averaging times, in samples, for a record of `samples`: ten a decade, as long as ten intervals
/// are left.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounded, positive, and held to the record"
)]
pub fn averaging_factors(samples: usize) -> Vec<usize> {
    let spaced = (0..).map(|k| 10_f64.powf(f64::from(k) / f64::from(PER_DECADE)).round() as usize);
    let mut factors: Vec<usize> =
        spaced.take_while(|factor| factor * FEWEST_CLUSTERS <= samples).collect();
    factors.dedup();
    factors
}

/// Sums of a record up to each of its samples, its mean removed.
#[derive(Clone, Debug)]
pub struct Integral {
    sums: Vec<f64>,
}

impl Integral {
    /// Sums `samples` up; each sum is rounded once, however long the record is.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "no record has 2^52 samples")]
    pub fn new(samples: &[f64]) -> Self {
        let mut total = CompensatedSum::default();
        for &sample in samples {
            total.add(sample);
        }
        let mean = total.value() / samples.len() as f64;
        let mut sum = CompensatedSum::default();
        let following = samples.iter().map(|sample| {
            sum.add(sample - mean);
            sum.value()
        });
        Self { sums: iter::once(0.0).chain(following).collect() }
    }

    /// Overlapping Allan deviation at an averaging time of `factor` samples, in the unit of the
    /// samples; NaN when the record is not twice as long.
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

/// Sum of the squared second differences of sums that are a factor apart.
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

/// A sum and what rounding has taken from it.
#[derive(Default)]
struct CompensatedSum {
    sum: f64,
    lost: f64,
}

impl CompensatedSum {
    fn add(&mut self, value: f64) {
        let before = self.sum;
        self.sum += value;
        let (large, small) =
            if before.abs() >= value.abs() { (before, value) } else { (value, before) };
        self.lost += (large - self.sum) + small;
    }

    fn value(&self) -> f64 {
        self.sum + self.lost
    }
}

/// Allan deviation of one channel over the averaging times.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Averaging times, in samples.
    pub factors: Vec<usize>,
    /// Deviation at each, in the unit of the samples.
    pub deviation: Vec<f64>,
    /// Equivalent degrees of freedom of each, for the noise that the local slope of the curve
    /// shows.
    pub degrees_of_freedom: Vec<f64>,
}

impl Curve {
    /// The curve of evenly spaced `samples`, on all processors.
    ///
    /// `progress` hears after each averaging time what share of them is done, in the calling
    /// thread, and can end the work with an error.
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

/// Deviation at each of `factors`; the workers end when nobody takes their results any more.
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
                let places = iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
                for k in places.take_while(|&k| k < factors.len()) {
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

/// The noise that governs each averaging time.
///
/// Quantization rules the shortest ones or none.  Where the slope is uncertain, at the longest, it
/// would be mistaken for it, with degrees of freedom as if the record were thousands of times as
/// long.
fn noises(factors: &[usize], deviation: &[f64]) -> impl Iterator<Item = Noise> {
    let slopes = (0..factors.len()).map(|k| slope(factors, deviation, k));
    slopes.map(Noise::of_slope).scan(true, |quantized, noise| {
        *quantized &= noise == Noise::Quantization;
        Some(if *quantized || noise != Noise::Quantization { noise } else { Noise::White })
    })
}

/// Slope of the variance in log-log axes about the averaging time `k`.
#[expect(clippy::cast_precision_loss, reason = "no record has 2^52 samples")]
fn slope(factors: &[usize], deviation: &[f64], k: usize) -> f64 {
    let (from, to) = (k.saturating_sub(MAX_HOLD), (k + MAX_HOLD).min(factors.len() - 1));
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
    fn four_samples_by_hand() {
        let integral = Integral::new(&[1.0, 3.0, 2.0, 5.0]);
        assert!(close(integral.deviation(1), (14.0_f64 / 6.0).sqrt()));
        assert!(close(integral.deviation(2), 1.5 / 2_f64.sqrt()));
        assert!(integral.deviation(3).is_nan());
        assert!(integral.deviation(0).is_nan());
    }

    #[test]
    fn averaging_times_are_ten_a_decade_and_leave_ten_intervals() {
        assert!(averaging_factors(9).is_empty());
        assert_eq!(averaging_factors(100), [1, 2, 3, 4, 5, 6, 8, 10]);
        assert_eq!(averaging_factors(7_200_000).last(), Some(&630_957));
    }

    #[test]
    fn an_offset_costs_no_precision() {
        let noise = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
        let deviation = |offset| {
            let samples: Vec<f64> = (0..200_000).map(|k| offset + noise(k)).collect();
            curve(&samples).deviation
        };
        let spoilt = 1e-10;
        for (plain, shifted) in deviation(0.0).into_iter().zip(deviation(1024.0)) {
            assert!((shifted / plain - 1.0).abs() < spoilt, "{plain} {shifted}");
        }
    }

    #[test]
    fn the_one_who_watches_hears_of_every_averaging_time_and_can_stop() {
        let samples = [0.0, 1.0].repeat(500);
        let mut shares = Vec::new();
        let whole = Curve::of(&samples, |share| {
            shares.push(share);
            Ok::<(), Infallible>(())
        });
        assert_eq!(shares.len(), whole.unwrap().factors.len());
        assert!(close(shares[shares.len() - 1], 1.0));
        let mut heard = 0;
        let stopped = Curve::of(&samples, |_| {
            heard += 1;
            Err("enough")
        });
        assert_eq!((stopped, heard), (Err("enough"), 1));
    }

    #[test]
    fn only_the_shortest_averaging_times_are_quantized() {
        let factors = [1, 2, 4, 8, 16, 32, 64];
        let steep = [64.0, 32.0, 16.0, 8.0, 4.0, 2.0, 1.0];
        let steep_late = [4.0, 4.0, 4.0, 4.0, 4.0, 2.0, 1.0];
        assert!(noises(&factors, &steep).all(|noise| noise == Noise::Quantization));
        assert!(noises(&factors, &steep_late).all(|noise| noise != Noise::Quantization));
    }

    proptest! {
        #[test]
        fn a_ramp_deviates_by_its_slope(slope in 1e-3..1e3_f64, offset in -10.0..10.0_f64, factor in 1..100_u32) {
            let samples: Vec<f64> = (0..1000).map(|k| offset + slope * f64::from(k)).collect();
            let deviation = Integral::new(&samples).deviation(factor as usize);
            prop_assert!((deviation / (slope * f64::from(factor) / 2_f64.sqrt()) - 1.0).abs() < 1e-8);
        }

        #[test]
        fn sums_of_squares_do_not_depend_on_the_lanes(samples in prop::collection::vec(-1.0..1.0_f64, 30..3000)) {
            let (sum, terms) = samples.windows(2).fold((0.0, 0.0), |(sum, terms), pair| (sum + (pair[1] - pair[0]).powi(2), terms + 1.0));
            let expected = f64::sqrt(sum / (2.0 * terms));
            prop_assert!((Integral::new(&samples).deviation(1) / expected - 1.0).abs() < 1e-9);
        }
    }
}
