//! The least and the greatest value of a sliding window, without a branch that depends on the values.
//!
//! # References
//! - M. van Herk, "A fast algorithm for local minimum and maximum filters on rectangular and octagonal kernels", Pattern Recognition Letters 13, 1992; J. Gil, M. Werman,
//!   "Computing 2-D min, median, and max filters", IEEE PAMI 15, 1993.

/// The least and the greatest of some values; of none, +∞ and -∞.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extremes {
    pub(super) least: f64,
    pub(super) greatest: f64,
}

impl Extremes {
    const OF_NONE: Self = Self { least: f64::INFINITY, greatest: f64::NEG_INFINITY };

    fn of(value: f64) -> Self {
        Self { least: value, greatest: value }
    }

    /// Of both; NaN among the others is none.
    fn and(self, other: Self) -> Self {
        Self { least: lesser(self.least, other.least), greatest: greater(self.greatest, other.greatest) }
    }
}

/// The lesser of two, `a` if `b` is NaN; a single instruction, as `f64::min` is not, which asks that of both.
pub(super) fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The greater of two, `a` if `b` is NaN.
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// The extremes of the last values.
///
/// Time is cut into blocks as long as the window.  A window ends in one block and began in the one before: its extremes are those of the first values of the one and of the last values of
/// the other, which are taken for all its ends at once when a block is full.
#[derive(Clone, Debug)]
pub(super) struct SlidingExtremes {
    /// Up to `filled` the values of this block; from there on the extremes from each place of the last block to its end.
    places: Vec<Extremes>,
    filled: usize,
    of_block: Extremes,
}

impl SlidingExtremes {
    /// Of a window of `span` values, one at least.
    pub(super) fn new(span: usize) -> Self {
        Self { places: vec![Extremes::OF_NONE; span], filled: 0, of_block: Extremes::OF_NONE }
    }

    /// Takes the next value and returns the extremes of the window that ends with it; NaN only makes the window move on.
    pub(super) fn push(&mut self, value: f64) -> Extremes {
        let value = Extremes::of(value);
        self.places[self.filled] = value;
        self.of_block = self.of_block.and(value);
        self.filled += 1;
        match self.places.get(self.filled) {
            Some(&of_last_block) => of_last_block.and(self.of_block),
            None => self.begin_block(),
        }
    }

    /// The block is full, and is the whole window.
    fn begin_block(&mut self) -> Extremes {
        let mut to_end = Extremes::OF_NONE;
        for place in self.places.iter_mut().rev() {
            to_end = to_end.and(*place);
            *place = to_end;
        }
        self.filled = 0;
        std::mem::replace(&mut self.of_block, Extremes::OF_NONE)
    }

    pub(super) fn reset(&mut self) {
        self.places.fill(Extremes::OF_NONE);
        self.filled = 0;
        self.of_block = Extremes::OF_NONE;
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
            let mut sliding = SlidingExtremes::new(span);
            for end in 1..=values.len() {
                let found = sliding.push(values[end - 1]);
                let window = &values[end.saturating_sub(span)..end];
                let least = window.iter().copied().fold(f64::INFINITY, f64::min);
                let greatest = window.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                prop_assert_eq!(found, Extremes { least, greatest });
            }
        }
    }
}
