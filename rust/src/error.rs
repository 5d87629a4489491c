//! Errors, one enum per domain.

use std::borrow::Cow;

use thiserror::Error;

/// Any failure of footnav.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting is unknown, out of range, or inconsistent with another setting.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A sample cannot be used.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The filter diverged numerically.
    #[error(transparent)]
    Numerical(#[from] NumericalError),
}

/// An invalid configuration.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// A value is outside the limits of its setting.
    #[error("{key} = {value}: expected {expected}")]
    OutOfRange {
        /// Dotted name of the setting, such as `detector.window`.
        key: &'static str,
        /// The given value.
        value: String,
        /// Limits of the setting.
        expected: Cow<'static, str>,
    },
    /// Two settings are inconsistent, or one requires another that is missing.
    #[error("{0}")]
    Inconsistent(String),
    /// The text is not a valid configuration file.
    #[error("{0}")]
    Syntax(String),
    /// No preset of that name.
    #[error("unknown preset {name:?}: the known ones are {known}")]
    UnknownPreset {
        /// The requested name.
        name: String,
        /// The available names.
        known: String,
    },
}

/// A sample, or a run of samples, that cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DataError {
    /// A stamp or a channel is NaN or infinite.
    #[error(
        "sample {index}: {channel} is {value}; leave the sample out, \
         the gap is bridged and reported"
    )]
    NonFinite {
        /// Number of the sample, counted from 0 since the start or the last reset.
        index: u64,
        /// Name of the channel.
        channel: &'static str,
        /// The value.
        value: f64,
    },
    /// A stamp is not later than that of the previous sample.
    #[error(
        "sample {index}: time goes back from {previous} s to {time} s; sort the samples \
         or leave this one out; if the clock was set back, reset() begins a new walk"
    )]
    TimeReversed {
        /// Number of the sample.
        index: u64,
        /// Stamp of the sample, s.
        time: f64,
        /// Stamp of the previous sample, s.
        previous: f64,
    },
    /// The specific force at the start is not gravity in m/s².
    #[error(
        "the specific force at the start is {magnitude:.3}, not about 9.8 m/s^2; {}",
        if *magnitude < 2.0 {
            "it looks like g: multiply by 9.80665"
        } else {
            "check the accelerometer's range and unit"
        }
    )]
    NotGravity {
        /// Mean magnitude, m/s².
        magnitude: f64,
    },
    /// The axis that the heading refers to is too steep.
    #[error(
        "the heading was given for the sensor's {axis} axis, which is {elevation_deg:.0} deg \
         from the horizontal; set alignment.forward_axis to an axis that lies flat"
    )]
    SteepForwardAxis {
        /// Name of the axis.
        axis: &'static str,
        /// Its elevation above the horizontal, degrees.
        elevation_deg: f64,
    },
    /// A sample was pushed after `flush()`.
    #[error("the data were ended by flush(); call reset() to begin a new walk")]
    AfterFlush,
    /// The data end before the initial alignment is complete.
    #[error(
        "{samples} samples over {duration:.2} s are too few: \
         the alignment needs {needed:.1} s at the start"
    )]
    TooShort {
        /// Number of samples.
        samples: u64,
        /// Time from the first to the last, s.
        duration: f64,
        /// Duration that the alignment needs, s.
        needed: f64,
    },
    /// No stance was detected, but smoothing or correction needs one.
    #[error(
        "the foot was never found at rest in {samples} samples, but smoother and \
         correction need stances; choose another detector or threshold, or leave smoother and correction out"
    )]
    NoStance {
        /// Number of samples.
        samples: u64,
    },
    /// The temperature is outside the range of the calibration.
    #[error(
        "sample {index}: the temperature is {temperature:.1} degC, but the calibration \
         holds from {lowest:.1} to {highest:.1} degC (that is {margin:.1} K beyond what it was measured at); \
         calibrate over a wider span"
    )]
    TemperatureOutsideSpan {
        /// Number of the sample.
        index: usize,
        /// Temperature of the sample, degrees Celsius.
        temperature: f64,
        /// Lowest valid temperature, degrees Celsius.
        lowest: f64,
        /// Highest valid temperature, degrees Celsius.
        highest: f64,
        /// Extrapolation beyond the calibration temperatures included in both, K.
        margin: f64,
    },
    /// The calibration depends on the temperature, which is unknown.
    #[error(
        "the calibration follows the temperature, but the recording has none; \
         give the temperature of the sensor in degrees Celsius"
    )]
    NoTemperature,
    /// A reading of the magnetometer is NaN or infinite.
    #[error(
        "at {time} s the magnetic field is {field:?}; expected three finite numbers: \
         leave out a missing reading (in an array: three NaN)"
    )]
    FieldNotFinite {
        /// Stamp of the reading, s.
        time: f64,
        /// The field, sensor axes.
        field: [f64; 3],
    },
    /// Heading updates are enabled without magnetometer readings.
    #[error(
        "magnetometer.heading is set, but there is no reading of a magnetometer: \
         pass its readings with the samples (mag), or leave the setting out"
    )]
    NoField,
    /// A reading of an aid is invalid.
    #[error("the reading at {time} s has {found}; expected {expected}")]
    InvalidReading {
        /// Stamp of the reading, s.
        time: f64,
        /// Invalid values of the reading.
        found: String,
        /// Expected values.
        expected: &'static str,
    },
    /// The magnetic field has no horizontal component.
    #[error("the magnetic field {field:?} has no horizontal component, so it gives no heading")]
    VerticalField {
        /// The field, sensor axes.
        field: [f64; 3],
    },
}

/// Numerical failure of the filter.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NumericalError {
    /// A variance became negative or not finite.
    #[error(
        "at {time} s the variance of {state} became {variance}; \
         the preceding samples made the filter diverge"
    )]
    CovarianceNotPositive {
        /// Stamp of the sample, s.
        time: f64,
        /// Name of the error state.
        state: &'static str,
        /// The variance.
        variance: f64,
    },
    /// Position, velocity or attitude became not finite.
    #[error(
        "at {time} s the navigation state became not finite; \
         the preceding samples are too large to integrate"
    )]
    StateNotFinite {
        /// Stamp of the sample, s.
        time: f64,
    },
}
