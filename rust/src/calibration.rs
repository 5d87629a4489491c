//! Calibration of raw readings: M (raw - b) for each sensor, with temperature compensation in
//! [`TriadCalibration`].

use crate::calibration::affine::{Correction, IDENTITY, check_matrix};
use crate::error::ConfigError;
use crate::limits::Limits;
use crate::settings::settings;
use crate::types::sample::ImuSample;

mod affine;
mod thermal;

pub use thermal::{TemperatureModel, TriadCalibration};

settings! {
    /// Correction of raw readings: M (raw - b) for each sensor.
    pub struct Calibration: "calibration", also has_plausible_matrices {
        /// Scale and misalignment M of the accelerometer.
        accel_matrix: [[f64; 3]; 3] = IDENTITY, "", Limits::Finite;
        /// Bias b of the accelerometer.
        accel_bias: [f64; 3] = [0.0; 3], "m/s²", Limits::Finite;
        /// Scale and misalignment M of the gyroscope.
        gyro_matrix: [[f64; 3]; 3] = IDENTITY, "", Limits::Finite;
        /// Bias b of the gyroscope.
        gyro_bias: [f64; 3] = [0.0; 3], "rad/s", Limits::Finite;
    }
}

impl Calibration {
    /// Checks that both matrices are invertible.
    fn has_plausible_matrices(&self) -> Result<(), ConfigError> {
        check_matrix("calibration.accel_matrix", &self.accel_matrix)?;
        check_matrix("calibration.gyro_matrix", &self.gyro_matrix)
    }
}

/// A [`Calibration`] prepared for application to a stream of samples.
#[derive(Clone, Debug)]
pub(crate) struct Calibrator {
    accel: Correction,
    gyro: Correction,
}

impl Calibrator {
    /// None for the identity calibration.
    pub(crate) fn new(calibration: &Calibration) -> Option<Self> {
        (*calibration != Calibration::default()).then(|| Self {
            accel: Correction::new(&calibration.accel_matrix, &calibration.accel_bias),
            gyro: Correction::new(&calibration.gyro_matrix, &calibration.gyro_bias),
        })
    }

    #[inline]
    pub(crate) fn apply(&self, raw: &ImuSample) -> ImuSample {
        ImuSample {
            time: raw.time,
            specific_force: self.accel.apply(&raw.specific_force),
            angular_rate: self.gyro.apply(&raw.angular_rate),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::calibration::affine::matrix;

    #[test]
    fn calibration_inverts_the_sensor_errors() {
        let calibration = Calibration {
            accel_matrix: [[1.02, 0.01, -0.02], [0.0, 0.97, 0.03], [0.01, 0.0, 1.05]],
            accel_bias: [0.3, -0.2, 0.1],
            gyro_matrix: [[0.99, 0.0, 0.02], [0.01, 1.01, 0.0], [0.0, -0.03, 1.0]],
            gyro_bias: [0.02, 0.01, -0.03],
        };
        let (accel, gyro) = (matrix(&calibration.accel_matrix), matrix(&calibration.gyro_matrix));
        let truth = ImuSample::new(1.0, [1.0, -2.0, 9.0], [0.5, 3.0, -1.0]);
        let raw = ImuSample {
            time: 1.0,
            specific_force: accel.try_inverse().unwrap() * truth.specific_force
                + Vector3::from(calibration.accel_bias),
            angular_rate: gyro.try_inverse().unwrap() * truth.angular_rate
                + Vector3::from(calibration.gyro_bias),
        };
        let corrected = Calibrator::new(&calibration).unwrap().apply(&raw);
        assert!(Calibrator::new(&Calibration::default()).is_none());
        assert!((corrected.specific_force - truth.specific_force).norm() < 1e-14);
        assert!((corrected.angular_rate - truth.angular_rate).norm() < 1e-14);
    }

    #[test]
    fn singular_matrix_is_an_error_that_names_the_setting() {
        let calibration = Calibration { gyro_matrix: [[0.0; 3]; 3], ..Calibration::default() };
        let message = calibration.validate().unwrap_err().to_string();
        assert!(message.starts_with("calibration.gyro_matrix ="), "{message}");
    }
}
