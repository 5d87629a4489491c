//! Minimum and maximum of a sliding window, without data-dependent branches.
//!
//! # References
//! - M. van Herk, "A fast algorithm for local minimum and maximum filters on rectangular and
//!   octagonal kernels", Pattern Recognition Letters 13, 1992; J. Gil, M. Werman, "Computing 2-D
//!   min, median, and max filters", IEEE PAMI 15, 1993.

/// Minimum and maximum of a set of values; +∞ and -∞ of the empty set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MinMax {
    pub(crate) min: f64,
    pub(crate) max: f64,
}

impl MinMax {
    const EMPTY: Self = Self { min: f64::INFINITY, max: f64::NEG_INFINITY };

    fn of(value: f64) -> Self {
        Self { min: value, max: value }
    }

    /// Minimum and maximum of the union; NaN in `other` is ignored.
    fn union(self, other: Self) -> Self {
        Self { min: min(self.min, other.min), max: max(self.max, other.max) }
    }
}

/// Minimum of two values, `a` if `b` is NaN.
///
/// It is a single instruction; `f64::min` is not, because it checks both for NaN.
pub(crate) fn min(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// Maximum of two values, `a` if `b` is NaN.
pub(crate) fn max(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Minimum and maximum of the last values (van Herk 1992; Gil and Werman 1993).
///
/// The stream is divided into blocks as long as the window.  A window starts in one block and ends
/// in the next: its extremes combine those of the tail of the first block with those of the head of
/// the second.  The extremes of all tails are computed when a block is full.
#[derive(Clone, Debug)]
pub(crate) struct SlidingMinMax {
    /// Up to `filled`, the values of the current block; beyond, the extremes of the tails of the
    /// previous block.
    slots: Vec<MinMax>,
    filled: usize,
    block: MinMax,
}

impl SlidingMinMax {
    /// A window of `span` values, at least one.
    pub(crate) fn new(span: usize) -> Self {
        Self { slots: vec![MinMax::EMPTY; span], filled: 0, block: MinMax::EMPTY }
    }

    /// Takes the next value and returns the extremes of the window that ends with it; a NaN is
    /// ignored but occupies its place in the window.
    pub(crate) fn push(&mut self, value: f64) -> MinMax {
        let value = MinMax::of(value);
        self.slots[self.filled] = value;
        self.block = self.block.union(value);
        self.filled += 1;
        match self.slots.get(self.filled) {
            Some(&tail) => tail.union(self.block),
            None => self.begin_block(),
        }
    }

    /// Computes the extremes of the tails of the full block; the block is the window.
    fn begin_block(&mut self) -> MinMax {
        let mut tail = MinMax::EMPTY;
        for slot in self.slots.iter_mut().rev() {
            tail = tail.union(*slot);
            *slot = tail;
        }
        self.filled = 0;
        std::mem::replace(&mut self.block, MinMax::EMPTY)
    }

    pub(crate) fn reset(&mut self) {
        self.slots.fill(MinMax::EMPTY);
        self.filled = 0;
        self.block = MinMax::EMPTY;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn sliding_extremes_equal_those_of_each_window(
            values in prop::collection::vec(prop_oneof![9 => -9.0..9.0, 1 => Just(f64::NAN)], 1..60),
            span in 1usize..12,
        ) {
            let mut sliding = SlidingMinMax::new(span);
            for end in 1..=values.len() {
                let found = sliding.push(values[end - 1]);
                let window = &values[end.saturating_sub(span)..end];
                let min = window.iter().copied().fold(f64::INFINITY, f64::min);
                let max = window.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                prop_assert_eq!(found, MinMax { min, max });
            }
        }
    }
}
