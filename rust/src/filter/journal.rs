//! What the filter did to the errors, step by step, for a smoother that goes over it again and for errors that were cloned on the way.

use nalgebra::{Matrix3, Vector3};

use super::observation::Observation;
use super::states::Block;
use super::transition::{Noise, Transition};

/// Takes down the filter's steps in their order.
pub(crate) trait Journal {
    /// The errors moved on, and `noise` was added to them.
    fn transition(&mut self, transition: &Transition, noise: &Noise);

    /// Independent errors of this `variance` were added to each state of a block.
    fn doubt(&mut self, block: Block, variance: f64);

    /// The attitude errors gained `m` times the accelerometer bias errors.
    fn tie(&mut self, m: &Matrix3<f64>);

    /// An observation was used.
    fn observation(&mut self, observation: &Observation);

    /// What was known of a block was forgotten, and its states have these `variances`: nothing that comes later tells of what they were before.
    fn forget(&mut self, block: Block, variances: &Vector3<f64>);
}

/// Nobody reads it, or somebody may.
impl<J: Journal> Journal for Option<&mut J> {
    #[inline]
    fn transition(&mut self, transition: &Transition, noise: &Noise) {
        if let Some(journal) = self {
            journal.transition(transition, noise);
        }
    }

    #[inline]
    fn doubt(&mut self, block: Block, variance: f64) {
        if let Some(journal) = self {
            journal.doubt(block, variance);
        }
    }

    #[inline]
    fn tie(&mut self, m: &Matrix3<f64>) {
        if let Some(journal) = self {
            journal.tie(m);
        }
    }

    #[inline]
    fn observation(&mut self, observation: &Observation) {
        if let Some(journal) = self {
            journal.observation(observation);
        }
    }

    #[inline]
    fn forget(&mut self, block: Block, variances: &Vector3<f64>) {
        if let Some(journal) = self {
            journal.forget(block, variances);
        }
    }
}

/// Two that read along.
impl<A: Journal, B: Journal> Journal for (A, B) {
    #[inline]
    fn transition(&mut self, transition: &Transition, noise: &Noise) {
        self.0.transition(transition, noise);
        self.1.transition(transition, noise);
    }

    #[inline]
    fn doubt(&mut self, block: Block, variance: f64) {
        self.0.doubt(block, variance);
        self.1.doubt(block, variance);
    }

    #[inline]
    fn tie(&mut self, m: &Matrix3<f64>) {
        self.0.tie(m);
        self.1.tie(m);
    }

    #[inline]
    fn observation(&mut self, observation: &Observation) {
        self.0.observation(observation);
        self.1.observation(observation);
    }

    #[inline]
    fn forget(&mut self, block: Block, variances: &Vector3<f64>) {
        self.0.forget(block, variances);
        self.1.forget(block, variances);
    }
}

/// No journal.
impl Journal for () {
    #[inline]
    fn transition(&mut self, _: &Transition, _: &Noise) {}

    #[inline]
    fn doubt(&mut self, _: Block, _: f64) {}

    #[inline]
    fn tie(&mut self, _: &Matrix3<f64>) {}

    #[inline]
    fn observation(&mut self, _: &Observation) {}

    #[inline]
    fn forget(&mut self, _: Block, _: &Vector3<f64>) {}
}
