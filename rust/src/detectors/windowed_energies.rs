//! Energies of specific force and angular rate over a window.
//!
//! # References
//! Wang, Liu, Sun, Cai, Cheng, "Heading Calibration for Foot-Mounted Inertial
//! Pedestrian-Positioning Using Accelerometer Attitude", Electronics 8(12):1405, 2019: eq. 3.

use crate::detectors::detector::{Decision, Detector, DetectorSettings, magnitude_excess};
use crate::detectors::sliding_window::WINDOW_LIMITS;
use crate::detectors::windowed_detector::{WindowTest, WindowedDetector};
use crate::limits::Limits;
use crate::settings::settings;
use crate::types::sample::ImuSample;

settings! {
    /// Energies of specific force and angular rate over a window (Wang et al. 2019, eq. 3).
    ///
    /// The window is the paper's, the rest was chosen on real walks with a VN-100, an MPU6050, an
    /// NGIMU and OpenShoe's IMU.
    pub struct WindowedEnergiesConfig: "detector" {
        /// Length of the window: 15 samples at 100 Hz in the paper.
        window: f64 = 0.15, "s", WINDOW_LIMITS;
        /// Standard deviation that weights the specific force.
        accel_std: f64 = 0.02, "m/s²", Limits::Positive;
        /// Standard deviation that weights the angular rate.
        gyro_std: f64 = 8.7e-3, "rad/s", Limits::Positive;
        /// Energy of the specific force (`T_a`) from which a sample moves.
        accel_threshold: f64 = 3.0e3, "", Limits::Positive;
        /// Energy of the angular rate (`T_w`) from which a sample moves.
        gyro_threshold: f64 = 6.0e3, "", Limits::Positive;
    }
}

impl DetectorSettings for WindowedEnergiesConfig {
    fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector> {
        let test = WindowedEnergies::new(self, gravity);
        Box::new(WindowedDetector::new(self.window, rate_hz, test))
    }
}

/// Stationary where the mean squares of |f| - g and of |ω| are both low.
///
/// The statistic is the larger of `T_a` and `T_w` in units of their thresholds, with the threshold
/// 1.
#[derive(Clone, Debug)]
pub(crate) struct WindowedEnergies {
    gravity: f64,
    /// Thresholds of the mean squares: threshold times variance.
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
