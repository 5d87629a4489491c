//! Sensor error model: bias, noise, scale factor, misalignment, range and resolution.
//!
//! # References
//! - `InvenSense`, "MPU-6000 and MPU-6050 Product Specification", PS-MPU-6000A-00, rev. 3.4, 2013:
//!   sections 6.1 and 6.2.
//! - Xsens, "`MTi` 10-series and `MTi` 100-series User Manual", MT0605P: sensor specifications.
//! - Sensonor, "STIM300 Inertia Measurement Unit" datasheet, TS1524, rev. 9: functional
//!   specifications.

use nalgebra::{Matrix3, Vector3};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::error::ConfigError;
use crate::limits;
use crate::simulation::draw;
use crate::simulation::draw::Stream;
use crate::simulation::flicker::Flicker;
use crate::types::sample::ImuSample;

/// Standard gravity, the unit g of data sheets, m/s².
const G: f64 = 9.806_65;
/// One degree, rad.
const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// One degree per hour, rad/s.
const DEGREE_PER_HOUR: f64 = DEGREE / 3600.0;
/// Square root of an hour, sqrt(s).
const ROOT_HOUR: f64 = 60.0;
/// Square roots of the times in which the bias random walk reaches the bias instability, sqrt(s).
const ROOT_TEN_MINUTES: f64 = 24.494_897_427_831_78;
const ROOT_HUNDRED_SECONDS: f64 = 10.0;
const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Errors of a sensor triad; the unit u is m/s² or rad/s.
///
/// A reading is `matrix * drawn matrix * truth + bias + noise`, clipped to the range and rounded to
/// the resolution.  The default has no errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TriadErrors {
    /// Bias at the start, b frame, u.
    pub bias: Vector3<f64>,
    /// Standard deviation of the bias that is drawn for each axis and added to `bias`, u.
    pub bias_std: f64,
    /// Random walk of the bias, u/sqrt(s).
    pub bias_walk: f64,
    /// Bias instability B, u: flicker noise with an Allan deviation of 0.664 B.
    pub bias_instability: f64,
    /// White noise, u/sqrt(Hz): the mean over an interval of dt (s) has the standard deviation
    /// `noise_density / sqrt(dt)`.
    pub noise_density: f64,
    /// Scale factors and misalignment, row by row.
    pub matrix: [[f64; 3]; 3],
    /// Standard deviation of the relative scale error that is drawn for each axis.
    pub scale_std: f64,
    /// Standard deviation of the misalignment that is drawn for each pair of axes, rad.
    pub misalignment_std: f64,
    /// Full scale in both directions, u; none for a sensor that does not clip.
    pub range: Option<f64>,
    /// Size of the least significant bit, u; zero for no rounding.
    pub resolution: f64,
}

impl Default for TriadErrors {
    fn default() -> Self {
        Self {
            bias: Vector3::zeros(),
            bias_std: 0.0,
            bias_walk: 0.0,
            bias_instability: 0.0,
            noise_density: 0.0,
            matrix: IDENTITY,
            scale_std: 0.0,
            misalignment_std: 0.0,
            range: None,
            resolution: 0.0,
        }
    }
}

/// Errors of an inertial measurement unit.  The default has no errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorErrors {
    /// The accelerometers, m/s².
    pub accel: TriadErrors,
    /// The gyroscopes, rad/s.
    pub gyro: TriadErrors,
    /// Standard deviation of the gyroscopes' sensitivity to specific force that is drawn for each
    /// pair of axes, (rad/s)/(m/s²).
    pub gyro_g_sensitivity_std: f64,
}

