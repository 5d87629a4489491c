//! Limits of parameters; a NaN or an infinite value is never within them.

use std::fmt::{Display, Formatter, Result as FormatResult};
use std::ops::RangeInclusive;

use serde::{Serialize, Serializer};

use crate::error::ConfigError;

/// Values that a numerical setting may have; its text completes "expected ...".
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limits {
    /// Any finite number.
    Finite,
    /// Above zero.
    Positive,
    /// Zero or above.
    NonNegative,
    /// The number or above.
    AtLeast(f64),
    /// From the first number to the second.
    Between(f64, f64),
}

impl Limits {
    /// Whether `value` is within the limits.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        let lowest = match self {
            Self::Finite => f64::MIN,
            Self::Positive => f64::MIN_POSITIVE,
            Self::NonNegative => 0.0,
            Self::AtLeast(lowest) | Self::Between(lowest, _) => lowest,
        };
        let highest = if let Self::Between(_, highest) = self { highest } else { f64::MAX };
        (lowest..=highest).contains(&value)
    }

    /// The text with the unit after the numbers in it.
    pub(crate) fn with_unit(self, unit: &str) -> String {
        match self {
            Self::AtLeast(_) | Self::Between(..) if !unit.is_empty() => format!("{self} {unit}"),
            _ => self.to_string(),
        }
    }
}

impl Display for Limits {
    fn fmt(&self, text: &mut Formatter<'_>) -> FormatResult {
        match self {
            Self::Finite => text.write_str("a finite number"),
            Self::Positive => text.write_str("a positive number"),
            Self::NonNegative => text.write_str("zero or a positive number"),
            Self::AtLeast(lowest) => write!(text, "at least {lowest}"),
            Self::Between(lowest, highest) => write!(text, "between {lowest} and {highest}"),
        }
    }
}

impl Serialize for Limits {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Checks that `value` lies in `range`.
pub(crate) fn within(
    key: &'static str,
    value: f64,
    range: RangeInclusive<f64>,
    expected: &'static str,
) -> Result<(), ConfigError> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(ConfigError::OutOfRange { key, value: value.to_string(), expected: expected.into() })
}

pub(crate) fn at_least_zero(key: &'static str, value: f64) -> Result<(), ConfigError> {
    within(key, value, 0.0..=f64::MAX, "zero or a positive number")
}

/// Checks that every one of `values` is finite.
pub(crate) fn finite(key: &'static str, values: &[f64]) -> Result<(), ConfigError> {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    let (value, expected) = (format!("{values:?}"), "finite numbers".into());
    Err(ConfigError::OutOfRange { key, value, expected })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Limits; 5] = [
        Limits::Finite,
        Limits::Positive,
        Limits::NonNegative,
        Limits::AtLeast(1.5),
        Limits::Between(-2.0, 0.5),
    ];

    #[test]
    fn limits_include_their_bounds_and_exclude_the_rest() {
        let inside = [[-1e300, 1e300], [1e-300, 1e300], [0.0, 1e300], [1.5, 1e300], [-2.0, 0.5]];
        let outside = [f64::NAN, 0.0, -1e-300, 1.4999, 0.5001];
        for ((limits, inside), outside) in ALL.into_iter().zip(inside).zip(outside) {
            assert!(inside.into_iter().all(|value| limits.contains(value)), "{limits}");
            assert!(!limits.contains(outside), "{limits}");
        }
    }

    #[test]
    fn no_limits_include_a_value_that_is_not_finite() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(ALL.into_iter().all(|limits| !limits.contains(value)));
        }
    }
}
