//! What comes out of the navigator.

use nalgebra::Vector3;

use crate::filter::Estimate;
use crate::health::Reasons;
use crate::navigator::walk::Finding;

/// The navigation solution at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Position, velocity, attitude and biases.
    pub estimate: Estimate,
    /// One-sigma position uncertainty in n, m.
    pub position_std: Vector3<f64>,
    /// Whether the detector took the foot to be at rest on the ground.
    pub zero_velocity: bool,
    /// What speaks against this solution.
    pub reasons: Reasons,
}

/// The newest solution that came out.
pub(super) enum Latest {
    None,
    /// The walk's estimate as it is, with what was found beside it.
    OfWalk(Finding),
    /// That of the start, or one that was held back or changed after the filter found it.
    Apart(Solution),
}