impl SensorErrors {
    /// Names of the presets.
    pub const PRESETS: [&'static str; 4] = ["ideal", "mpu6050", "mti-g710", "stim300"];

    /// A sensor without errors.
    #[must_use]
    pub fn ideal() -> Self {
        Self::default()
    }

    /// `InvenSense` MPU-6050, an uncalibrated part, at 8 g and 1000 deg/s, 16 bits.
    ///
    /// Noise, sensitivity and cross-axis figures are from the specification, tolerances taken as
    /// three standard deviations.  The specification gives only bounds of the biases (20 deg/s, 50
    /// to 80 mg); the model uses typical values at room temperature, 1 deg/s and 20 mg.  The
    /// specification gives no bias random walk; the values are of the order of published Allan
    /// deviations.
    #[must_use]
    pub fn mpu6050() -> Self {
        Self {
            accel: TriadErrors {
                bias_std: 0.02 * G,
                bias_walk: 1e-4,
                noise_density: 400e-6 * G,
                scale_std: 0.03 / 3.0,
                misalignment_std: 0.02 / 3.0,
                range: Some(8.0 * G),
                resolution: G / 4096.0,
                ..TriadErrors::default()
            },
            gyro: TriadErrors {
                bias_std: DEGREE,
                bias_walk: 1e-5,
                noise_density: 0.005 * DEGREE,
                scale_std: 0.03 / 3.0,
                misalignment_std: 0.02 / 3.0,
                range: Some(1000.0 * DEGREE),
                resolution: DEGREE / 32.8,
                ..TriadErrors::default()
            },
            // 0.1 deg/s/g.
            gyro_g_sensitivity_std: 0.1 * DEGREE / G,
        }
    }

    /// Xsens `MTi-G-710`, factory calibrated, at 200 m/s² and 450 deg/s, with readings as real
    /// numbers.
    ///
    /// Bias repeatability, noise densities, 0.05 deg of misalignment and g-sensitivity are from the
    /// manual of the first series; the random walk reaches the in-run stability (10 deg/h; 40 ug)
    /// in 100 s.  The manual gives no scale error; the value is typical of a factory calibration.
    #[must_use]
    pub fn mti_g710() -> Self {
        Self {
            accel: TriadErrors {
                bias_std: 0.03,
                bias_walk: 40e-6 * G / ROOT_HUNDRED_SECONDS,
                noise_density: 80e-6 * G,
                scale_std: 3e-4,
                misalignment_std: 0.05 * DEGREE,
                range: Some(200.0),
                ..TriadErrors::default()
            },
            gyro: TriadErrors {
                bias_std: 0.2 * DEGREE,
                bias_walk: 10.0 * DEGREE_PER_HOUR / ROOT_HUNDRED_SECONDS,
                noise_density: 0.01 * DEGREE,
                scale_std: 3e-4,
                misalignment_std: 0.05 * DEGREE,
                range: Some(450.0 * DEGREE),
                ..TriadErrors::default()
            },
            // 0.003 deg/s/g.
            gyro_g_sensitivity_std: 0.003 * DEGREE / G,
        }
    }

    /// Sensonor STIM300 with the 10 g accelerometers, at 400 deg/s.
    ///
    /// Angular random walk 0.15 deg/sqrt(h) and bias instability 0.5 deg/h, velocity random walk
    /// 0.06 m/s/sqrt(h) and 0.05 mg, bias 5 deg/h over temperature and 0.75 mg from switch-on to
    /// switch-on, scale 500 and 300 ppm, misalignment 1 mrad, 1 deg/h/g, and the output's least
    /// significant bits are from the data sheet; the random walk reaches the bias instability in 10
    /// minutes.
    #[must_use]
    pub fn stim300() -> Self {
        Self {
            accel: TriadErrors {
                bias_std: 0.75e-3 * G,
                bias_walk: 0.05e-3 * G / ROOT_TEN_MINUTES,
                noise_density: 0.06 / ROOT_HOUR,
                scale_std: 300e-6,
                misalignment_std: 1e-3,
                range: Some(10.0 * G),
                resolution: G / 524_288.0,
                ..TriadErrors::default()
            },
            gyro: TriadErrors {
                bias_std: 5.0 * DEGREE_PER_HOUR,
                bias_walk: 0.5 * DEGREE_PER_HOUR / ROOT_TEN_MINUTES,
                noise_density: 0.15 * DEGREE / ROOT_HOUR,
                scale_std: 500e-6,
                misalignment_std: 1e-3,
                range: Some(400.0 * DEGREE),
                resolution: DEGREE / 16_384.0,
                ..TriadErrors::default()
            },
            gyro_g_sensitivity_std: DEGREE_PER_HOUR / G,
        }
    }

    /// The preset of a name from [`PRESETS`](Self::PRESETS).
    ///
    /// # Errors
    /// [`ConfigError::UnknownPreset`] for any other name.
    pub fn preset(name: &str) -> Result<Self, ConfigError> {
        match name {
            "ideal" => Ok(Self::ideal()),
            "mpu6050" => Ok(Self::mpu6050()),
            "mti-g710" => Ok(Self::mti_g710()),
            "stim300" => Ok(Self::stim300()),
            _ => Err(ConfigError::UnknownPreset {
                name: name.to_owned(),
                known: Self::PRESETS.join(", "),
            }),
        }
    }

    /// Checks every parameter.
    ///
    /// # Errors
    /// [`ConfigError::OutOfRange`] with the first parameter that is negative or not finite.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.accel.validate(&ACCEL_KEYS)?;
        self.gyro.validate(&GYRO_KEYS)?;
        not_negative("sensor.gyro_g_sensitivity_std", self.gyro_g_sensitivity_std)
    }
}

/// Names of a triad's parameters in messages.
struct Keys {
    bias: &'static str,
    bias_std: &'static str,
    bias_walk: &'static str,
    bias_instability: &'static str,
    noise_density: &'static str,
    matrix: &'static str,
    scale_std: &'static str,
    misalignment_std: &'static str,
    range: &'static str,
    resolution: &'static str,
}

const ACCEL_KEYS: Keys = Keys {
    bias: "sensor.accel.bias",
    bias_std: "sensor.accel.bias_std",
    bias_walk: "sensor.accel.bias_walk",
    bias_instability: "sensor.accel.bias_instability",
    noise_density: "sensor.accel.noise_density",
    matrix: "sensor.accel.matrix",
    scale_std: "sensor.accel.scale_std",
    misalignment_std: "sensor.accel.misalignment_std",
    range: "sensor.accel.range",
    resolution: "sensor.accel.resolution",
};

