//! Values that come late.

/// Hands out each value when a fixed number of others came after it.
#[derive(Clone, Debug)]
pub(super) struct Delay {
    /// A ring: the newest value is before `next`, the oldest at `next`; NaN where no value came yet.
    values: Vec<f64>,
    next: usize,
}

impl Delay {
    /// Of `values` values.
    pub(super) fn new(values: usize) -> Self {
        Self { values: vec![f64::NAN; values + 1], next: 0 }
    }

    /// Takes the next value and returns the one so many before it; NaN if there is none.
    pub(super) fn push(&mut self, value: f64) -> f64 {
        self.values[self.next] = value;
        self.next = if self.next + 1 == self.values.len() { 0 } else { self.next + 1 };
        self.values[self.next]
    }

    pub(super) fn reset(&mut self) {
        self.values.fill(f64::NAN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_comes_out_when_as_many_others_came_after_it() {
        for late in 0..4_u32 {
            let mut delay = Delay::new(late as usize);
            for k in 0..12 {
                let found = delay.push(f64::from(k));
                assert!(if k < late { found.is_nan() } else { found == f64::from(k - late) });
            }
            delay.reset();
            assert_eq!(delay.push(1.0).is_nan(), late > 0);
        }
    }
}
