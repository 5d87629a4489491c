//! One run of the navigator: its phase, the stages with memory of earlier samples, and the newest
//! output.

use crate::aiding::Aids;
use crate::config::Config;
use crate::detectors::detector::{Decision, Detector};
use crate::error::{Error, NumericalError};
use crate::filter::covariance::Covariance;
use crate::gait::stride_tracker::StrideTracker;
use crate::ins::alignment::Alignment;
use crate::ins::strapdown::Strapdown;
use crate::math::simd::Simd;
use crate::pipeline::aided_ins::{AidedIns, UpdateResult};
use crate::pipeline::considered_scale::ConsideredScale;
use crate::pipeline::delay_line::{DelayLine, PendingSample};
use crate::pipeline::fine_levelling::FineLevelling;
use crate::pipeline::health_monitor::HealthMonitor;
use crate::pipeline::validation::InputValidator;
use crate::smoother::Smoother;
use crate::types::health::Flags;
use crate::types::solution::Solution;

/// What a reset discards.
pub(super) struct Run<S> {
    pub(super) validator: InputValidator,
    pub(super) delay_line: DelayLine,
    pub(super) phase: Phase<S>,
    pub(super) smoother: Option<Smoother>,
    pub(super) strides: Option<StrideTracker>,
    pub(super) scale: Option<ConsideredScale>,
    pub(super) health: HealthMonitor,
    pub(super) latest: Latest,
    /// All flags since the start was aligned.
    pub(super) flags_since_start: Flags,
    pub(super) first_time: Option<f64>,
    pub(super) ended: bool,
    pub(super) failure: Option<Error>,
}

/// Phase of the navigation.
#[expect(
    clippy::large_enum_variant,
    reason = "there is one, and a box would be one more indirection"
)]
pub(super) enum Phase<S> {
    /// The start is being aligned; the aids collect their readings.
    Aligning(Alignment, Aids),
    Levelling(FineLevelling<S>),
    Navigating(AidedIns<S>),
}

impl<S: Simd> Phase<S> {
    fn new(config: &Config, strapdown: &Strapdown) -> Self {
        let aids = Aids::new(&config.filter, &config.magnetometer, strapdown);
        Self::Aligning(Alignment::new(config.alignment.clone(), strapdown), aids)
    }

    pub(super) fn aids(&self) -> &Aids {
        match self {
            Self::Aligning(_, aids) => aids,
            Self::Levelling(levelling) => levelling.aids(),
            Self::Navigating(ins) => &ins.aids,
        }
    }

    pub(super) fn aids_mut(&mut self) -> &mut Aids {
        match self {
            Self::Aligning(_, aids) => aids,
            Self::Levelling(levelling) => levelling.aids_mut(),
            Self::Navigating(ins) => &mut ins.aids,
        }
    }

    /// Covariance of the error states, unless propagation is pending; none during alignment.
    fn covariance_if_current(&self) -> Option<&Covariance> {
        match self {
            Self::Navigating(ins) => ins.filter.covariance_if_current(),
            _ => None,
        }
    }
}

/// The newest output.
pub(super) enum Latest {
    None,
    /// The estimate of the filter.
    OfFilter(UpdateResult),
    /// Another one: of the alignment, or delayed and changed after the filter.
    Stored(Solution),
}

impl<S: Simd> Run<S> {
    pub(super) fn new(config: &Config, strapdown: &Strapdown, detector: &dyn Detector) -> Self {
        Self {
            validator: InputValidator::new(config, strapdown.nominal_interval),
            delay_line: DelayLine::with_capacity(detector.latency()),
            phase: Phase::new(config, strapdown),
            smoother: Smoother::new(&config.smoother, 1.0 / strapdown.nominal_interval),
            strides: strides(config),
            scale: ConsideredScale::new(&config.sensor),
            health: HealthMonitor::new(config.health.clone()),
            latest: Latest::None,
            flags_since_start: Flags::empty(),
            first_time: None,
            ended: false,
            failure: None,
        }
    }

    /// Whether a stage follows the filter.
    pub(super) fn post_processes(&self) -> bool {
        self.smoother.is_some() || self.strides.is_some() || self.scale.is_some()
    }

    /// Navigates over the pending sample, given the detector's decision; whether there is a new
    /// solution of the filter.
    #[inline(always)]
    pub(super) fn update(&mut self, decision: &Decision) -> Option<Result<(), NumericalError>> {
        let Phase::Navigating(ins) = &mut self.phase else { return None };
        let pending = self.delay_line.oldest()?;
        Some(match ins.update(pending, decision, &mut self.health, &mut ()) {
            Ok(result) => {
                self.flags_since_start |= result.flags;
                self.latest = Latest::OfFilter(result);
                Ok(())
            }
            Err(error) => Err(error),
        })
    }

    /// As [`Run::update`], with stages after the filter; whether one of them has a new solution.
    #[inline(always)]
    pub(super) fn update_general(
        &mut self,
        simd: S,
        pending: &PendingSample,
        decision: &Decision,
    ) -> Result<bool, Error> {
        let Phase::Navigating(ins) = &mut self.phase else { return Ok(false) };
        let strides = self.strides.as_mut().map(StrideTracker::recorder);
        let mut recorder = (strides, self.smoother.as_mut().map(Smoother::recorder));
        let result = ins.update(pending, decision, &mut self.health, &mut recorder)?;
        self.flags_since_start |= result.flags;
        let solution = ins.solution(result);
        Ok(self.post_process(simd, solution))
    }

    /// Passes a solution to the stages after the filter; whether there is a new output.
    pub(super) fn post_process(&mut self, simd: S, solution: Solution) -> bool {
        let covariance = self.phase.covariance_if_current();
        if let Some(strides) = &mut self.strides {
            strides.push(&solution, covariance);
        }
        let due = match &mut self.smoother {
            None => Some(solution),
            Some(smoother) => smoother.push(simd, &solution, covariance),
        };
        let Some(solution) = due else { return false };
        self.emit(solution);
        true
    }

    /// Makes a solution the newest output.
    pub(super) fn emit(&mut self, mut solution: Solution) {
        if let Some(scale) = &mut self.scale {
            scale.inflate(&mut solution);
        }
        if let Some(strides) = &mut self.strides {
            strides.on_output(&solution);
        }
        self.latest = Latest::Stored(solution);
    }

    /// After a failure there is no solution.
    #[cold]
    pub(super) fn fail(&mut self, failure: Error) -> Error {
        self.latest = Latest::None;
        self.flags_since_start |= Flags::LOST;
        self.failure = Some(failure.clone());
        failure
    }
}

fn strides(config: &Config) -> Option<StrideTracker> {
    config.output.strides.then(|| StrideTracker::new(config.alignment.forward_axis.vector()))
}
