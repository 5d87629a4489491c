//! The interval that a sample ends, as the mechanization integrates it.

use nalgebra::Vector3;

use crate::ins::strapdown::StrapdownStep;

/// Result of the mechanization over one interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    pub(crate) step: StrapdownStep,
    /// Part of the interval that no sample covers, s.
    pub(crate) gap_duration: f64,
    /// Angular rate without the gyroscope bias, b, rad/s.
    pub(crate) angular_rate: Vector3<f64>,
    /// Change of velocity, n, m/s.
    pub(crate) velocity_change: Vector3<f64>,
}

impl Interval {
    /// Whether the specific force points up, as the ground's reaction does.
    ///
    /// A detector sees magnitudes, and a foot that decelerates with twice gravity while it rises
    /// feels the magnitude of gravity, upside down.
    #[inline]
    pub(crate) fn supported_by_ground(&self) -> bool {
        self.step.velocity_increment_n.z > 0.0 || self.step.dt == 0.0
    }
}
