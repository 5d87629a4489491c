//! The operations of the filter on its errors, in their order: for a smoother, which goes back over
//! them, and for cloned errors, which follow them.

use nalgebra::{Matrix3, Vector3};

use crate::filter::error_state::Block;
use crate::filter::observation::Observation;
use crate::filter::process_noise::Noise;
use crate::filter::transition::Transition;
use crate::math::simd::Simd;

/// Records what the filter does to the errors.
pub(crate) trait FilterRecorder {
    /// The errors were propagated, and `noise` was added.
    fn transition(&mut self, simd: impl Simd, transition: &Transition, noise: &Noise);

    /// Independent errors of this `variance` were added to each state of a block.
    fn inflate(&mut self, block: Block, variance: f64);

    /// `m` times the accelerometer bias errors were added to the attitude errors.
    fn couple(&mut self, simd: impl Simd, m: &Matrix3<f64>);

    /// An observation was used.
    fn observation(&mut self, simd: impl Simd, observation: &Observation);

    /// The states of a block became independent of all others, with these `variances`: later
    /// observations carry no information on what they were before.
    fn reset_block(&mut self, block: Block, variances: &Vector3<f64>);
}

/// A recorder that may be absent.
impl<R: FilterRecorder> FilterRecorder for Option<&mut R> {
    #[inline]
    fn transition(&mut self, simd: impl Simd, transition: &Transition, noise: &Noise) {
        if let Some(recorder) = self {
            recorder.transition(simd, transition, noise);
        }
    }

    #[inline]
    fn inflate(&mut self, block: Block, variance: f64) {
        if let Some(recorder) = self {
            recorder.inflate(block, variance);
        }
    }

    #[inline]
    fn couple(&mut self, simd: impl Simd, m: &Matrix3<f64>) {
        if let Some(recorder) = self {
            recorder.couple(simd, m);
        }
    }

    #[inline]
    fn observation(&mut self, simd: impl Simd, observation: &Observation) {
        if let Some(recorder) = self {
            recorder.observation(simd, observation);
        }
    }

    #[inline]
    fn reset_block(&mut self, block: Block, variances: &Vector3<f64>) {
        if let Some(recorder) = self {
            recorder.reset_block(block, variances);
        }
    }
}

/// Two recorders.
impl<A: FilterRecorder, B: FilterRecorder> FilterRecorder for (A, B) {
    #[inline]
    fn transition(&mut self, simd: impl Simd, transition: &Transition, noise: &Noise) {
        self.0.transition(simd, transition, noise);
        self.1.transition(simd, transition, noise);
    }

    #[inline]
    fn inflate(&mut self, block: Block, variance: f64) {
        self.0.inflate(block, variance);
        self.1.inflate(block, variance);
    }

    #[inline]
    fn couple(&mut self, simd: impl Simd, m: &Matrix3<f64>) {
        self.0.couple(simd, m);
        self.1.couple(simd, m);
    }

    #[inline]
    fn observation(&mut self, simd: impl Simd, observation: &Observation) {
        self.0.observation(simd, observation);
        self.1.observation(simd, observation);
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
    fn transition(&mut self, _: impl Simd, _: &Transition, _: &Noise) {}

    #[inline]
    fn inflate(&mut self, _: Block, _: f64) {}

    #[inline]
    fn couple(&mut self, _: impl Simd, _: &Matrix3<f64>) {}

    #[inline]
    fn observation(&mut self, _: impl Simd, _: &Observation) {}

    #[inline]
    fn reset_block(&mut self, _: Block, _: &Vector3<f64>) {}
}
