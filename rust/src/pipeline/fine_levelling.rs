//! Fine levelling: zero-velocity updates over a few seconds of rest after the coarse alignment.
//!
//! # References
//! Wu, Lu, Chen, "Research on Foot-Mounted Personal Navigation Algorithm based on MEMS Inertial
//! Sensors": the second stage of the alignment.

use crate::aiding::Aids;
use crate::error::NumericalError;
use crate::ins::alignment::{Alignment, Gathered};
use crate::math::simd::Simd;
use crate::pipeline::aided_ins::AidedIns;
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;

/// A foot at rest, and the navigation that is levelled meanwhile.
pub(crate) struct FineLevelling<S> {
    rest: Alignment,
    ins: AidedIns<S>,
    until: f64,
}

impl<S: Simd> FineLevelling<S> {
    /// Continues the rest of the coarse alignment, up to the time `until` (s).
    pub(crate) fn new(rest: Alignment, ins: AidedIns<S>, until: f64) -> Self {
        Self { rest, ins, until }
    }

    /// Takes the next sample; whether the levelling ends, because the time is over or the foot moves.
    pub(crate) fn push(&mut self, sample: &ImuSample) -> Result<bool, NumericalError> {
        match self.rest.gather(sample) {
            Gathered::Part => Ok(false),
            Gathered::Moving => Ok(true),
            Gathered::Rest => {
                for sample in self.rest.block() {
                    self.ins.update_at_rest(sample)?;
                }
                self.rest.accept_block();
                Ok(sample.time >= self.until)
            }
        }
    }

    pub(crate) fn aids(&self) -> &Aids {
        &self.ins.aids
    }

    pub(crate) fn aids_mut(&mut self) -> &mut Aids {
        &mut self.ins.aids
    }

    /// The state at a sample, at rest at the origin.
    pub(crate) fn state(&self, sample: &ImuSample) -> NavState {
        NavState::at_rest(sample.time, self.ins.filter.estimate.nav.attitude)
    }

    /// The navigation, which starts here, and the samples that it has yet to propagate over.
    pub(crate) fn finish(&self) -> (AidedIns<S>, &[ImuSample]) {
        let mut ins = self.ins.clone();
        ins.filter.reset_position();
        (ins, self.rest.block())
    }
}
