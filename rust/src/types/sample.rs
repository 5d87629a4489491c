//! One reading of the inertial measurement unit, and one of a magnetometer beside it.

use nalgebra::Vector3;

use crate::error::DataError;

/// Names of the channels, in the order of a row of a recording.
const CHANNELS: [&str; 7] = ["time", "accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z"];

/// One reading of an inertial measurement unit, in SI units and the sensor frame b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuSample {
    /// Stamp, s.
    pub time: f64,
    /// Specific force, m/s²; at rest the axis that points up reads +g.
    pub specific_force: Vector3<f64>,
    /// Angular rate, rad/s.
    pub angular_rate: Vector3<f64>,
}

/// One reading of a magnetometer that is mounted with the inertial measurement unit, in the sensor
/// frame b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagSample {
    time: f64,
    field: Vector3<f64>,
}

impl MagSample {
    /// A reading from its stamp (s, of the same clock as the samples) and the field, in any unit.
    ///
    /// # Errors
    /// [`DataError::FieldNotFinite`].
    pub fn new(time: f64, field: [f64; 3]) -> Result<Self, DataError> {
        if time.is_finite() && field.iter().all(|component| component.is_finite()) {
            return Ok(Self { time, field: field.into() });
        }
        Err(DataError::FieldNotFinite { time, field })
    }

    /// Stamp, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Magnetic field, b.
    #[must_use]
    pub fn field(&self) -> Vector3<f64> {
        self.field
    }
}

impl ImuSample {
    /// A sample from its stamp (s), specific force (m/s²) and angular rate (rad/s).
    #[must_use]
    pub fn new(time: f64, specific_force: [f64; 3], angular_rate: [f64; 3]) -> Self {
        Self { time, specific_force: specific_force.into(), angular_rate: angular_rate.into() }
    }

    /// The sample less constant biases (rad/s, m/s²).
    #[must_use]
    #[expect(clippy::inline_always, reason = "small beside a call, once for every sample")]
    #[inline(always)]
    pub fn without_bias(&self, gyro_bias: &Vector3<f64>, accel_bias: &Vector3<f64>) -> Self {
        Self {
            time: self.time,
            specific_force: self.specific_force - accel_bias,
            angular_rate: self.angular_rate - gyro_bias,
        }
    }

    /// Checks that every number is finite.
    ///
    /// # Errors
    /// [`DataError::NonFinite`] with the first channel that is not; `index` is the sample's number
    /// in the message.
    #[inline]
    pub fn check_finite(&self, index: u64) -> Result<(), DataError> {
        let (f, w) = (&self.specific_force, &self.angular_rate);
        let row = [self.time, f.x, f.y, f.z, w.x, w.y, w.z];
        if row.iter().sum::<f64>().is_finite() {
            return Ok(());
        }
        match row.iter().position(|value| !value.is_finite()) {
            None => Ok(()),
            Some(k) => Err(DataError::NonFinite { index, channel: CHANNELS[k], value: row[k] }),
        }
    }
}
