//! The stages of the navigator, and the path of a sample through them, compiled for an instruction
//! set.

use nalgebra::Vector3;

use crate::aiding::Reading;
use crate::calibration::Calibrator;
use crate::config::Config;
use crate::detectors::detector::{Decision, Detector};
use crate::error::{DataError, Error, NumericalError};
use crate::filter::covariance::Covariance;
use crate::gait::stride::Stride;
use crate::gait::stride_tracker::StrideTracker;
use crate::ins::strapdown::Strapdown;
use crate::math::simd::{Simd, WithSimd};
use crate::pipeline::aided_ins::AidedIns;
use crate::pipeline::health_monitor::{Counters, Health};
use crate::pipeline::run::{Latest, Phase, Run};
use crate::smoother::Smoother;
use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;
use crate::types::solution::Solution;

/// All stages of one foot.
pub(crate) struct Stages<S> {
    pub(super) config: Config,
    pub(super) strapdown: Strapdown,
    pub(super) simd: S,
    /// None without a calibration.
    calibrator: Option<Calibrator>,
    detector: Box<dyn Detector>,
    pub(super) run: Run<S>,
}

/// Velocity during the alignment, n, m/s.
const AT_REST: Vector3<f64> = Vector3::new(0.0, 0.0, 0.0);

impl<S: Simd> Stages<S> {
    pub(super) fn new(
        simd: S,
        config: Config,
        strapdown: Strapdown,
        detector: Box<dyn Detector>,
    ) -> Self {
        let calibrator = Calibrator::new(&config.calibration);
        let run = Run::new(&config, &strapdown, &*detector);
        Self { config, strapdown, simd, calibrator, detector, run }
    }

    /// The path of a sample that passed the validation: it is calibrated, waits for the decision of
    /// the detector, and is navigated over.  Whether there is a new solution.
    #[inline(always)]
    fn process(&mut self, raw: &ImuSample, flags: Flags) -> Result<bool, Error> {
        self.run.first_time.get_or_insert(raw.time);
        let calibrated = self.calibrator.as_ref().map(|calibrator| calibrator.apply(raw));
        let sample = calibrated.as_ref().unwrap_or(raw);
        self.run.delay_line.push(sample, flags);
        match self.detector.push(sample) {
            Some(decision) => self.navigate(&decision),
            None => Ok(false),
        }
    }

    /// Navigates over the sample that has waited for longest, given its decision.
    #[inline(always)]
    fn navigate(&mut self, decision: &Decision) -> Result<bool, Error> {
        if !self.run.post_processes()
            && let Some(updated) = self.run.update(decision)
        {
            self.run.delay_line.release();
            return match updated {
                Ok(()) => Ok(true),
                Err(failure) => Err(self.run.fail(failure.into())),
            };
        }
        self.simd.vectorize(NavigateGeneral { decision: *decision, stages: self })
    }

    /// Validates and processes a raw sample.
    #[inline(always)]
    fn push(&mut self, raw: &ImuSample) -> Result<bool, Error> {
        self.check_running()?;
        let flags = self.run.validator.ingest(raw)?;
        self.process(raw, flags)
    }

    /// As [`Stages::push`], on the instruction set.
    #[inline]
    pub(super) fn push_sample(&mut self, raw: &ImuSample) -> Result<bool, Error> {
        self.simd.vectorize(PushSample { stages: self, raw })
    }

    /// Processes a block of validated samples; `output` takes each new solution, with the
    /// free-inertial velocity (n, m/s).
    pub(super) fn push_block(
        &mut self,
        block: &[ImuSample],
        output: impl FnMut(&Solution, &Vector3<f64>),
    ) -> Result<(), Error> {
        self.simd.vectorize(PushBlock { stages: self, block, output })
    }

