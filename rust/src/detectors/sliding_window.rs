//! Sums over a sliding window that is centred on the sample in question.

use crate::limits::Limits;
use crate::types::rate::{number, samples};

/// Limits of a window's length, s.
pub(crate) const WINDOW_LIMITS: Limits = Limits::Between(1.0e-4, 10.0);

/// The sums of `N` features over the last samples; NaN until there are as many as the window is
/// long.
///
/// The sums are kept incrementally and taken afresh with every round of the ring, so that rounding
/// errors cannot pile up.
#[derive(Clone, Debug)]
pub(crate) struct Window<const N: usize> {
    /// A ring: the oldest row is at `next`, the newest before it.  NaN where no row came yet, and
    /// so in the sums.
    rows: Vec<[f64; N]>,
    next: usize,
    sums: [f64; N],
}

impl<const N: usize> Window<N> {
    /// A window of about `seconds`, of an odd number of samples and of three at least.
    pub(crate) fn new(seconds: f64, rate_hz: f64) -> Self {
        let length = 2 * samples(0.5 * (seconds * rate_hz - 1.0)).max(1) + 1;
        Self { rows: vec![[f64::NAN; N]; length], next: 0, sums: [f64::NAN; N] }
    }

    /// Samples on each side of the centre.
    pub(crate) fn half(&self) -> usize {
        self.rows.len() / 2
    }

    /// Number of samples, as a divisor.
    pub(crate) fn size(&self) -> f64 {
        number(self.rows.len())
    }

    /// The rows, the oldest first.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[f64; N]> + Clone {
        self.rows[self.next..].iter().chain(&self.rows[..self.next])
    }

    /// The row half a window before the newest.
    pub(crate) fn centre(&self) -> &[f64; N] {
        let centre = self.next + self.half();
        &self.rows[if centre < self.rows.len() { centre } else { centre - self.rows.len() }]
    }

    /// Takes the next row and returns the sums.
    #[inline]
    pub(crate) fn push(&mut self, row: [f64; N]) -> &[f64; N] {
        let oldest = std::mem::replace(&mut self.rows[self.next], row);
        self.next += 1;
        if self.next == self.rows.len() {
            self.next = 0;
            self.sums = self.rows.iter().fold([0.0; N], add);
        } else {
            self.sums = add(self.sums, &std::array::from_fn(|k| row[k] - oldest[k]));
        }
        &self.sums
    }

    pub(crate) fn reset(&mut self) {
        self.rows.fill([f64::NAN; N]);
        self.next = 0;
        self.sums = [f64::NAN; N];
    }
}

fn add<const N: usize>(sums: [f64; N], row: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|k| sums[k] + row[k])
}

/// Variance of `size` values, from their sum and the sum of their squares.
pub(crate) fn variance(sum: f64, squares: f64, size: f64) -> f64 {
    at_least_zero(squares / size - (sum / size).powi(2))
}

/// Takes away what rounding left below zero; NaN stays NaN, where `f64::max` would make it zero and
/// so a foot at rest.
pub(crate) fn at_least_zero(value: f64) -> f64 {
    if value < 0.0 { 0.0 } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_after_a_million_rows_equal_the_sums_taken_afresh() {
        let mut window = Window::<2>::new(0.05, 400.0);
        let row = |k: u32| [1e4 * f64::from(k).sin(), 1e-3 * f64::from(k).cos()];
        for k in 0..1_000_003 {
            window.push(row(k));
        }
        let afresh = |k: usize| window.rows().map(|row| row[k]).sum::<f64>();
        assert!((window.sums[0] - afresh(0)).abs() < 1e-9);
        assert!((window.sums[1] - afresh(1)).abs() < 1e-15);
    }

    #[test]
    fn only_full_windows_have_sums() {
        let mut window = Window::<1>::new(0.025, 200.0);
        for k in 0..20_u32 {
            let sum = window.push([f64::from(k)])[0];
            if k < 4 {
                assert!(sum.is_nan());
            } else {
                assert!((sum - 5.0 * window.centre()[0]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_reset_window_is_empty() {
        let mut window = Window::<1>::new(0.025, 200.0);
        window.push([1.0]);
        window.reset();
        assert!((0..4).all(|_| window.push([1.0])[0].is_nan()));
        assert!((window.push([1.0])[0] - 5.0).abs() < 1e-12);
    }
}
