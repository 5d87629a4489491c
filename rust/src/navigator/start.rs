//! The start of a walk: the samples from which it is aligned, until it begins.

use nalgebra::Vector3;

use crate::detector::Decision;
use crate::error::Error;
use crate::filter::{ErrorStateFilter, Estimate, STANDING_STD};
use crate::health::Reasons;
use crate::lanes::Lanes;
use crate::navigator::levelling::Levelling;
use crate::navigator::solution::Solution;
use crate::navigator::waiting::Arrived;
use crate::navigator::walk::{Finding, Setting, Walk};
use crate::navigator::{Navigator, Phase};
use crate::strapdown::NavState;

impl Navigator {
    /// One more sample of the start.
    #[inline(always)]
    pub(super) fn start<L: Lanes>(&mut self, arrived: &Arrived, decision: &Decision) -> Result<Solution, Error> {
        let setting = Setting { strapdown: &self.strapdown, filter: &self.config.filter };
        match &mut self.phase {
            Phase::Walking(walk) => {
                Ok(walk.solution(Finding { zero_velocity: decision.stationary, reasons: arrived.events }))
            }
            Phase::Levelling(levelling) => {
                if levelling.push::<L>(&setting, &arrived.sample)? {
                    let (walk, moving) = levelling.begin();
                    self.compass.iter_mut().for_each(|compass| compass.begin(&walk.filter.estimate.nav, true));
                    let walk = walk.through::<L>(&self.strapdown, moving, self.strides.as_mut());
                    return Ok(self.begin(walk, arrived, decision, true));
                }
                let nav = levelling.state(&arrived.sample);
                Ok(self.stay(nav, arrived, decision))
            }
            Phase::Aligning(alignment) => {
                let Some(aligned) = alignment.push(&arrived.sample)? else {
                    let nav = NavState::at_rest(arrived.sample.time, alignment.attitude_so_far());
                    return Ok(self.stay(nav, arrived, decision));
                };
                let (anchor, moving) = alignment.handover(&arrived.sample);
                let filter = ErrorStateFilter::new(&self.config, &aligned, anchor.time, &self.strapdown);
                let walk = Walk::new(filter, &anchor);
                let fine = self.config.alignment.fine_duration;
                if fine > 0.0 && aligned.at_rest && moving.is_empty() {
                    let levelling = Levelling::new(alignment.clone(), walk, anchor.time + fine);
                    let nav = levelling.state(&arrived.sample);
                    self.phase = Phase::Levelling(levelling);
                    return Ok(self.stay(nav, arrived, decision));
                }
                let nav = &walk.filter.estimate.nav;
                self.compass.iter_mut().for_each(|compass| compass.begin(nav, aligned.at_rest));
                let walk = walk.through::<L>(&self.strapdown, moving, self.strides.as_mut());
                Ok(self.begin(walk, arrived, decision, aligned.at_rest))
            }
        }
    }

    /// While the start is being aligned the foot stays at the origin.
    fn stay(&mut self, nav: NavState, arrived: &Arrived, decision: &Decision) -> Solution {
        self.monitor.note(arrived.sample.time, arrived.events);
        Solution::at_start(nav, decision, arrived.events | Reasons::ALIGNING)
    }

    /// The walk begins with the newest sample.
    fn begin(&mut self, walk: Walk, arrived: &Arrived, decision: &Decision, at_rest: bool) -> Solution {
        self.monitor.note(arrived.sample.time, arrived.events);
        self.monitor.aligned(arrived.sample.time, at_rest);
        let reasons = arrived.events | Reasons::ALIGNING;
        let solution = walk.solution(Finding { zero_velocity: decision.stationary, reasons });
        self.phase = Phase::Walking(walk);
        solution
    }
}

impl Solution {
    fn at_start(nav: NavState, decision: &Decision, reasons: Reasons) -> Self {
        let (gyro_bias, accel_bias) = (Vector3::zeros(), Vector3::zeros());
        Self {
            estimate: Estimate { nav, gyro_bias, accel_bias },
            position_std: Vector3::repeat(STANDING_STD),
            zero_velocity: decision.stationary,
            reasons,
        }
    }
}
