//! Sums over a sliding window that is centred on the sample in question.

/// The sums of `N` features over the last samples.
///
/// The sums are kept incrementally and taken afresh once per window length, so that rounding errors cannot pile up.
#[derive(Clone, Debug)]
pub(super) struct Window<const N: usize> {
    length: usize,
    /// A ring: the newest row is the one before `next`, the oldest is at `next` once the window is full.
    rows: Vec<[f64; N]>,
    next: usize,
    sums: [f64; N],
    seen: u64,
    answered: u64,
}

/// What a window can say of the sample at its centre.
pub(super) enum Centred<'a, const N: usize> {
    /// The window is full: its sums and the row at its centre.
    Full { sums: &'a [f64; N], centre: &'a [f64; N] },
    /// Too close to the start of the data.
    Filling,
}

impl<const N: usize> Window<N> {
    /// A window of about `seconds`, of an odd number of samples and of three at least.
    pub(super) fn new(seconds: f64, rate_hz: f64) -> Self {
        let length = 2 * samples(0.5 * (seconds * rate_hz - 1.0)).max(1) + 1;
        Self { length, rows: Vec::with_capacity(length), next: 0, sums: [0.0; N], seen: 0, answered: 0 }
    }

    /// Samples on each side of the centre.
    pub(super) fn half(&self) -> usize {
        self.length / 2
    }

    /// Number of samples, as a divisor.
    #[expect(clippy::cast_precision_loss, reason = "a window holds few samples")]
    pub(super) fn size(&self) -> f64 {
        self.length as f64
    }

    /// Takes the next row; answers once there is a sample half a window before it.
    pub(super) fn push(&mut self, row: [f64; N]) -> Option<Centred<'_, N>> {
        let leaving = self.put(row);
        self.seen += 1;
        if self.next == 0 {
            self.sums = self.rows.iter().fold([0.0; N], add);
        } else {
            for ((sum, new), old) in self.sums.iter_mut().zip(row).zip(leaving) {
                *sum += new - old;
            }
        }
        if self.rows.len() <= self.half() {
            return None;
        }
        self.answered += 1;
        let centre = self.next + self.half();
        let centre = if centre < self.length { centre } else { centre - self.length };
        Some(match self.rows.get(centre) {
            Some(centre) if self.rows.len() == self.length => Centred::Full { sums: &self.sums, centre },
            _ => Centred::Filling,
        })
    }

    /// Puts a row into the ring and returns the one that leaves; zeros while the ring fills up.
    fn put(&mut self, row: [f64; N]) -> [f64; N] {
        let at = self.next;
        self.next = if at + 1 == self.length { 0 } else { at + 1 };
        if let Some(oldest) = self.rows.get_mut(at) {
            return std::mem::replace(oldest, row);
        }
        self.rows.push(row);
        [0.0; N]
    }

    /// After the end of the data: whether one more sample without a full window waits for its answer.
    pub(super) fn drain(&mut self) -> bool {
        let owes = self.answered < self.seen;
        self.answered += u64::from(owes);
        owes
    }

    pub(super) fn reset(&mut self) {
        self.rows.clear();
        self.next = 0;
        self.sums = [0.0; N];
        self.seen = 0;
        self.answered = 0;
    }
}

fn add<const N: usize>(mut sums: [f64; N], row: &[f64; N]) -> [f64; N] {
    for (sum, value) in sums.iter_mut().zip(row) {
        *sum += value;
    }
    sums
}

/// Variance of `size` values, from their sum and the sum of their squares.
pub(super) fn variance(sum: f64, squares: f64, size: f64) -> f64 {
    at_least_zero(squares / size - (sum / size).powi(2))
}

/// Takes away what rounding left below zero; NaN stays NaN, where `f64::max` would make it zero and so a foot at rest.
pub(super) fn at_least_zero(value: f64) -> f64 {
    if value < 0.0 { 0.0 } else { value }
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
        let afresh = window.rows.iter().fold([0.0; 2], add);
        assert!((window.sums[0] - afresh[0]).abs() < 1e-9);
        assert!((window.sums[1] - afresh[1]).abs() < 1e-15);
    }

    #[test]
    fn every_row_is_answered_once_and_only_full_windows_have_sums() {
        let mut window = Window::<1>::new(0.025, 200.0);
        let (mut filling, mut full) = (0, 0);
        for k in 0..20 {
            match window.push([f64::from(k)]) {
                None => assert!(k < 2),
                Some(Centred::Filling) => filling += 1,
                Some(Centred::Full { sums, centre }) => {
                    full += 1;
                    assert!((sums[0] - 5.0 * centre[0]).abs() < 1e-12);
                }
            }
        }
        let owed = std::iter::from_fn(|| window.drain().then_some(())).count();
        assert_eq!((filling, full, owed), (2, 16, 2));
    }
}
