//! The start of a walk: the samples from which it is aligned, until it begins.

use nalgebra::Vector3;

use crate::detectors::detector::Decision;
use crate::error::Error;
use crate::filter::error_state_filter::{ErrorStateFilter, STANDING_STD};
use crate::math::simd::Lanes;
use crate::pipeline::aided_ins::{Finding, Setting, Walk};
use crate::pipeline::delay_line::PendingSample;
use crate::pipeline::fine_levelling::Levelling;
use crate::pipeline::navigator::{Navigator, Phase};
use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::solution::Estimate;
use crate::types::solution::Solution;

impl Navigator {
    /// One more sample of the start.
    #[inline(always)]
    pub(crate) fn start<L: Lanes>(
        &mut self,
        pending: &PendingSample,
        decision: &Decision,
    ) -> Result<Solution, Error> {
        let setting = Setting { strapdown: &self.strapdown, filter: &self.config.filter };
        match &mut self.phase {
            Phase::Walking(walk) => Ok(walk
                .solution(Finding { zero_velocity: decision.stationary, flags: pending.events })),
            Phase::Levelling(levelling) => {
                if levelling.push::<L>(&setting, &pending.sample)? {
                    let (walk, moving) = levelling.begin();
                    self.compass
                        .iter_mut()
                        .for_each(|compass| compass.begin(&walk.filter.estimate.nav, true));
                    let walk = walk.through::<L>(&self.strapdown, moving, self.strides.as_mut());
                    return Ok(self.begin(walk, pending, decision, true));
                }
                let nav = levelling.state(&pending.sample);
                Ok(self.stay(nav, pending, decision))
            }
            Phase::Aligning(alignment) => {
                let Some(aligned) = alignment.push(&pending.sample)? else {
                    let nav = NavState::at_rest(pending.sample.time, alignment.attitude_so_far());
                    return Ok(self.stay(nav, pending, decision));
                };
                let (anchor, moving) = alignment.handover(&pending.sample);
                let filter =
                    ErrorStateFilter::new(&self.config, &aligned, anchor.time, &self.strapdown);
                let walk = Walk::new(filter, &anchor);
                let fine = self.config.alignment.fine_duration;
                if fine > 0.0 && aligned.at_rest && moving.is_empty() {
                    let levelling = Levelling::new(alignment.clone(), walk, anchor.time + fine);
                    let nav = levelling.state(&pending.sample);
                    self.phase = Phase::Levelling(levelling);
                    return Ok(self.stay(nav, pending, decision));
                }
                let nav = &walk.filter.estimate.nav;
                self.compass.iter_mut().for_each(|compass| compass.begin(nav, aligned.at_rest));
                let walk = walk.through::<L>(&self.strapdown, moving, self.strides.as_mut());
                Ok(self.begin(walk, pending, decision, aligned.at_rest))
            }
        }
    }

    /// While the start is being aligned the foot stays at the origin.
    fn stay(&mut self, nav: NavState, pending: &PendingSample, decision: &Decision) -> Solution {
        self.monitor.record(pending.sample.time, pending.events);
        Solution::at_start(nav, decision, pending.events | Flags::ALIGNING)
    }

    /// The walk begins with the newest sample.
    fn begin(
        &mut self,
        walk: Walk,
        pending: &PendingSample,
        decision: &Decision,
        at_rest: bool,
    ) -> Solution {
        self.monitor.record(pending.sample.time, pending.events);
        self.monitor.aligned(pending.sample.time, at_rest);
        let flags = pending.events | Flags::ALIGNING;
        let solution = walk.solution(Finding { zero_velocity: decision.stationary, flags });
        self.phase = Phase::Walking(walk);
        solution
    }
}

impl Solution {
    fn at_start(nav: NavState, decision: &Decision, flags: Flags) -> Self {
        let (gyro_bias, accel_bias) = (Vector3::zeros(), Vector3::zeros());
        Self {
            estimate: Estimate { nav, gyro_bias, accel_bias },
            position_std: Vector3::repeat(STANDING_STD),
            zero_velocity: decision.stationary,
            flags,
        }
    }
}
