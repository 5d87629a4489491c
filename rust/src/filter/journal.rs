//! What the filter did to the errors, step by step, for a smoother that goes back over it and for errors that were cloned on the way.

use nalgebra::Matrix3;

use super::observation::Observation;
use super::states::Block;
use super::transition::Transition;

/// Takes down the filter's steps in their order.  What is merely added to the covariance is not among them: it is independent of all that was before.
pub(crate) trait Journal {
    /// The errors moved on.
    fn transition(&mut self, transition: &Transition);

    /// The attitude errors gained `m` times the accelerometer bias errors.
    fn tie(&mut self, m: &Matrix3<f64>);

    /// An observation was used.
    fn observation(&mut self, observation: &Observation);

    /// What was known of a block was forgotten: nothing that comes later tells of what it was before.
    fn forget(&mut self, block: Block);
}

/// Nobody reads it, or somebody may.
impl<J: Journal> Journal for Option<&mut J> {
    #[inline]
    fn transition(&mut self, transition: &Transition) {
        if let Some(journal) = self {
            journal.transition(transition);
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
    fn forget(&mut self, block: Block) {
        if let Some(journal) = self {
            journal.forget(block);
        }
    }
}

/// Two that read along.
impl<A: Journal, B: Journal> Journal for (A, B) {
    #[inline]
    fn transition(&mut self, transition: &Transition) {
        self.0.transition(transition);
        self.1.transition(transition);
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
    fn forget(&mut self, block: Block) {
        self.0.forget(block);
        self.1.forget(block);
    }
}

/// No journal.
impl Journal for () {
    #[inline]
    fn transition(&mut self, _: &Transition) {}

    #[inline]
    fn tie(&mut self, _: &Matrix3<f64>) {}

    #[inline]
    fn observation(&mut self, _: &Observation) {}

    #[inline]
    fn forget(&mut self, _: Block) {}
}
