//! Values that come late.

/// Hands out each value when a fixed number of others came after it.
#[derive(Clone, Debug)]
pub(crate) struct Delay {
    /// A ring: the newest value is before `next`, the oldest at `next`; NaN where no value came
    /// yet.
    values: Vec<f64>,
    next: usize,
}

impl Delay {
    /// Of `values` values.
    pub(crate) fn new(values: usize) -> Self {
        Self { values: vec![f64::NAN; values + 1], next: 0 }
    }

    /// Takes the next value and returns the one so many before it; NaN if there is none.
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
    fn a_value_comes_out_when_as_many_others_came_after_it() {
        for late in 0..4 {
            let mut delay = Delay::new(late);
            for _ in 0..2 {
                assert!((0..late).all(|k| delay.push(number(k)).is_nan()));
                assert!(
                    (0..12).all(|k| delay.push(number(late + k)).to_bits() == number(k).to_bits())
                );
                delay.reset();
            }
        }
    }
}
