//! Checks of parameters against the range that makes sense; a NaN is never in it.

use std::ops::RangeInclusive;

use crate::error::ConfigError;

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
    Err(ConfigError::OutOfRange { key, value: value.to_string(), expected })
}

pub(crate) fn positive(key: &'static str, value: f64) -> Result<(), ConfigError> {
    within(key, value, f64::MIN_POSITIVE..=f64::MAX, "a positive number")
}

pub(crate) fn at_least_zero(key: &'static str, value: f64) -> Result<(), ConfigError> {
    within(key, value, 0.0..=f64::MAX, "zero or a positive number")
}

/// Checks that every one of `values` is finite.
pub(crate) fn finite(key: &'static str, values: &[f64]) -> Result<(), ConfigError> {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(ConfigError::OutOfRange { key, value: format!("{values:?}"), expected: "finite numbers" })
}