    /// At the end of the data, processes up to `rows` of the samples and solutions that wait; whether
    /// all are done.
    pub(super) fn drain(
        &mut self,
        rows: usize,
        mut output: impl FnMut(&Solution, &Vector3<f64>),
    ) -> Result<bool, Error> {
        while let Some(decision) = self.detector.drain() {
            if self.simd.vectorize(Navigate { stages: self, decision: &decision })? {
                self.write(&mut output);
            }
        }
        if let Some(strides) = &mut self.run.strides {
            strides.finish();
        }
        let Some(smoother) = &mut self.run.smoother else { return Ok(true) };
        if !smoother.smooth_chunk(self.simd, rows) {
            return Ok(false);
        }
        for _ in 0..rows {
            let Some(solution) = self.run.smoother.as_mut().and_then(Smoother::pop) else {
                return Ok(true);
            };
            self.run.emit(solution);
            self.write(&mut output);
        }
        Ok(false)
    }

    /// Hands the newest solution to `output`.
    #[inline]
    fn write(&self, output: &mut impl FnMut(&Solution, &Vector3<f64>)) {
        self.with_latest(|solution| output(solution, self.free_inertial_velocity()));
    }

    /// Ends the data: later samples are refused.
    pub(super) fn end(&mut self) {
        self.run.ended = true;
    }

    pub(super) fn push_reading(&mut self, reading: &Reading) {
        self.run.phase.aids_mut().push(reading);
    }

    /// Checks a block of raw samples before any of it is used.
    pub(super) fn check_block(&self, block: &[ImuSample]) -> Result<(), Error> {
        self.check_running()?;
        Ok(self.run.validator.check_block(block)?)
    }

    pub(super) fn check_running(&self) -> Result<(), Error> {
        match &self.run.failure {
            Some(failure) => Err(failure.clone()),
            None if self.run.ended => Err(DataError::AfterFlush.into()),
            None => Ok(()),
        }
    }

    pub(super) fn check_aligned(&self) -> Result<(), DataError> {
        let Phase::Aligning(alignment, _) = &self.run.phase else { return Ok(()) };
        let first = self.run.first_time.unwrap_or(0.0);
        let last = self.run.delay_line.newest().map_or(first, |sample| sample.time);
        Err(DataError::TooShort {
            samples: self.run.validator.counters.samples,
            duration: last - first,
            needed: alignment.duration(),
        })
    }

    pub(super) fn check_readings(&self) -> Result<(), DataError> {
        self.run.phase.aids().check_readings()
    }

    /// Reserves memory for solutions that wait for the end of the data.
    pub(super) fn reserve(&mut self, solutions: usize) {
        self.run.smoother.iter_mut().for_each(|smoother| smoother.reserve(solutions));
    }

    pub(super) fn reset(&mut self) {
        self.detector.reset();
        self.run = Run::new(&self.config, &self.strapdown, &*self.detector);
    }

    pub(super) fn latency(&self) -> usize {
        self.detector.latency() + self.run.smoother.as_ref().map_or(0, Smoother::delay)
    }

    /// Number of samples that wait for their decision.
    pub(super) fn pending(&self) -> usize {
        self.run.delay_line.len()
    }

    /// A function of the newest solution, which is assembled only as far as the function uses it.
    #[inline]
    pub(super) fn with_latest<T>(&self, function: impl FnOnce(&Solution) -> T) -> Option<T> {
        match (&self.run.latest, &self.run.phase) {
            (Latest::OfFilter(result), Phase::Navigating(ins)) => {
                Some(function(&ins.solution(*result)))
            }
            (Latest::Stored(solution), _) => Some(function(solution)),
            _ => None,
        }
    }

    /// The newest solution, extrapolated by the mechanization to the newest sample.
    pub(super) fn now(&self) -> Result<Option<NavState>, NumericalError> {
        let Some(newest) = self.run.delay_line.newest() else { return Ok(None) };
        let state = match &self.run.phase {
            Phase::Navigating(ins) => self.simd.vectorize(Extrapolate {
                ins,
                longest_gap: self.config.health.longest_gap,
                samples: self.run.delay_line.iter().map(|pending| &pending.sample),
            }),
            Phase::Levelling(levelling) => levelling.state(newest),
            Phase::Aligning(alignment, _) => {
                NavState::at_rest(newest.time, alignment.attitude_of(&newest.specific_force))
            }
        };
        if state.is_finite() {
            Ok(Some(state))
        } else {
            Err(NumericalError::StateNotFinite { time: newest.time })
        }
    }

