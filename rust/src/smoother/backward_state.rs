//! The information of later samples on the errors at one instant, propagated backward.

use nalgebra::{Matrix3, Vector3};

use crate::filter::covariance::Covariance;
use crate::filter::error_state::{Block, ErrorStates, LinearMap};
use crate::filter::observation::Observation;
use crate::filter::transition::Transition;
use crate::math::simd::{Simd, WithSimd};
use crate::types::solution::Solution;

/// The costate λ and the information Λ of all later samples.
#[derive(Debug)]
pub(crate) struct BackwardState {
    costate: ErrorStates,
    information: Covariance,
}

impl Default for BackwardState {
    fn default() -> Self {
        Self { costate: ErrorStates::default(), information: Covariance::zero() }
    }
}

impl BackwardState {
    /// Propagates back over a transition.
    pub(crate) fn transition(&mut self, simd: impl Simd, transition: &Transition) {
        transition.apply_transposed(simd, &mut self.costate);
        transition.apply_transposed(simd, &mut self.information);
    }

    /// Propagates back over a coupling of attitude and accelerometer bias by `m`.
    pub(crate) fn couple(&mut self, simd: impl Simd, m: &Matrix3<f64>) {
        let transposed = &m.transpose();
        self.costate.add_transformed(simd, Block::AccelBias, Block::Attitude, transposed);
        simd.vectorize(Couple { information: &mut self.information, transposed });
    }

    /// Propagates back over an observation: λ becomes (I - K H)ᵀ λ - Hᵀ S⁻¹ y, and Λ becomes
    /// (I - K H)ᵀ Λ (I - K H) + Hᵀ S⁻¹ H.
    pub(crate) fn observation(&mut self, simd: impl Simd, observation: &Observation) {
        observation.costate_before(&mut self.costate);
        let Observation { block, whitener, whitened_gain, .. } = observation;
        self.information.information_before(simd, *block, whitener, whitened_gain);
    }

    /// Propagates back over the reset of a block.
    pub(crate) fn reset_block(&mut self, block: Block) {
        *self.costate.block_mut(block) = Vector3::zeros();
        self.information.reset_block(block, &Vector3::zeros());
    }

    /// Corrects a solution, whose errors have this covariance, by the later samples.
    pub(crate) fn smooth(&self, simd: impl Simd, solution: &mut Solution, covariance: &Covariance) {
        let (errors, reduction) = covariance.smoothing(simd, &self.costate, &self.information);
        solution.estimate.correct(simd, &ErrorStates(errors.0.map(|part| -part)));
        let variance = covariance.diagonal(Block::Position) - reduction;
        solution.position_std = variance.map(|v| v.max(0.0).sqrt());
    }
}

/// See [`BackwardState::couple`].
struct Couple<'a> {
    information: &'a mut Covariance,
    transposed: &'a Matrix3<f64>,
}

impl WithSimd for Couple<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { information, transposed } = self;
        information.add_transformed(simd, Block::AccelBias, Block::Attitude, transposed);
    }
}
