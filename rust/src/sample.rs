//! One reading of the inertial measurement unit.

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

impl ImuSample {
    /// A sample from its stamp (s), specific force (m/s²) and angular rate (rad/s).
    #[must_use]
    pub fn new(time: f64, specific_force: [f64; 3], angular_rate: [f64; 3]) -> Self {
        Self { time, specific_force: specific_force.into(), angular_rate: angular_rate.into() }
    }

    /// Checks that every number is finite.
    ///
    /// # Errors
    /// [`DataError::NonFinite`] with the first channel that is not; `index` is the sample's number in the message.
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
