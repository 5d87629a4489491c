//! The start: alignment and fine levelling, until navigation begins.

use nalgebra::Vector3;

use crate::detectors::detector::Decision;
use crate::error::Error;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::initial_covariance::INITIAL_POSITION_STD;
use crate::ins::alignment::Aligned;
use crate::math::simd::Simd;
use crate::pipeline::aided_ins::{AidedIns, UpdateResult};
use crate::pipeline::delay_line::PendingSample;
use crate::pipeline::fine_levelling::FineLevelling;
use crate::pipeline::stages::{Phase, Stages};
use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;
use crate::types::solution::{Estimate, Solution};

/// What a sample of the start leads to.
enum Progress<S> {
    /// The foot is at rest at the origin, in this state.
    AtRest(NavState),
    /// The coarse alignment is done, and fine levelling continues.
    Levelling(FineLevelling<S>, NavState),
    /// Navigation begins, after a start at rest or in motion, and propagates over these samples.
    Navigating { ins: AidedIns<S>, at_rest: bool, samples: Vec<ImuSample> },
}

impl<S: Simd> Stages<S> {
    /// Processes a sample of the start; whether there is a new solution.
    pub(super) fn start_up(
        &mut self,
        pending: &PendingSample,
        decision: &Decision,
    ) -> Result<bool, Error> {
        let (time, flags) = (pending.sample.time, pending.flags | Flags::ALIGNING);
        let zero_velocity = decision.stationary;
        let progress = self.advance_start(&pending.sample)?;
        self.run.health.record(time, pending.flags);
        let solution = match progress {
            Progress::AtRest(nav) => at_rest(nav, zero_velocity, flags),
            Progress::Levelling(levelling, nav) => {
                self.run.phase = Phase::Levelling(levelling);
                at_rest(nav, zero_velocity, flags)
            }
            Progress::Navigating { mut ins, at_rest, samples } => {
                self.begin(&mut ins, at_rest, &samples);
                self.run.health.aligned(time, at_rest);
                let solution = ins.solution(UpdateResult { zero_velocity, flags });
                self.run.phase = Phase::Navigating(ins);
                solution
            }
        };
        Ok(self.run.post_process(self.simd, solution))
    }

    /// Passes a sample to the alignment or the levelling.
    fn advance_start(&mut self, sample: &ImuSample) -> Result<Progress<S>, Error> {
        match &mut self.run.phase {
            Phase::Aligning(alignment, _) => Ok(match alignment.push(sample)? {
                Some(aligned) => self.on_aligned(&aligned, sample),
                None => {
                    Progress::AtRest(NavState::at_rest(sample.time, alignment.attitude_so_far()))
                }
            }),
            Phase::Levelling(levelling) => Ok(if levelling.push(sample)? {
                let (ins, samples) = levelling.finish();
                Progress::Navigating { ins, at_rest: true, samples: samples.to_vec() }
            } else {
                Progress::AtRest(levelling.state(sample))
            }),
            Phase::Navigating(ins) => Ok(Progress::AtRest(ins.filter.estimate.nav)),
        }
    }

    /// Creates the filter from the coarse alignment.
    fn on_aligned(&self, aligned: &Aligned, sample: &ImuSample) -> Progress<S> {
        let Phase::Aligning(alignment, aids) = &self.run.phase else {
            return Progress::AtRest(NavState::at_rest(sample.time, aligned.attitude));
        };
        let (anchor, samples) = alignment.handover(sample);
        let filter =
            ErrorStateFilter::new(self.simd, &self.config, aligned, anchor.time, &self.strapdown);
        let ins = AidedIns::new(filter, self.strapdown, aids.clone(), &anchor);
        let fine = self.config.alignment.fine_duration;
        if fine > 0.0 && aligned.at_rest && samples.is_empty() {
            let levelling = FineLevelling::new(alignment.clone(), ins, anchor.time + fine);
            let nav = levelling.state(sample);
            return Progress::Levelling(levelling, nav);
        }
        Progress::Navigating { ins, at_rest: aligned.at_rest, samples: samples.to_vec() }
    }

    /// Propagates over the samples since the rest; a stride may start where the foot stood.
    fn begin(&mut self, ins: &mut AidedIns<S>, at_rest: bool, samples: &[ImuSample]) {
        let nav = ins.filter.estimate.nav;
        ins.aids.begin(&nav, at_rest);
        let mut recorder = self.run.strides.as_mut().map(|strides| {
            strides.begin(&ins.filter.covariance());
            strides.recorder()
        });
        ins.replay(samples, &mut recorder);
    }
}

/// The solution of a foot at rest at the origin.
fn at_rest(nav: NavState, zero_velocity: bool, flags: Flags) -> Solution {
    let (gyro_bias, accel_bias) = (Vector3::zeros(), Vector3::zeros());
    Solution {
        estimate: Estimate { nav, gyro_bias, accel_bias },
        position_std: Vector3::repeat(INITIAL_POSITION_STD),
        zero_velocity,
        flags,
    }
}
