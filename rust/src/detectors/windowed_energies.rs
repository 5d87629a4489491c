//! Energies of specific force and angular rate over a window.
//!
//! # References
//! Wang, Liu, Sun, Cai, Cheng, "Heading Calibration for Foot-Mounted Inertial
//! Pedestrian-Positioning Using Accelerometer Attitude", Electronics 8(12):1405, 2019: eq. 3.

use crate::config::WindowedEnergiesConfig;
use crate::detectors::detector::{Decision, magnitude_excess};
use crate::detectors::window_test::WindowTest;
use crate::types::sample::ImuSample;

/// Stationary where the mean squares of |f| - g and of |ω| are both low.
///
/// The statistic is the max_nan of `T_a` and `T_w` in units of their thresholds, so its threshold
/// is one.
#[derive(Clone, Debug)]
pub(crate) struct WindowedEnergies {
    gravity: f64,
    /// The thresholds times the variances that the energies are weighed with: mean squares.
    accel_limit: f64,
    gyro_limit: f64,
}

impl WindowedEnergies {
    pub(crate) fn new(config: &WindowedEnergiesConfig, gravity: f64) -> Self {
        Self {
            gravity,
            accel_limit: config.accel_threshold * config.accel_std.powi(2),
            gyro_limit: config.gyro_threshold * config.gyro_std.powi(2),
        }
    }
}

impl WindowTest<2> for WindowedEnergies {
    fn row(&self, sample: &ImuSample) -> [f64; 2] {
        [magnitude_excess(sample, self.gravity).powi(2), sample.angular_rate.norm_squared()]
    }

    fn decide(&self, size: f64, &[accel, gyro]: &[f64; 2], _: &[f64; 2]) -> Decision {
        Decision::all_below([accel / (size * self.accel_limit), gyro / (size * self.gyro_limit)])
    }
}
