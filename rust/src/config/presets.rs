//! Settings of common inertial sensors.
//!
//! # References
//! Data sheets of the manufacturers: `InvenSense` MPU-6000 and MPU-6050, rev. 3.4; Xsens `MTi`
//! 100-series; Sensonor STIM300, rev. 20; Bosch BMX160 (in the x-io NGIMU); VectorNav VN-100.
//! Turn-on biases are standard deviations of uncalibrated parts where the data sheet gives only
//! bounds (MPU-6050: 20 deg/s, 50 to 80 mg).

use crate::error::ConfigError;
use crate::types::sensor::SensorConfig;

/// Names of the available presets.
pub const PRESETS: [&str; 5] = ["mpu6050", "mti-g710", "stim300", "ngimu", "vn100"];

/// Scale factor error of an uncalibrated MPU-6050: the 3 % of the data sheet are three standard
/// deviations.
const MPU6050_SCALE: f64 = 0.01;
const MICRO_G: f64 = 9.806_65e-6;

/// Noise, biases and scale of a known sensor.
///
/// # Errors
/// [`ConfigError::UnknownPreset`], with the available names.
pub(super) fn sensor(name: &str) -> Result<SensorConfig, ConfigError> {
    let sensor = match name {
        "mpu6050" => SensorConfig {
            gyro_scale_std: MPU6050_SCALE,
            accel_scale_std: MPU6050_SCALE,
            ..datasheet(0.005, 400.0, 5.0, 0.4)
        },
        "mti-g710" => datasheet(0.01, 80.0, 0.2, 0.03),
        "stim300" => datasheet(0.0025, 50.0, 0.07, 0.02),
        "ngimu" => datasheet(0.007, 180.0, 1.0, 0.3),
        "vn100" => datasheet(0.0035, 140.0, 0.3, 0.05),
        _ => {
            return Err(ConfigError::UnknownPreset {
                name: name.into(),
                known: PRESETS.join(", "),
            });
        }
    };
    Ok(sensor)
}

/// Sensor settings from a data sheet: gyroscope noise (deg/s/√Hz), accelerometer noise (µg/√Hz),
/// turn-on bias of the gyroscope (deg/s) and of the accelerometer (m/s²).
fn datasheet(
    gyro_noise_deg: f64,
    accel_noise_micro_g: f64,
    gyro_bias_deg: f64,
    accel_bias: f64,
) -> SensorConfig {
    SensorConfig {
        gyro_noise_density: gyro_noise_deg.to_radians(),
        accel_noise_density: accel_noise_micro_g * MICRO_G,
        gyro_bias_std: gyro_bias_deg.to_radians(),
        accel_bias_std: accel_bias,
        ..SensorConfig::default()
    }
}
