//! What the filter did to the errors, step by step, for a smoother that goes over it again and for
//! errors that were cloned on the way.

use nalgebra::{Matrix3, Vector3};

use crate::filter::error_state::Block;
use crate::filter::observation::Observation;
use crate::filter::transition::{Noise, Transition};

/// Takes down the filter's steps in their order.
pub(crate) trait FilterRecorder {
    /// The errors moved on, and `noise` was added to them.
    fn transition(&mut self, transition: &Transition, noise: &Noise);

    /// Independent errors of this `variance` were added to each state of a block.
    fn inflate(&mut self, block: Block, variance: f64);

    /// The attitude errors gained `m` times the accelerometer bias errors.
    fn couple(&mut self, m: &Matrix3<f64>);

    /// An observation was used.
    fn observation(&mut self, observation: &Observation);

    /// What was known of a block was forgotten, and its states have these `variances`: nothing that
    /// comes later tells of what they were before.
    fn reset_block(&mut self, block: Block, variances: &Vector3<f64>);
}

/// Nobody reads it, or somebody may.
impl<J: FilterRecorder> FilterRecorder for Option<&mut J> {
    #[inline]
    fn transition(&mut self, transition: &Transition, noise: &Noise) {
        if let Some(recorder) = self {
            recorder.transition(transition, noise);
        }
    }

    #[inline]
    fn inflate(&mut self, block: Block, variance: f64) {
        if let Some(recorder) = self {
            recorder.inflate(block, variance);
        }
    }

    #[inline]
    fn couple(&mut self, m: &Matrix3<f64>) {
        if let Some(recorder) = self {
            recorder.couple(m);
        }
    }

    #[inline]
    fn observation(&mut self, observation: &Observation) {
        if let Some(recorder) = self {
            recorder.observation(observation);
        }
    }

    #[inline]
    fn reset_block(&mut self, block: Block, variances: &Vector3<f64>) {
        if let Some(recorder) = self {
            recorder.reset_block(block, variances);
        }
    }
}

/// Two that read along.
impl<A: FilterRecorder, B: FilterRecorder> FilterRecorder for (A, B) {
    #[inline]
    fn transition(&mut self, transition: &Transition, noise: &Noise) {
        self.0.transition(transition, noise);
        self.1.transition(transition, noise);
    }

    #[inline]
    fn inflate(&mut self, block: Block, variance: f64) {
        self.0.inflate(block, variance);
        self.1.inflate(block, variance);
    }

    #[inline]
    fn couple(&mut self, m: &Matrix3<f64>) {
        self.0.couple(m);
        self.1.couple(m);
    }

    #[inline]
    fn observation(&mut self, observation: &Observation) {
        self.0.observation(observation);
        self.1.observation(observation);
    }

    #[inline]
    fn reset_block(&mut self, block: Block, variances: &Vector3<f64>) {
        self.0.reset_block(block, variances);
        self.1.reset_block(block, variances);
    }
}

/// No recorder.
impl FilterRecorder for () {
    #[inline]
    fn transition(&mut self, _: &Transition, _: &Noise) {}

    #[inline]
    fn inflate(&mut self, _: Block, _: f64) {}

    #[inline]
    fn couple(&mut self, _: &Matrix3<f64>) {}

    #[inline]
    fn observation(&mut self, _: &Observation) {}

    #[inline]
    fn reset_block(&mut self, _: Block, _: &Vector3<f64>) {}
}
