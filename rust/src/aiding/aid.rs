//! What every aid of the inertial navigation has in common.

use crate::filter::error_state::Block;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::observation::Update;
use crate::filter::recorder::FilterRecorder;
use crate::ins::interval::Interval;
use crate::math::simd::Simd;
use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;

/// The newest sample and the interval that it ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Epoch<'a> {
    pub(crate) sample: &'a ImuSample,
    pub(crate) interval: &'a Interval,
    /// Whether the foot stands on the ground.
    pub(crate) stance: bool,
    /// Flags of the sample.
    pub(crate) flags: Flags,
}

/// Result of an aid at one epoch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// There was no measurement.
    #[default]
    None,
    /// The filter used the measurement.
    Accepted,
    /// The innovation test, or a test of the aid, rejected it.
    Rejected,
}

impl From<Update> for Outcome {
    fn from(update: Update) -> Self {
        Self::tested(update.accepted)
    }
}

impl Outcome {
    /// Of a measurement that was tested.
    #[inline]
    pub(crate) fn tested(accepted: bool) -> Self {
        if accepted { Self::Accepted } else { Self::Rejected }
    }
}

/// Updates by one aid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UpdateCount {
    /// Measurements that the filter used.
    pub accepted: u64,
    /// Measurements that a test rejected.
    pub rejected: u64,
}

impl UpdateCount {
    #[inline(always)]
    pub(crate) fn add(&mut self, outcome: Outcome) {
        match outcome {
            Outcome::None => {}
            Outcome::Accepted => self.accepted += 1,
            Outcome::Rejected => self.rejected += 1,
        }
    }
}

/// A source of measurements for the filter.
pub(crate) trait Aid {
    /// The block of error states that its measurements observe; none while it makes none.
    fn observes(&self) -> Option<Block>;

    /// Starts at a state, before which the foot was at rest or moved.
    fn begin(&mut self, _nav: &NavState, _at_rest: bool) {}

    /// Follows an interval before the covariance is propagated over it; whether a measurement may be
    /// due at its end although the foot is not in stance.
    #[inline(always)]
    fn prepare(&mut self, _epoch: &Epoch<'_>, _simd: impl Simd) -> bool {
        false
    }

    /// Updates the filter at the end of an interval: in stance, and where a measurement of some aid
    /// may be due.
    fn update<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        epoch: &Epoch<'_>,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome;

    /// Discards its state of a motion that a long gap interrupted.
    fn interrupt(&mut self) {}
}

/// An aid that may be switched off.
impl<A: Aid> Aid for Option<A> {
    fn observes(&self) -> Option<Block> {
        self.as_ref().and_then(A::observes)
    }

    fn begin(&mut self, nav: &NavState, at_rest: bool) {
        if let Some(aid) = self {
            aid.begin(nav, at_rest);
        }
    }

    #[inline(always)]
    fn prepare(&mut self, epoch: &Epoch<'_>, simd: impl Simd) -> bool {
        match self {
            Some(aid) => aid.prepare(epoch, simd),
            None => false,
        }
    }

    #[inline(always)]
    fn update<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        epoch: &Epoch<'_>,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        match self {
            Some(aid) => aid.update(filter, epoch, recorder),
            None => Outcome::None,
        }
    }

    fn interrupt(&mut self) {
        if let Some(aid) = self {
            aid.interrupt();
        }
    }
}
