//! Process noise Q: what the sensor's noise, the motion of the foot and missing samples add to the
//! errors.

use crate::filter::settings::FilterConfig;
use crate::types::sensor::SensorConfig;

/// Second derivative of a walking foot's angular rate, rad/s³: about 5 rad/s at twice a second.
const RATE_CURVATURE: f64 = 1_000.0;
/// Second derivative of its specific force, m/s⁴: about 15 m/s² at three times a second.
const FORCE_CURVATURE: f64 = 5_000.0;
/// Greatest mean error of the angular rate interpolated over a gap, rad/s.
const RATE_ERROR_LIMIT: f64 = 4.0;
/// Greatest mean error of the specific force interpolated over a gap, m/s².
const FORCE_ERROR_LIMIT: f64 = 10.0;

/// Variances that a transition adds to the errors, the same on each axis; they are independent of
/// all errors before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Noise {
    /// Of the position, m².
    pub(crate) position: f64,
    /// Of the velocity, m²/s².
    pub(crate) velocity: f64,
    /// Of the attitude, rad².
    pub(crate) attitude: f64,
    /// Of the gyroscope bias, rad²/s².
    pub(crate) gyro_bias: f64,
    /// Of the accelerometer bias, m²/s⁴.
    pub(crate) accel_bias: f64,
    /// Covariance of position and velocity, m²/s.
    pub(crate) position_velocity: f64,
}

impl Noise {
    /// The noise of this transition and of `next`, which takes `dt` (s), together: the velocity noise
    /// of the first is integrated to position in the second.
    #[must_use]
    #[inline(always)]
    pub(crate) fn compose(&self, next: &Self, dt: f64) -> Self {
        let integrated = dt * (2.0 * self.position_velocity + dt * self.velocity);
        Self {
            position: self.position + integrated + next.position,
            velocity: self.velocity + next.velocity,
            attitude: self.attitude + next.attitude,
            gyro_bias: self.gyro_bias + next.gyro_bias,
            accel_bias: self.accel_bias + next.accel_bias,
            position_velocity: self.position_velocity + dt * self.velocity + next.position_velocity,
        }
    }
}

/// Power spectral densities of the process noise, as variances per second.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProcessNoise {
    velocity: f64,
    attitude: f64,
    gyro_bias: f64,
    accel_bias: f64,
    /// Factor of the first two in an interval in which a channel saturates.
    clipped_factor: f64,
    gravity: f64,
}

impl ProcessNoise {
    /// The noise that the settings describe, with gravity in m/s².
    pub(crate) fn new(sensor: &SensorConfig, filter: &FilterConfig, gravity: f64) -> Self {
        Self {
            velocity: sensor.accel_noise_density.powi(2) + filter.specific_force_noise.powi(2),
            attitude: sensor.gyro_noise_density.powi(2) + filter.angular_rate_noise.powi(2),
            gyro_bias: sensor.gyro_bias_walk.powi(2),
            accel_bias: sensor.accel_bias_walk.powi(2),
            clipped_factor: filter.clipped_noise_factor.powi(2),
            gravity,
        }
    }

    /// The noise of an interval of `dt` (s) in which a channel is `clipped` or not, with an
    /// additional variance of the `position` (m²).
    #[inline(always)]
    pub(crate) fn over(&self, dt: f64, clipped: bool, position: f64) -> Noise {
        let motion = if clipped { self.clipped_factor * dt } else { dt };
        Noise {
            position,
            velocity: self.velocity * motion,
            attitude: self.attitude * motion,
            gyro_bias: self.gyro_bias * dt,
            accel_bias: self.accel_bias * dt,
            position_velocity: 0.0,
        }
    }

    /// Variances of the error that linear interpolation over a `gap` (s) leaves: a twelfth of the
    /// curvature times the cube of the gap, up to what a foot can do in that time.
    pub(crate) fn over_gap(&self, gap: f64) -> GapNoise {
        let error = |curvature: f64, limit: f64| (curvature * gap.powi(3) / 12.0).min(limit * gap);
        let angle = error(RATE_CURVATURE, RATE_ERROR_LIMIT);
        let velocity = error(FORCE_CURVATURE, FORCE_ERROR_LIMIT) + 0.5 * self.gravity * angle * gap;
        GapNoise {
            position: (0.5 * gap * velocity).powi(2),
            velocity: velocity.powi(2),
            attitude: angle.powi(2),
        }
    }
}

/// Variances that the interpolation over missing samples adds, the same on each axis.
pub(crate) struct GapNoise {
    /// Of the position, m².
    pub(crate) position: f64,
    /// Of the velocity, m²/s².
    pub(crate) velocity: f64,
    /// Of the attitude, rad².
    pub(crate) attitude: f64,
}