const GYRO_KEYS: Keys = Keys {
    bias: "sensor.gyro.bias",
    bias_std: "sensor.gyro.bias_std",
    bias_walk: "sensor.gyro.bias_walk",
    bias_instability: "sensor.gyro.bias_instability",
    noise_density: "sensor.gyro.noise_density",
    matrix: "sensor.gyro.matrix",
    scale_std: "sensor.gyro.scale_std",
    misalignment_std: "sensor.gyro.misalignment_std",
    range: "sensor.gyro.range",
    resolution: "sensor.gyro.resolution",
};

impl TriadErrors {
    fn validate(&self, keys: &Keys) -> Result<(), ConfigError> {
        limits::finite(keys.bias, self.bias.as_slice())?;
        limits::finite(keys.matrix, self.matrix.as_flattened())?;
        not_negative(keys.bias_std, self.bias_std)?;
        not_negative(keys.bias_walk, self.bias_walk)?;
        not_negative(keys.bias_instability, self.bias_instability)?;
        not_negative(keys.noise_density, self.noise_density)?;
        not_negative(keys.scale_std, self.scale_std)?;
        not_negative(keys.misalignment_std, self.misalignment_std)?;
        not_negative(keys.resolution, self.resolution)?;
        let range = self.range.unwrap_or(f64::MAX);
        limits::within(keys.range, range, f64::MIN_POSITIVE..=f64::MAX, "a positive number")
    }
}

fn not_negative(key: &'static str, value: f64) -> Result<(), ConfigError> {
    limits::within(key, value, 0.0..=f64::MAX, "a finite number, 0 or more")
}

/// A triad with its drawn errors.
struct Triad {
    errors: TriadErrors,
    matrix: Matrix3<f64>,
    bias: Vector3<f64>,
    flicker: Flicker,
}

impl Triad {
    /// Every number is drawn even where its standard deviation is zero, so a change of one
    /// parameter leaves the other draws unchanged.
    fn draw(errors: &TriadErrors, instability: Stream, random: &mut ChaCha8Rng) -> Self {
        let drawn = Matrix3::from_fn(|row, column| {
            let std = if row == column { errors.scale_std } else { errors.misalignment_std };
            std * draw::normal(random)
        });
        let nominal = Matrix3::from_row_slice(errors.matrix.as_flattened());
        let bias = errors.bias + errors.bias_std * draw::normals(random);
        let flicker = Flicker::draw(errors.bias_instability, draw::sibling(random, instability));
        Self { errors: *errors, matrix: nominal * (Matrix3::identity() + drawn), bias, flicker }
    }

    /// The reading over an interval of `dt` (s); propagates the bias to the end of the interval.
    fn read(&mut self, truth: &Vector3<f64>, dt: f64, random: &mut ChaCha8Rng) -> Vector3<f64> {
        let noise = self.errors.noise_density / dt.sqrt() * draw::normals(random);
        let reading = self.matrix * truth + self.total_bias() + noise;
        self.flicker.advance(dt);
        self.bias += self.errors.bias_walk * dt.sqrt() * draw::normals(random);
        reading.map(|value| self.errors.digitize(value))
    }

    fn total_bias(&self) -> Vector3<f64> {
        self.bias + self.flicker.value()
    }
}

impl TriadErrors {
    fn digitize(&self, value: f64) -> f64 {
        let clipped = self.range.map_or(value, |range| value.clamp(-range, range));
        if self.resolution > 0.0 {
            (clipped / self.resolution).round() * self.resolution
        } else {
            clipped
        }
    }
}

/// An inertial measurement unit with its drawn errors.
pub(super) struct Sensor {
    accel: Triad,
    gyro: Triad,
    g_sensitivity: Matrix3<f64>,
    random: ChaCha8Rng,
}

impl Sensor {
    pub(super) fn draw(errors: &SensorErrors, mut random: ChaCha8Rng) -> Self {
        let accel = Triad::draw(&errors.accel, Stream::AccelInstability, &mut random);
        let gyro = Triad::draw(&errors.gyro, Stream::GyroInstability, &mut random);
        let g_sensitivity =
            errors.gyro_g_sensitivity_std * Matrix3::from_fn(|_, _| draw::normal(&mut random));
        Self { accel, gyro, g_sensitivity, random }
    }

    /// Bias of the next reading: gyroscopes (rad/s), accelerometers (m/s²).
    pub(super) fn biases(&self) -> (Vector3<f64>, Vector3<f64>) {
        (self.gyro.total_bias(), self.accel.total_bias())
    }

    /// The reading over an interval of `dt` (s) with the true means `truth`.
    pub(super) fn read(&mut self, truth: &ImuSample, dt: f64) -> ImuSample {
        let g_error = self.g_sensitivity * truth.specific_force;
        ImuSample {
            time: truth.time,
            specific_force: self.accel.read(&truth.specific_force, dt, &mut self.random),
            angular_rate: self.gyro.read(&(truth.angular_rate + g_error), dt, &mut self.random),
        }
    }
}

#[cfg(test)]
mod tests;
