//! Propagation of the covariance, batched in swing.
//!
//! No measurement uses the covariance while the foot swings.  So the transitions of a few samples
//! are composed, and the covariance is propagated over all of them at once.  The result differs in
//! the second order of their time, see [`Transition::compose`].

use nalgebra::Vector3;

use crate::filter::covariance::Covariance;
use crate::filter::error_state::Block;
use crate::filter::process_noise::Noise;
use crate::filter::recorder::FilterRecorder;
use crate::filter::transition::Transition;
use crate::math::simd::{Simd, WithSimd};

/// The covariance, and the transitions that it has yet to be propagated over.
#[derive(Clone, Debug)]
pub(crate) struct Propagation {
    covariance: Covariance,
    /// Greatest number of transitions in a batch.
    batch_size: usize,
    /// Number of transitions in the batch.
    pending: usize,
    /// Their composition.
    transition: Transition,
    noise: Noise,
}

impl Propagation {
    pub(crate) fn new(covariance: Covariance, batch_size: usize) -> Self {
        let (transition, noise) = (Transition::NONE, Noise::default());
        Self { covariance, batch_size, pending: 0, transition, noise }
    }

    /// Propagates the covariance over one more transition, which may be added to a batch.
    #[inline(always)]
    pub(crate) fn step(
        &mut self,
        simd: impl Simd,
        mut transition: Transition,
        mut noise: Noise,
        may_batch: bool,
        recorder: &mut impl FilterRecorder,
    ) {
        if self.pending > 0 {
            noise = self.noise.compose(&noise, transition.dt());
            transition = self.transition.compose(&transition);
        }
        if may_batch && self.pending + 1 < self.batch_size {
            self.pending += 1;
            (self.transition, self.noise) = (transition, noise);
            return;
        }
        self.pending = 0;
        recorder.transition(simd, &transition, &noise);
        self.covariance.predict(simd, &transition, &noise);
    }

    /// The covariance at the newest sample.
    #[inline(always)]
    pub(crate) fn flushed(
        &mut self,
        simd: impl Simd,
        recorder: &mut impl FilterRecorder,
    ) -> &mut Covariance {
        if self.pending > 0 {
            self.flush(simd, recorder);
        }
        &mut self.covariance
    }

    #[cold]
    fn flush(&mut self, simd: impl Simd, recorder: &mut impl FilterRecorder) {
        self.pending = 0;
        recorder.transition(simd, &self.transition, &self.noise);
        simd.vectorize(Flush { propagation: self });
    }

    /// A copy of the covariance at the newest sample.
    pub(crate) fn current(&self, simd: impl Simd) -> Covariance {
        self.clone().flushed(simd, &mut ()).clone()
    }

    /// The covariance, if no transition is pending.
    pub(crate) fn if_current(&self) -> Option<&Covariance> {
        (self.pending == 0).then_some(&self.covariance)
    }

    /// The covariance before the pending transitions.
    #[inline(always)]
    pub(crate) fn last_propagated(&self) -> &Covariance {
        &self.covariance
    }

    /// Variances of the position, m²; with transitions pending, those at constant velocity.
    #[inline]
    pub(crate) fn position_variances(&self) -> Vector3<f64> {
        let before = self.covariance.diagonal(Block::Position);
        if self.pending == 0 {
            return before;
        }
        let dt = self.transition.dt();
        let together = self.covariance.diagonal_between(Block::Position, Block::Velocity);
        let gain = 2.0 * together + dt * self.covariance.diagonal(Block::Velocity);
        before + dt * gain + Vector3::repeat(self.noise.position)
    }
}

/// See [`Propagation::flush`].
struct Flush<'a> {
    propagation: &'a mut Propagation,
}

impl WithSimd for Flush<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Propagation { covariance, transition, noise, .. } = self.propagation;
        covariance.predict(simd, transition, noise);
    }
}

#[cfg(test)]
mod tests;
