//! The least and the greatest value of a sliding window, without a branch that depends on the
//! values.
//!
//! # References
//! - M. van Herk, "A fast algorithm for local minimum and maximum filters on rectangular and
//!   octagonal kernels", Pattern Recognition Letters 13, 1992; J. Gil, M. Werman, "Computing 2-D
//!   min, median, and max filters", IEEE PAMI 15, 1993.

/// The least and the greatest of some values; of none, +∞ and -∞.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MinMax {
    pub(crate) least: f64,
    pub(crate) greatest: f64,
}

impl MinMax {
    const OF_NONE: Self = Self { least: f64::INFINITY, greatest: f64::NEG_INFINITY };

    fn of(value: f64) -> Self {
        Self { least: value, greatest: value }
    }

    /// Of both; NaN among the others is none.
    fn and(self, other: Self) -> Self {
        Self { least: min(self.least, other.least), greatest: max(self.greatest, other.greatest) }
    }
}

/// The min of two, `a` if `b` is NaN; a single instruction, as `f64::min` is not, which asks that
/// of both.
pub(crate) fn min(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The max of two, `a` if `b` is NaN.
pub(crate) fn max(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// The extremes of the last values.
///
/// Time is cut into blocks as long as the window.  A window ends in one block and began in the one
/// before: its extremes are those of the first values of the one and of the last values of the
/// other, which are taken for all its ends at once when a block is full.
#[derive(Clone, Debug)]
pub(crate) struct SlidingMinMax {
    /// Up to `filled` the values of this block; from there on the extremes from each place of the
    /// last block to its end.
    places: Vec<MinMax>,
    filled: usize,
    of_block: MinMax,
}

impl SlidingMinMax {
    /// Of a window of `span` values, one at least.
    pub(crate) fn new(span: usize) -> Self {
        Self { places: vec![MinMax::OF_NONE; span], filled: 0, of_block: MinMax::OF_NONE }
    }

    /// Takes the next value and returns the extremes of the window that ends with it; NaN only
    /// makes the window move on.
    pub(crate) fn push(&mut self, value: f64) -> MinMax {
        let value = MinMax::of(value);
        self.places[self.filled] = value;
        self.of_block = self.of_block.and(value);
        self.filled += 1;
        match self.places.get(self.filled) {
            Some(&of_last_block) => of_last_block.and(self.of_block),
            None => self.begin_block(),
        }
    }

    /// The block is full, and is the whole window.
    fn begin_block(&mut self) -> MinMax {
        let mut to_end = MinMax::OF_NONE;
        for place in self.places.iter_mut().rev() {
            to_end = to_end.and(*place);
            *place = to_end;
        }
        self.filled = 0;
        std::mem::replace(&mut self.of_block, MinMax::OF_NONE)
    }

    pub(crate) fn reset(&mut self) {
        self.places.fill(MinMax::OF_NONE);
        self.filled = 0;
        self.of_block = MinMax::OF_NONE;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_sliding_extremes_are_those_of_the_window(
            values in prop::collection::vec(prop_oneof![9 => -9.0..9.0, 1 => Just(f64::NAN)], 1..60),
            span in 1usize..12,
        ) {
            let mut sliding = SlidingMinMax::new(span);
            for end in 1..=values.len() {
                let found = sliding.push(values[end - 1]);
                let window = &values[end.saturating_sub(span)..end];
                let least = window.iter().copied().fold(f64::INFINITY, f64::min);
                let greatest = window.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                prop_assert_eq!(found, MinMax { least, greatest });
            }
        }
    }
}
