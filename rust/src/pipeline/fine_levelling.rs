//! Fine levelling: the filter is told that the foot rests, over a few seconds after the coarse
//! alignment.
//!
//! # References
//! Wu, Lu, Chen, "Research on Foot-Mounted Personal Navigation Algorithm based on MEMS Inertial
//! Sensors": the alignment's second stage.

use crate::error::NumericalError;
use crate::ins::alignment::{Alignment, Gathered};
use crate::math::simd::Lanes;
use crate::pipeline::aided_ins::{Setting, Walk};
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;

/// A foot that still rests, and the filter that is levelled on it.
pub(crate) struct Levelling {
    rest: Alignment,
    walk: Walk,
    until: f64,
}

impl Levelling {
    /// Goes on with the rest that the coarse alignment ended with, up to the time `until` (s).
    pub(crate) fn new(rest: Alignment, walk: Walk, until: f64) -> Self {
        Self { rest, walk, until }
    }

    /// Takes the next sample; answers whether the walk begins, because the time is over or the foot
    /// moves.
    #[inline(always)]
    pub(crate) fn push<L: Lanes>(
        &mut self,
        setting: &Setting<'_>,
        sample: &ImuSample,
    ) -> Result<bool, NumericalError> {
        match self.rest.gather(sample) {
            Gathered::Part => Ok(false),
            Gathered::Moving => Ok(true),
            Gathered::Rest => {
                for sample in self.rest.block() {
                    self.walk.settle::<L>(setting, sample)?;
                }
                self.rest.accept_block();
                Ok(sample.time >= self.until)
            }
        }
    }

    /// The state at a sample, at rest where the walk begins.
    pub(crate) fn state(&self, sample: &ImuSample) -> NavState {
        NavState::at_rest(sample.time, self.walk.filter.estimate.nav.attitude)
    }

    /// The walk that begins here, and the samples of it that came already.
    pub(crate) fn begin(&self) -> (Walk, &[ImuSample]) {
        let mut walk = self.walk.clone();
        walk.filter.reset_position();
        (walk, self.rest.block())
    }
}
