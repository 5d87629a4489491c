//! Observations of one block of error states, in the form that the filter uses and the smoother
//! replays.
//!
//! With the innovation covariance S = H P Hᵀ + R = L Lᵀ, the gain is K = W L⁻¹ where W = P Hᵀ L⁻ᵀ,
//! and the estimated errors are W times the whitened innovation L⁻¹ y.  An axis that is not
//! observed has a zero in place of its column of W, its row of L⁻¹ and its part of y.

use nalgebra::{Matrix3, Vector3};

use crate::filter::error_state::{Block, ErrorStates};
use crate::filter::kernels::forward::{Errors, WhitenedGain};

/// Result of the innovation test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Update {
    /// Squared Mahalanobis distance of the innovation.
    pub(crate) distance: f64,
    /// Whether it passed the innovation test and was used.
    pub(crate) accepted: bool,
}

/// An observation that was used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Observation {
    pub(crate) block: Block,
    pub(crate) whitened_gain: WhitenedGain,
    pub(crate) whitener: Matrix3<f64>,
    pub(crate) white_innovation: Vector3<f64>,
    pub(crate) errors: Errors,
}

/// A whitened measurement.  Its gain follows from the covariance before it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measurement {
    pub(crate) block: Block,
    pub(crate) whitener: Matrix3<f64>,
    pub(crate) white_innovation: Vector3<f64>,
}

impl Observation {
    /// A whitened measurement; its gain and the estimated errors follow from the covariance.
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
    pub(crate) fn errors(&self) -> ErrorStates {
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

    /// Propagates the costate λ of the errors back over the observation: (I - K H)ᵀ λ - Hᵀ S⁻¹ y.
    #[inline]
    pub(crate) fn costate_before(&self, costate: &mut ErrorStates) {
        let mut white = self.white_innovation;
        self.whitened_gain.add_gain_transposed(&costate.0, &mut white);
        *costate.block_mut(self.block) -= self.whitener.transpose() * white;
    }

    /// An observation of the same measurement; its gain follows from the covariance.
    #[inline]
    pub(crate) fn replay(measurement: &Measurement) -> Self {
        let Measurement { block, whitener, white_innovation } = *measurement;
        Self::new(block, whitener, white_innovation)
    }

    /// What is kept to replay the observation.
    #[must_use]
    #[inline]
    pub(crate) fn measurement(&self) -> Measurement {
        Measurement {
            block: self.block,
            whitener: self.whitener,
            white_innovation: self.white_innovation,
        }
    }
}
