//! The navigation solution: the estimate at one sample, its uncertainty and its quality flags.

use nalgebra::Vector3;

use crate::types::health::Flags;
use crate::types::nav_state::NavState;

/// Navigation state with the sensor biases that belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Position, velocity and attitude.
    pub nav: NavState,
    /// Gyroscope bias, rad/s.
    pub gyro_bias: Vector3<f64>,
    /// Accelerometer bias, m/s².
    pub accel_bias: Vector3<f64>,
}

/// The navigation solution at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Position, velocity, attitude and biases.
    pub estimate: Estimate,
    /// One-sigma position uncertainty in n, m.
    pub position_std: Vector3<f64>,
    /// Whether the foot is in stance.
    pub zero_velocity: bool,
    /// Quality flags.
    pub flags: Flags,
}
