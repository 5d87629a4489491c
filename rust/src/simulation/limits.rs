//! Checks of parameters against the range that makes sense.

use std::ops::RangeInclusive;

use crate::error::ConfigError;

/// Checks that `value` lies in `range`; a NaN never does.
pub(super) fn within(
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

/// Checks that every one of `values` is finite.
pub(super) fn finite(key: &'static str, values: &[f64]) -> Result<(), ConfigError> {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(ConfigError::OutOfRange { key, value: format!("{values:?}"), expected: "finite numbers" })
}
