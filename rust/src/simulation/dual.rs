//! Dual numbers in time: each quantity carries its rate, so a velocity is the exact derivative of
//! its position.

use std::ops::{Add, Mul, Sub};

/// A quantity and its derivative with respect to time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dual {
    /// The quantity.
    pub(super) value: f64,
    /// Its derivative, per second.
    pub(super) rate: f64,
}

impl Dual {
    pub(super) const ZERO: Self = Self::constant(0.0);

    pub(super) const fn constant(value: f64) -> Self {
        Self { value, rate: 0.0 }
    }

    pub(super) fn sin(self) -> Self {
        Self { value: self.value.sin(), rate: self.rate * self.value.cos() }
    }

    pub(super) fn exp(self) -> Self {
        let value = self.value.exp();
        Self { value, rate: self.rate * value }
    }
}

impl Add for Dual {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, rate: self.rate + other.rate }
    }
}

impl Sub for Dual {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, rate: self.rate - other.rate }
    }
}

impl Mul for Dual {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            rate: self.rate * other.value + self.value * other.rate,
        }
    }
}

impl Mul<f64> for Dual {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { value: self.value * factor, rate: self.rate * factor }
    }
}

/// A smooth rise from 0 to 1 with continuous first and second derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ramp {
    /// Time at which it leaves 0, s.
    pub(super) start: f64,
    /// Time at which it reaches 1, s.
    pub(super) end: f64,
    /// Skew: 0 for a symmetrical rise, 1 for the slowest start.
    pub(super) skew: f64,
}

impl Ramp {
    pub(super) fn new(start: f64, end: f64) -> Self {
        Self { start, end, skew: 0.0 }
    }

    pub(super) fn skewed(self, skew: f64) -> Self {
        Self { skew, ..self }
    }

    pub(super) fn at(&self, time: f64) -> Dual {
        if time <= self.start {
            return Dual::ZERO;
        }
        if time >= self.end {
            return Dual::constant(1.0);
        }
        let scale = 1.0 / (self.end - self.start);
        let phase = Dual { value: (time - self.start) * scale, rate: scale };
        let u = phase * (1.0 - self.skew) + phase * phase * self.skew;
        // Quintic smoothstep: the first two derivatives vanish at both ends.
        u * u * u * (Dual::constant(10.0) - u * 15.0 + u * u * 6.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramp_rises_from_zero_to_one_and_stays_constant_outside() {
        let ramp = Ramp::new(2.0, 4.0).skewed(0.7);
        assert_eq!(ramp.at(1.9), Dual::ZERO);
        assert_eq!(ramp.at(4.1), Dual::constant(1.0));
        assert!((Ramp::new(2.0, 4.0).at(3.0).value - 0.5).abs() < 1e-15);
    }

    #[test]
    fn rates_equal_numerical_derivatives() {
        let ramp = Ramp::new(0.3, 1.1).skewed(0.4);
        let wave = |t: f64| {
            let time = Dual { value: t, rate: 1.0 };
            (time * 5.0).sin() * (time * -2.0).exp() * ramp.at(t) - time
        };
        let step = 1e-5;
        for k in 0..120 {
            let t = 0.01 * f64::from(k);
            let difference = (wave(t + step).value - wave(t - step).value) / (2.0 * step);
            assert!(
                (difference - wave(t).rate).abs() < 1e-7,
                "at {t}: {difference} {}",
                wave(t).rate
            );
        }
    }
}
