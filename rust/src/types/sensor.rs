//! Noise, biases and ranges of the inertial measurement unit.

use crate::limits::Limits;
use crate::settings::settings;

settings! {
    /// What is known of the inertial measurement unit.
    pub struct SensorConfig: "sensor" {
        /// White noise density of the gyroscope.
        gyro_noise_density: f64 = 1.0e-4, "rad/s/√Hz", Limits::NonNegative;
        /// White noise density of the accelerometer.
        accel_noise_density: f64 = 4.0e-3, "m/s²/√Hz", Limits::NonNegative;
        /// Random walk of the gyroscope's bias.
        gyro_bias_walk: f64 = 1.0e-5, "rad/s/√s", Limits::NonNegative;
        /// Random walk of the accelerometer's bias.
        accel_bias_walk: f64 = 1.0e-4, "m/s²/√s", Limits::NonNegative;
        /// Standard deviation of the gyroscope's bias before the first rest.
        gyro_bias_std: f64 = 0.02, "rad/s", Limits::Positive;
        /// Standard deviation of the accelerometer's bias.
        accel_bias_std: f64 = 0.15, "m/s²", Limits::Positive;
        /// Standard deviation of the gyroscope's scale factors, and of its misalignments in rad,
        /// which remain after calibration.
        gyro_scale_std: f64 = 0.0, "", Limits::Between(0.0, 0.1);
        /// Standard deviation of the accelerometer's scale factors, and of its misalignments in
        /// rad, which remain after calibration.
        accel_scale_std: f64 = 0.0, "", Limits::Between(0.0, 0.1);
        /// Full scale of the gyroscope; unknown when absent.
        gyro_range: Option<f64> = None, "rad/s", Limits::Positive;
        /// Full scale of the accelerometer; unknown when absent.
        accel_range: Option<f64> = None, "m/s²", Limits::Positive;
    }
}
