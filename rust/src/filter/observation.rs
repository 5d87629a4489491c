//! What an observation of one block of error states told, in the form that the filter uses and the
//! smoother uses again.
//!
//! With the innovation covariance S = H P Hᵀ + R = L Lᵀ, the gain is K = W L⁻¹ where W = P Hᵀ L⁻ᵀ,
//! and the estimated errors are W times the whitened innovation L⁻¹ y.  An axis that is not
//! observed has a zero in place of its column of W, its row of L⁻¹ and its part of y.

use nalgebra::{Matrix3, Vector3};

use crate::filter::covariance::Covariance;
use crate::filter::error_state::{Block, ErrorStates};
use crate::filter::kernels::forward::{Errors, WhitenedGain};

/// Outcome of an observation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// Squared Mahalanobis distance of the innovation.
    pub distance: f64,
    /// Whether it passed the innovation test and was used.
    pub accepted: bool,
}

/// An observation that was used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    pub(crate) block: Block,
    pub(crate) whitened_gain: WhitenedGain,
    pub(crate) whitener: Matrix3<f64>,
    pub(crate) white_innovation: Vector3<f64>,
    pub(crate) errors: Errors,
}

/// What was observed, without its gain: that follows from the covariance at the time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measurement {
    pub(crate) block: Block,
    pub(crate) whitener: Matrix3<f64>,
    pub(crate) white_innovation: Vector3<f64>,
}

impl Observation {
    /// What was observed; its gain, and the errors that it tells of, follow from the covariance.
    #[inline]
    pub(crate) fn new(
        block: Block,
        whitener: Matrix3<f64>,
        white_innovation: Vector3<f64>,
    ) -> Self {
        let (whitened_gain, errors) = (WhitenedGain::default(), Errors::default());
        Self { block, whitened_gain, whitener, white_innovation, errors }
    }

    /// The estimated errors K y.
    #[must_use]
    #[inline]
    pub fn errors(&self) -> ErrorStates {
        let [position, velocity, attitude, gyro_bias, accel_bias] = &self.errors;
        let states = |[x, y, z, _]: &[f64; 4]| Vector3::new(*x, *y, *z);
        ErrorStates([
            states(position),
            states(velocity),
            states(attitude),
            states(gyro_bias),
            states(accel_bias),
        ])
    }

    /// Carries the costate of the errors λ from after the observation to before it: (I - K H)ᵀ λ -
    /// Hᵀ S⁻¹ y.
    #[inline]
    pub fn costate_before(&self, costate: &mut ErrorStates) {
        let mut white = self.white_innovation;
        self.whitened_gain.add_seen(&costate.0, &mut white);
        *costate.block_mut(self.block) -= self.whitener.transpose() * white;
    }

    /// Carries the information Λ of what is still to come from after the observation to before it:
    /// (I - K H)ᵀ Λ (I - K H) + Hᵀ S⁻¹ H.
    #[inline]
    pub fn information_before(&self, information: &mut Covariance) {
        information.go_back_over(self.block, &self.whitener, &self.whitened_gain);
    }

    /// What was observed before, its gain still to be found: see [`Covariance::replay`].
    #[inline]
    pub(crate) fn again(observed: &Measurement) -> Self {
        let Measurement { block, whitener, white_innovation } = *observed;
        Self::new(block, whitener, white_innovation)
    }

    /// What it takes to observe the same again.
    #[must_use]
    #[inline]
    pub(crate) fn observed(&self) -> Measurement {
        Measurement {
            block: self.block,
            whitener: self.whitener,
            white_innovation: self.white_innovation,
        }
    }
}
