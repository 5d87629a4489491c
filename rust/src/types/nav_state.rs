//! Position, velocity and attitude at one instant.

use nalgebra::{UnitQuaternion, Vector3};

/// Position, velocity and attitude at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavState {
    /// Stamp, s.
    pub time: f64,
    /// Position in n, m, from the start of the walk.
    pub position: Vector3<f64>,
    /// Velocity in n, m/s.
    pub velocity: Vector3<f64>,
    /// Rotation from the sensor frame b to n.
    pub attitude: UnitQuaternion<f64>,
}

impl NavState {
    /// At rest at the origin of n.
    #[must_use]
    pub fn at_rest(time: f64, attitude: UnitQuaternion<f64>) -> Self {
        Self { time, position: Vector3::zeros(), velocity: Vector3::zeros(), attitude }
    }

    /// Whether every number is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.sum().is_finite()
    }

    /// Sum of all numbers but the stamp: finite only if each of them is.
    #[inline]
    pub(crate) fn sum(&self) -> f64 {
        self.position.sum() + self.velocity.sum() + self.attitude.coords.sum()
    }
}
