//! The interval that a sample ends, as the strapdown alone saw it.

use nalgebra::Vector3;

use crate::ins::strapdown::Step;

/// What the strapdown made of an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    pub(crate) step: Step,
    /// Part of it that no sample speaks for, s.
    pub(crate) bridged: f64,
    /// Angular rate without the gyroscope's bias, b, rad/s.
    pub(crate) angular_rate: Vector3<f64>,
    /// Change of velocity, n, m/s.
    pub(crate) velocity_gain: Vector3<f64>,
}
