//! What can go wrong, one enum per domain.

use std::borrow::Cow;

use thiserror::Error;

/// Any failure of footnav.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting is unknown, out of range, or at odds with another one.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A sample cannot be used.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The filter lost a property that it cannot go on without.
    #[error(transparent)]
    Numerical(#[from] NumericalError),
}

/// A configuration that makes no sense.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// A value lies outside what the setting allows.
    #[error("{key} = {value}: expected {expected}")]
    OutOfRange {
        /// Dotted name of the setting, such as `detector.window`.
        key: &'static str,
        /// The value that was given.
        value: String,
        /// What the setting allows.
        expected: Cow<'static, str>,
    },
    /// Two settings contradict each other, or one needs another that is missing.
    #[error("{0}")]
    Inconsistent(String),
    /// The text is not a configuration.
    #[error("{0}")]
    Syntax(String),
    /// No preset of that name.
    #[error("unknown preset {name:?}: the known ones are {known}")]
    UnknownPreset {
        /// The name that was asked for.
        name: String,
        /// The names that exist.
        known: String,
    },
}

/// A sample, or a run of samples, that cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DataError {
    /// A stamp or a channel is NaN or infinite.
    #[error(
        "sample {index}: {channel} is {value}; leave the sample out, the gap is bridged and reported"
    )]
    NonFinite {
        /// Number of the sample, counted from 0 since the start or the last reset.
        index: u64,
        /// Name of the channel.
        channel: &'static str,
        /// The value found.
        value: f64,
    },
    /// A sample is older than the one before it.
    #[error(
        "sample {index}: time goes back from {previous} s to {time} s; sort the samples or leave this one out; if the clock was set back, reset() begins a new walk"
    )]
    TimeReversed {
        /// Number of the sample.
        index: u64,
        /// Stamp of the sample, s.
        time: f64,
        /// Stamp of the sample before, s.
        previous: f64,
    },
    /// The specific force at the start is not gravity in m/s².
    #[error(
        "the specific force at the start is {magnitude:.3}, not about 9.8 m/s^2; {}",
        if *magnitude < 2.0 { "it looks like g: multiply by 9.80665" } else { "check the accelerometer's range and unit" }
    )]
    NotGravity {
        /// Mean magnitude found.
        magnitude: f64,
    },
    /// The axis whose heading is given points up or down.
    #[error(
        "the heading was given for the sensor's {axis} axis, which stands {elevation_deg:.0} deg from the horizontal; \
         set alignment.forward_axis to an axis that lies flat"
    )]
    SteepForwardAxis {
        /// Name of the axis.
        axis: &'static str,
        /// Its elevation above the horizontal, degrees.
        elevation_deg: f64,
    },
    /// A sample came after the end of the data was declared.
    #[error("the data were ended by flush(); call reset() to begin a new walk")]
    AfterFlush,
    /// The data end before the start is aligned.
    #[error(
        "{samples} samples over {duration:.2} s are too few: the alignment needs {needed:.1} s at the start"
    )]
    TooShort {
        /// Number of samples.
        samples: u64,
        /// Time from the first to the last, s.
        duration: f64,
        /// What the alignment asks for, s.
        needed: f64,
    },
    /// Nothing to smooth or correct by.
    #[error(
        "the foot was never found at rest in {samples} samples, so there is nothing to smooth or correct the steps by; \
         choose another detector or threshold, or leave smoother and correction out"
    )]
    NoStance {
        /// Number of samples.
        samples: u64,
    },
    /// The temperature is not one that the sensor was calibrated at.
    #[error(
        "sample {index}: the temperature is {temperature:.1} degC, but the calibration holds from {lowest:.1} to {highest:.1} degC \
         (that is {margin:.1} K beyond what it was measured at); calibrate over a wider span"
    )]
    TemperatureOutsideSpan {
        /// Number of the sample.
        index: usize,
        /// The temperature found, degrees Celsius.
        temperature: f64,
        /// Lowest temperature that the calibration is applied at, degrees Celsius.
        lowest: f64,
        /// Highest temperature that the calibration is applied at, degrees Celsius.
        highest: f64,
        /// How far both lie beyond the calibrated span, K.
        margin: f64,
    },
    /// The calibration follows the temperature, which is not known.
    #[error(
        "the calibration follows the temperature, but the recording has none; give the temperature of the sensor in degrees Celsius"
    )]
    NoTemperature,
    /// A reading of the magnetometer is NaN or infinite.
    #[error(
        "at {time} s the magnetic field is {field:?}; expected three finite numbers: leave out what the magnetometer did not read (in an array: three NaN)"
    )]
    FieldNotFinite {
        /// Stamp of the reading, s.
        time: f64,
        /// The field, sensor axes.
        field: [f64; 3],
    },
    /// The magnetometer is to hold the heading, and has read nothing.
    #[error(
        "magnetometer.heading is set, but there is no reading of a magnetometer: hand its readings over with the samples (mag), or leave the setting out"
    )]
    NoField,
    /// The reading of the magnetometer carries no heading.
    #[error("the magnetic field {field:?} has no horizontal part, so it gives no heading")]
    VerticalField {
        /// The field, sensor axes.
        field: [f64; 3],
    },
}

/// The filter cannot go on.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NumericalError {
    /// A variance became negative or not finite.
    #[error(
        "at {time} s the variance of {state} became {variance}; the samples before it drove the filter out of its range"
    )]
    CovarianceNotPositive {
        /// Stamp of the sample, s.
        time: f64,
        /// Name of the error state.
        state: &'static str,
        /// The variance found.
        variance: f64,
    },
    /// Position, velocity or attitude became not finite.
    #[error(
        "at {time} s the navigation state became not finite; the samples before it are too large to integrate"
    )]
    StateNotFinite {
        /// Stamp of the sample, s.
        time: f64,
    },
}
