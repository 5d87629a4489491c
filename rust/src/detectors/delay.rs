//! Fixed delay of a stream of values.

/// Delays each value by a fixed number of values.
#[derive(Clone, Debug)]
pub(crate) struct Delay {
    /// Ring buffer: the newest value is before `next`, the oldest at `next`; NaN before the first
    /// value.
    values: Vec<f64>,
    next: usize,
}

impl Delay {
    /// A delay of `values` values.
    pub(crate) fn new(values: usize) -> Self {
        Self { values: vec![f64::NAN; values + 1], next: 0 }
    }

    /// Takes the next value and returns the delayed one; NaN if there is none.
    pub(crate) fn push(&mut self, value: f64) -> f64 {
        self.values[self.next] = value;
        self.next = if self.next + 1 == self.values.len() { 0 } else { self.next + 1 };
        self.values[self.next]
    }

    pub(crate) fn reset(&mut self) {
        self.values.fill(f64::NAN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::rate::number;

    #[test]
    fn values_are_delayed_by_the_given_number() {
        for length in 0..4 {
            let mut delay = Delay::new(length);
            for _ in 0..2 {
                assert!((0..length).all(|k| delay.push(number(k)).is_nan()));
                assert!(
                    (0..12)
                        .all(|k| delay.push(number(length + k)).to_bits() == number(k).to_bits())
                );
                delay.reset();
            }
        }
    }
}
