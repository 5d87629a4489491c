//! The start: alignment and fine levelling, until navigation begins.

use nalgebra::{UnitQuaternion, Vector3};

use crate::config::Config;
use crate::detectors::detector::Decision;
use crate::error::Error;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::initial_covariance::INITIAL_POSITION_STD;
use crate::filter::setup::FilterSetup;
use crate::ins::alignment::Aligned;
use crate::math::simd::Simd;
use crate::pipeline::aided_ins::{AidedIns, UpdateResult};
use crate::pipeline::delay_line::PendingSample;
use crate::pipeline::fine_levelling::FineLevelling;
use crate::pipeline::run::Phase;
use crate::pipeline::stages::Stages;
use crate::smoother::settings::SmootherKind;
use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;
use crate::types::solution::{Estimate, Solution};

/// What a sample of the start leads to.
enum Progress {
    /// The foot is at rest at the origin, in this state.
    AtRest(NavState),
    /// The coarse alignment is done.
    Aligned(Aligned),
    /// The fine levelling is done.
    Levelled,
}

impl<S: Simd> Stages<S> {
    /// Processes a sample of the start; whether there is a new solution.
    pub(super) fn start_up(
        &mut self,
        pending: &PendingSample,
        decision: &Decision,
    ) -> Result<bool, Error> {
        let progress = self.advance_start(&pending.sample)?;
        self.run.health.record(pending.sample.time, pending.flags);
        let solution = match progress {
            Progress::AtRest(nav) => at_rest(nav, pending, decision),
            Progress::Aligned(aligned) => self.on_aligned(&aligned, pending, decision),
            Progress::Levelled => self.on_levelled(pending, decision),
        };
        Ok(self.run.post_process(self.simd, solution))
    }

    /// Passes a sample to the alignment or the levelling.
    fn advance_start(&mut self, sample: &ImuSample) -> Result<Progress, Error> {
        Ok(match &mut self.run.phase {
            Phase::Aligning(alignment, _) => match alignment.push(sample)? {
                Some(aligned) => Progress::Aligned(aligned),
                None => {
                    Progress::AtRest(NavState::at_rest(sample.time, alignment.attitude_so_far()))
                }
            },
            Phase::Levelling(levelling) => {
                if levelling.push(sample)? {
                    Progress::Levelled
                } else {
                    Progress::AtRest(levelling.state(sample))
                }
            }
            Phase::Navigating(ins) => Progress::AtRest(ins.filter.estimate.nav),
        })
    }

    /// Creates the filter from the coarse alignment; navigation begins, or fine levelling.
    #[cold]
    fn on_aligned(
        &mut self,
        aligned: &Aligned,
        pending: &PendingSample,
        decision: &Decision,
    ) -> Solution {
        let Phase::Aligning(alignment, aids) = &self.run.phase else {
            return at_rest(
                NavState::at_rest(pending.sample.time, aligned.attitude),
                pending,
                decision,
            );
        };
        let (anchor, samples) = alignment.handover(&pending.sample);
        let Config { sensor, alignment: start, filter, smoother, .. } = &self.config;
        let batches = smoother.kind == SmootherKind::None;
        let strapdown = &self.strapdown;
        let setup = FilterSetup { sensor, alignment: start, filter, strapdown, batches };
        let filter = ErrorStateFilter::new(self.simd, &setup, aligned, anchor.time);
        let ins = AidedIns::new(filter, self.strapdown, aids.clone(), &anchor);
        let fine = self.config.alignment.fine_duration;
        if fine > 0.0 && aligned.at_rest && samples.is_empty() {
            let levelling = FineLevelling::new(alignment.clone(), ins, anchor.time + fine);
            let nav = levelling.state(&pending.sample);
            self.run.phase = Phase::Levelling(levelling);
            return at_rest(nav, pending, decision);
        }
        let samples = samples.to_vec();
        self.begin(ins, &samples, aligned.at_rest, pending, decision)
    }

    /// Navigation begins after fine levelling.
    #[cold]
    fn on_levelled(&mut self, pending: &PendingSample, decision: &Decision) -> Solution {
        let Phase::Levelling(levelling) = &self.run.phase else {
            let nav = NavState::at_rest(pending.sample.time, UnitQuaternion::identity());
            return at_rest(nav, pending, decision);
        };
        let (ins, samples) = levelling.finish();
        let samples = samples.to_vec();
        self.begin(ins, &samples, true, pending, decision)
    }

    /// Navigation begins, after a start at rest or in motion, and propagates over the samples since
    /// the rest; a stride may start where the foot stood.
    fn begin(
        &mut self,
        mut ins: AidedIns<S>,
        samples: &[ImuSample],
        at_rest: bool,
        pending: &PendingSample,
        decision: &Decision,
    ) -> Solution {
        let nav = ins.filter.estimate.nav;
        ins.aids.begin(&nav, at_rest);
        let mut recorder = self.run.strides.as_mut().map(|strides| {
            strides.begin(&ins.filter.covariance());
            strides.recorder()
        });
        ins.replay(samples, &mut recorder);
        self.run.health.aligned(pending.sample.time, at_rest);
        let flags = pending.flags | Flags::ALIGNING;
        let solution = ins.solution(UpdateResult { zero_velocity: decision.stationary, flags });
        self.run.phase = Phase::Navigating(ins);
        solution
    }
}

/// The solution of a foot at rest at the origin.
fn at_rest(nav: NavState, pending: &PendingSample, decision: &Decision) -> Solution {
    let (gyro_bias, accel_bias) = (Vector3::zeros(), Vector3::zeros());
    Solution {
        estimate: Estimate { nav, gyro_bias, accel_bias },
        position_std: Vector3::repeat(INITIAL_POSITION_STD),
        zero_velocity: decision.stationary,
        flags: pending.flags | Flags::ALIGNING,
    }
}