    pub(super) fn covariance(&self) -> Option<Covariance> {
        match &self.run.phase {
            Phase::Navigating(ins) => Some(ins.filter.covariance()),
            _ => None,
        }
    }

    /// The new strides, with those that are too short; none unless they are tracked.
    pub(super) fn take_strides(&mut self) -> Vec<Stride> {
        self.run.strides.as_mut().map(StrideTracker::take).unwrap_or_default()
    }

    /// Velocity at the newest solution of the filter without the aids of its stance, n, m/s.
    #[inline]
    fn free_inertial_velocity(&self) -> &Vector3<f64> {
        match &self.run.phase {
            Phase::Navigating(ins) => ins.free_inertial_velocity(),
            _ => &AT_REST,
        }
    }

    pub(super) fn health(&self) -> Health {
        let latest = self.with_latest(|solution| *solution);
        let without = if self.run.failure.is_some() { Flags::LOST } else { Flags::ALIGNING };
        let std = latest.map_or(Vector3::zeros(), |solution| solution.position_std);
        let updates = *self.run.phase.aids().counters();
        Health {
            flags: latest.map_or(without, |solution| solution.flags),
            counters: Counters { updates, ..self.run.validator.counters },
            horizontal_std: std.x.hypot(std.y),
            vertical_std: std.z,
        }
    }

    pub(super) fn health_of_walk(&self) -> Health {
        let health = self.health();
        let aligning = health.flags & Flags::ALIGNING;
        Health { flags: self.run.flags_since_start | aligning, ..health }
    }
}

// The entries of the instruction set: a sample, a block, the end, and the cases beside the path of
// most samples.

/// See [`Stages::push_sample`].
struct PushSample<'a, S> {
    stages: &'a mut Stages<S>,
    raw: &'a ImuSample,
}

impl<S: Simd> WithSimd for PushSample<'_, S> {
    type Output = Result<bool, Error>;

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) -> Self::Output {
        self.stages.push(self.raw)
    }
}

/// See [`Stages::push_block`].
struct PushBlock<'a, S, F> {
    stages: &'a mut Stages<S>,
    block: &'a [ImuSample],
    output: F,
}

impl<S: Simd, F: FnMut(&Solution, &Vector3<f64>)> WithSimd for PushBlock<'_, S, F> {
    type Output = Result<(), Error>;

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) -> Self::Output {
        let Self { stages, block, mut output } = self;
        for raw in block {
            let flags = stages.run.validator.ingest_checked(raw);
            if stages.process(raw, flags)? {
                stages.write(&mut output);
            }
        }
        Ok(())
    }
}

/// See [`Stages::drain`].
struct Navigate<'a, S> {
    stages: &'a mut Stages<S>,
    decision: &'a Decision,
}

impl<S: Simd> WithSimd for Navigate<'_, S> {
    type Output = Result<bool, Error>;

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) -> Self::Output {
        self.stages.navigate(self.decision)
    }
}

/// Alignment, and navigation with stages after the filter.
///
/// It owns the decision, so that the numbers of the frequent case may stay in registers.
struct NavigateGeneral<'a, S> {
    stages: &'a mut Stages<S>,
    decision: Decision,
}

impl<S: Simd> WithSimd for NavigateGeneral<'_, S> {
    type Output = Result<bool, Error>;

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) -> Self::Output {
        let Self { stages, decision } = self;
        let Some(pending) = stages.run.delay_line.oldest().copied() else { return Ok(false) };
        let updated = match &stages.run.phase {
            Phase::Navigating(_) => stages.run.update_general(stages.simd, &pending, &decision),
            _ => stages.start_up(&pending, &decision),
        };
        stages.run.delay_line.release();
        match updated {
            Ok(is_new) => Ok(is_new),
            Err(failure) => Err(stages.run.fail(failure)),
        }
    }
}

/// See [`Stages::now`].
struct Extrapolate<'a, S, I> {
    ins: &'a AidedIns<S>,
    longest_gap: f64,
    samples: I,
}

impl<'a, S: Simd, I: Iterator<Item = &'a ImuSample>> WithSimd for Extrapolate<'a, S, I> {
    type Output = NavState;

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) -> NavState {
        self.ins.extrapolate(self.longest_gap, self.samples)
    }
}
