//! What later samples tell of the errors at one instant, on its way back from instant to instant.

use nalgebra::{Matrix3, Vector3};

use crate::filter::covariance::Covariance;
use crate::filter::error_state::{Block, ErrorStates, LinearMap};
use crate::filter::observation::Observation;
use crate::filter::transition::Transition;
use crate::types::solution::Solution;

/// The costate λ and the information Λ of all that came later.
#[derive(Debug)]
pub(super) struct BackwardState {
    costate: ErrorStates,
    information: Covariance,
}

impl Default for BackwardState {
    fn default() -> Self {
        Self { costate: ErrorStates::default(), information: Covariance::zero() }
    }
}

impl BackwardState {
    pub(super) fn transition(&mut self, transition: &Transition) {
        transition.apply_transposed(&mut self.costate);
        transition.apply_transposed(&mut self.information);
    }

    pub(super) fn couple(&mut self, m: &Matrix3<f64>) {
        self.costate.add_transformed(Block::AccelBias, Block::Attitude, &m.transpose());
        self.information.add_transformed(Block::AccelBias, Block::Attitude, &m.transpose());
    }

    pub(super) fn observation(&mut self, observation: &Observation) {
        observation.costate_before(&mut self.costate);
        observation.information_before(&mut self.information);
    }

    pub(super) fn reset_block(&mut self, block: Block) {
        *self.costate.block_mut(block) = Vector3::zeros();
        self.information.replace(block, 0.0);
    }

    /// Corrects a solution, whose errors have this covariance, by what later samples tell of it.
    pub(super) fn smooth(&self, solution: &mut Solution, covariance: &Covariance) {
        let (errors, known) = covariance.smoothing(&self.costate, &self.information);
        solution.estimate.correct(&ErrorStates(errors.0.map(|part| -part)));
        let variance = covariance.diagonal(Block::Position) - known;
        solution.position_std = variance.map(|v| v.max(0.0).sqrt());
    }
}
