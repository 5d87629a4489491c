//! The navigator: the way of a sample from the sensor to the track, in one place.

use nalgebra::Vector3;

use crate::aiding::magnetic_heading::Compass;
use crate::calibration::Calibrator;
use crate::config::{Config, SmootherKind};
use crate::detectors::detector::{Decision, Detector};
use crate::error::{ConfigError, DataError, Error, NumericalError};
use crate::filter::covariance::Covariance;
use crate::gait::stride::Stride;
use crate::gait::stride_tracker::StrideTracker;
use crate::ins::alignment::Alignment;
use crate::ins::earth;
use crate::ins::strapdown::Strapdown;
use crate::math::simd::{Lanes, dispatch};
use crate::pipeline::aided_ins::{Finding, Setting, Walk};
use crate::pipeline::considered_scale::ScaleErrors;
use crate::pipeline::delay_line::{DelayLine, PendingSample};
use crate::pipeline::fine_levelling::Levelling;
use crate::pipeline::health_monitor::HealthMonitor;
use crate::pipeline::validation::InputValidator;
use crate::pipeline::work::{Advance, Follow, Release, SolveInFull};
use crate::smoother::smoother::Smoother;
use crate::types::health::{Counters, Flags, Health};
use crate::types::nav_state::NavState;
use crate::types::rate::samples;
use crate::types::rate::whole_hertz;
use crate::types::sample::{ImuSample, MagSample};
use crate::types::solution::Solution;
use crate::types::trajectory::Trajectory;

/// Follows one foot, sample by sample.
///
/// A solution comes out [`Navigator::latency`] samples after its sample went in, because the
/// detector looks ahead.  While the start is aligned the solutions stay at the origin and say so in
/// their flags.
pub struct Navigator {
    pub(super) config: Config,
    pub(super) validator: InputValidator,
    /// Absent if there is nothing to correct.
    pub(super) calibrator: Option<Calibrator>,
    pub(super) detector: Box<dyn Detector>,
    pub(super) waiting: DelayLine,
    pub(super) strapdown: Strapdown,
    pub(super) phase: Phase,
    pub(super) smoother: Option<Smoother>,
    pub(super) strides: Option<StrideTracker>,
    pub(super) scale: Option<ScaleErrors>,
    pub(super) compass: Option<Compass>,
    pub(super) monitor: HealthMonitor,
    pub(super) latest: Latest,
    /// All that spoke against a solution since the start was aligned.
    pub(super) flags_since_start: Flags,
    pub(super) first_time: Option<f64>,
    pub(super) ended: bool,
    pub(super) failure: Option<Error>,
}

/// What the navigator is doing.
#[expect(
    clippy::large_enum_variant,
    reason = "there is one of it, and a box would be one more hop for every sample"
)]
pub(crate) enum Phase {
    Aligning(Alignment),
    Levelling(Levelling),
    Walking(Walk),
}

impl Phase {
    pub(super) fn start(config: &Config, strapdown: &Strapdown) -> Self {
        Self::Aligning(Alignment::new(config.alignment.clone(), strapdown))
    }

    /// Covariance of the error states, if it is at hand; none while the start is being aligned.
    pub(super) fn covariance_at_hand(&self) -> Option<&Covariance> {
        match self {
            Self::Walking(walk) => walk.filter.covariance_at_hand(),
            _ => None,
        }
    }
}

impl Navigator {
    /// A navigator for samples at about `rate_hz`.
    ///
    /// The rate only sets the lengths of windows and what counts as a gap; it is rounded to
    /// new_unchecked hertz, so that a measured rate and the one that the sensor was set to give the
    /// same solution to the bit.
    ///
    /// # Errors
    /// [`ConfigError`] for a setting or a rate out of range, or a setting that needs the
    /// new_unchecked recording: see [`crate::batch::Batch`].
    pub fn new(config: Config, rate_hz: f64) -> Result<Self, ConfigError> {
        config.validate_for_streaming()?;
        Self::new_unchecked(config, rate_hz, None)
    }

    /// A navigator with a stance detector of one's own; `config.detector` is not used.
    ///
    /// # Errors
    /// As [`Navigator::new`].
    pub fn with_detector(
        config: Config,
        rate_hz: f64,
        detector: Box<dyn Detector>,
    ) -> Result<Self, ConfigError> {
        config.validate_for_streaming()?;
        Self::new_unchecked(config, rate_hz, Some(detector))
    }

    /// A navigator whose solutions may all have to wait for the end.
    pub(crate) fn new_unchecked(
        config: Config,
        rate_hz: f64,
        detector: Option<Box<dyn Detector>>,
    ) -> Result<Self, ConfigError> {
        config.validate()?;
        let rate = whole_hertz(rate_hz)?;
        let detector = detector.unwrap_or_else(|| config.detector.build(rate, config.gravity()));
        let (gravity, mechanization) = (config.gravity(), &config.mechanization);
        let latitude = config.latitude_deg().to_radians();
        let earth_rate = if mechanization.earth_rate {
            earth::rotation_rate(latitude)
        } else {
            Vector3::zeros()
        };
        let strapdown = Strapdown {
            kind: mechanization.kind,
            gravity,
            earth_rate,
            nominal_interval: 1.0 / rate,
        };
        Ok(Self {
            validator: InputValidator::new(&config, strapdown.nominal_interval),
            calibrator: Calibrator::new(&config.calibration),
            waiting: DelayLine::with_room_for(detector.latency()),
            detector,
            strapdown,
            phase: Phase::start(&config, &strapdown),
            smoother: smoother(&config, rate),
            strides: strides(&config),
            scale: ScaleErrors::new(&config.sensor),
            compass: Compass::new(&config.magnetometer),
            monitor: HealthMonitor::new(config.health.clone()),
            latest: Latest::None,
            flags_since_start: Flags::empty(),
            first_time: None,
            ended: false,
            failure: None,
            config,
        })
    }

    /// Takes the next raw sample; returns the solution of the sample [`Navigator::latency`] before
    /// it, once there is such a one.
    ///
    /// # Errors
    /// [`DataError`] for a sample that is not finite or goes back in time: it is refused and
    /// counted, and the next good one goes on after a gap. [`DataError`] when the start cannot be
    /// aligned and [`NumericalError`] when the filter cannot go on; every later call repeats these
    /// until [`Navigator::reset`].
    #[inline]
    pub fn push(&mut self, raw: &ImuSample) -> Result<Option<Solution>, Error> {
        Ok(if self.advance(raw)? { self.latest() } else { None })
    }

    /// As [`Navigator::push`], but the solution stays where [`Navigator::latest`] shows it; answers
    /// whether there is a new one.
    ///
    /// # Errors
    /// As [`Navigator::push`].
    #[inline]
    pub fn advance(&mut self, raw: &ImuSample) -> Result<bool, Error> {
        dispatch(Advance { navigator: self, raw })
    }

    /// Takes a block of raw samples, and shows the navigator whenever a solution came out.
    ///
    /// # Errors
    /// As [`Navigator::push_block`].
    pub(crate) fn process_block(
        &mut self,
        block: &[ImuSample],
        output: impl FnMut(&Self),
    ) -> Result<(), Error> {
        self.check_block(block)?;
        dispatch(Follow { navigator: self, block, output })
    }

    /// A sample that was found good waits for its decision, and the oldest that waits may get one.
    #[inline(always)]
    pub(super) fn take<L: Lanes>(&mut self, raw: &ImuSample, events: Flags) -> Result<bool, Error> {
        self.first_time.get_or_insert(raw.time);
        let corrected = self.calibrator.as_ref().map(|calibrator| calibrator.apply(raw));
        let sample = corrected.as_ref().unwrap_or(raw);
        self.waiting.push(sample, events);
        match self.detector.push(sample) {
            Some(decision) => self.release::<L>(&decision),
            None => Ok(false),
        }
    }

    /// Takes a reading of the magnetometer; it has to come before the first sample that is as new.
    ///
    /// It is used if `config.magnetometer.heading` is set.
    pub fn push_field(&mut self, reading: &MagSample) {
        if let Some(compass) = &mut self.compass {
            compass.push(reading);
        }
    }

    /// Takes a block of raw samples and returns the solutions that came out.
    ///
    /// # Errors
    /// As [`Navigator::push`]; a block with a bad sample is refused as a new_unchecked, before any
    /// of it was used.
    pub fn push_block(&mut self, block: &[ImuSample]) -> Result<Trajectory, Error> {
        let mut solutions = Trajectory::with_capacity(block.len());
        self.push_block_into(block, &mut solutions)?;
        Ok(solutions)
    }

    /// As [`Navigator::push_block`], for any collection of solutions.
    ///
    /// # Errors
    /// As [`Navigator::push_block`].
    pub fn push_block_into(
        &mut self,
        block: &[ImuSample],
        solutions: &mut impl Extend<Solution>,
    ) -> Result<(), Error> {
        self.process_block(block, |navigator| solutions.extend(navigator.latest()))
    }

    /// Ends the data and returns the solutions of the last [`Navigator::latency`] samples.
    ///
    /// # Errors
    /// [`NumericalError`] when the filter cannot go on.
    pub fn flush(&mut self) -> Result<Trajectory, Error> {
        let mut solutions = Trajectory::with_capacity(self.waiting.len());
        self.flush_into(&mut solutions)?;
        Ok(solutions)
    }

    /// As [`Navigator::flush`], for any collection of solutions.
    ///
    /// # Errors
    /// As [`Navigator::flush`].
    pub fn flush_into(&mut self, solutions: &mut impl Extend<Solution>) -> Result<(), Error> {
        self.check_running()?;
        while let Some(solution) = self.drain()? {
            solutions.extend(Some(solution));
        }
        self.ended = true;
        Ok(())
    }

    /// Checks a block of raw samples before any of it is used.
    pub(crate) fn check_block(&self, block: &[ImuSample]) -> Result<(), Error> {
        self.check_running()?;
        Ok(self.validator.check_block(block)?)
    }

    /// The next of the solutions that are left at the end of the data.
    pub(crate) fn drain(&mut self) -> Result<Option<Solution>, Error> {
        while let Some(decision) = self.detector.drain() {
            if dispatch(Release { navigator: self, decision: &decision })? {
                return Ok(self.latest());
            }
        }
        if let Some(strides) = &mut self.strides {
            strides.finish();
        }
        let Some(left) = self.smoother.as_mut().and_then(Smoother::drain) else { return Ok(None) };
        self.emit(left);
        Ok(self.latest())
    }

    /// Makes room for solutions that have to wait for the end of the data.
    pub(crate) fn reserve(&mut self, solutions: usize) {
        self.smoother.iter_mut().for_each(|smoother| smoother.reserve(solutions));
    }

    /// Does some of what has to wait for the end of the data, for about `rows` solutions; answers
    /// whether all of it is done, and [`Navigator::drain`] has only to hand out.
    ///
    /// # Errors
    /// [`NumericalError`] when the filter cannot go on.
    pub(crate) fn smooth_chunk(&mut self, rows: usize) -> Result<bool, Error> {
        if !self.smoother.as_ref().is_some_and(Smoother::waits_for_end) {
            return Ok(true);
        }
        while let Some(decision) = self.detector.drain() {
            dispatch(Release { navigator: self, decision: &decision })?;
        }
        Ok(self.smoother.as_mut().is_none_or(|smoother| smoother.smooth_chunk(rows)))
    }

    /// Forgets everything but the settings.
    pub fn reset(&mut self) {
        self.detector.reset();
        self.waiting = DelayLine::with_room_for(self.detector.latency());
        self.validator = InputValidator::new(&self.config, self.strapdown.nominal_interval);
        self.phase = Phase::start(&self.config, &self.strapdown);
        self.smoother = smoother(&self.config, 1.0 / self.strapdown.nominal_interval);
        self.strides = strides(&self.config);
        self.scale = ScaleErrors::new(&self.config.sensor);
        self.compass = Compass::new(&self.config.magnetometer);
        self.monitor = HealthMonitor::new(self.config.health.clone());
        self.latest = Latest::None;
        self.flags_since_start = Flags::empty();
        self.first_time = None;
        self.ended = false;
        self.failure = None;
    }

    /// Number of samples by which a solution comes late.
    #[must_use]
    pub fn latency(&self) -> usize {
        self.detector.latency() + self.smoother.as_ref().map_or(0, Smoother::delay)
    }

    /// The newest solution that came out; none before the first, and when the navigator cannot go
    /// on.
    #[must_use]
    pub fn latest(&self) -> Option<Solution> {
        self.with_latest(|solution| *solution)
    }

    /// Something of the newest solution that came out, which need not be put together for it.
    #[inline]
    pub(crate) fn with_latest<T>(&self, something: impl FnOnce(&Solution) -> T) -> Option<T> {
        match (&self.latest, &self.phase) {
            (Latest::OfWalk(found), Phase::Walking(walk)) => {
                Some(something(&walk.solution(*found)))
            }
            (Latest::Apart(solution), _) => Some(something(solution)),
            _ => None,
        }
    }

    /// The state at the newest sample: the newest solution carried forward by the strapdown alone.
    ///
    /// While the start is aligned that is the origin, levelled by the newest sample.  None before
    /// the first sample.
    ///
    /// # Errors
    /// [`NumericalError`] when the samples that wait for their decision are too large to integrate.
    pub fn now(&self) -> Result<Option<NavState>, NumericalError> {
        let Some(newest) = self.waiting.newest().copied() else { return Ok(None) };
        let state = match &self.phase {
            Phase::Walking(walk) => {
                let samples = self.waiting.iter().map(|pending| &pending.sample);
                walk.ahead(&self.strapdown, self.config.health.longest_gap, samples)
            }
            Phase::Levelling(levelling) => levelling.state(&newest),
            Phase::Aligning(alignment) => {
                NavState::at_rest(newest.time, alignment.attitude_of(&newest.specific_force))
            }
        };
        if state.is_finite() {
            Ok(Some(state))
        } else {
            Err(NumericalError::StateNotFinite { time: newest.time })
        }
    }

    /// Covariance of the error states; none while the start is being aligned.
    #[must_use]
    pub fn covariance(&self) -> Option<Covariance> {
        match &self.phase {
            Phase::Walking(walk) => Some(walk.filter.covariance()),
            _ => None,
        }
    }

    /// The strides that came to be known since the last call.
    ///
    /// A stride is known when both of its ends came out and the foot has left the stance that it
    /// ends in for 0.1 s, has stood there for half a second, or the data are over.
    ///
    /// # Errors
    /// [`ConfigError`] unless `config.output.strides` is set.
    pub fn strides(&mut self) -> Result<Vec<Stride>, ConfigError> {
        if !self.config.output.strides {
            return Err(ConfigError::Inconsistent(
                "strides are not kept: set output.strides = true".into(),
            ));
        }
        let mut strides = self.take_strides();
        strides.retain(Stride::is_displaced);
        Ok(strides)
    }

    /// As [`Navigator::strides`], shuffles on the spot among them; none unless they are kept.
    pub(crate) fn take_strides(&mut self) -> Vec<Stride> {
        self.strides.as_mut().map(StrideTracker::take).unwrap_or_default()
    }

    /// Velocity at the filter's newest solution without what its stance tells, n, m/s.
    pub(crate) fn unaided_velocity(&self) -> Vector3<f64> {
        match &self.phase {
            Phase::Walking(walk) => walk.unaided_velocity(),
            _ => Vector3::zeros(),
        }
    }

    /// Trust in the newest solution.
    #[must_use]
    pub fn health(&self) -> Health {
        let latest = self.latest();
        let without = if self.failure.is_some() { Flags::LOST } else { Flags::ALIGNING };
        let std = latest.map_or(Vector3::zeros(), |solution| solution.position_std);
        Health {
            flags: latest.map_or(without, |solution| solution.flags),
            counters: Counters { updates: self.monitor.updates, ..self.validator.counters },
            horizontal_std: std.x.hypot(std.y),
            vertical_std: std.z,
        }
    }

    /// Trust in the new_unchecked walk: all that spoke against it since the start was aligned.
    #[must_use]
    pub fn health_of_walk(&self) -> Health {
        let health = self.health();
        let aligning = health.flags & Flags::ALIGNING;
        Health { flags: self.flags_since_start | aligning, ..health }
    }

    /// Checks that the start was aligned, as a new_unchecked walk needs.
    ///
    /// # Errors
    /// [`DataError::TooShort`].
    pub fn check_aligned(&self) -> Result<(), DataError> {
        let Phase::Aligning(alignment) = &self.phase else { return Ok(()) };
        let first = self.first_time.unwrap_or(0.0);
        let last = self.waiting.newest().map_or(first, |sample| sample.time);
        Err(DataError::TooShort {
            samples: self.validator.counters.samples,
            duration: last - first,
            needed: alignment.duration(),
        })
    }

    /// Checks that a magnetometer was read if it is to hold the heading.
    ///
    /// # Errors
    /// [`DataError::NoField`].
    pub(crate) fn check_magnetometer(&self) -> Result<(), DataError> {
        if self.compass.as_ref().is_none_or(Compass::has_read) {
            Ok(())
        } else {
            Err(DataError::NoField)
        }
    }

    pub(super) fn check_running(&self) -> Result<(), Error> {
        match &self.failure {
            Some(failure) => Err(failure.clone()),
            None if self.ended => Err(DataError::AfterFlush.into()),
            None => Ok(()),
        }
    }

    /// Gives the oldest waiting sample its decision and solves it; a failure is remembered, since
    /// the sample is lost.
    #[inline(always)]
    pub(super) fn release<L: Lanes>(&mut self, decision: &Decision) -> Result<bool, Error> {
        let solved = self.solve::<L>(decision);
        self.waiting.release();
        match solved {
            Ok(output) => Ok(output),
            Err(failure) => Err(self.fail(failure)),
        }
    }

    /// Nothing that the failure left behind is a solution.
    #[cold]
    pub(super) fn fail(&mut self, failure: Error) -> Error {
        self.latest = Latest::None;
        self.flags_since_start |= Flags::LOST;
        self.failure = Some(failure.clone());
        failure
    }

    /// Solves the oldest waiting sample, and answers whether a solution came out.
    #[inline(always)]
    pub(super) fn solve<L: Lanes>(&mut self, decision: &Decision) -> Result<bool, Error> {
        let Some(pending) = self.waiting.oldest() else { return Ok(false) };
        let setting = Setting { strapdown: &self.strapdown, filter: &self.config.filter };
        let alone = self.smoother.is_none()
            && self.strides.is_none()
            && self.compass.is_none()
            && self.scale.is_none();
        let (Phase::Walking(walk), true) = (&mut self.phase, alone) else {
            let (pending, decision) = (*pending, *decision);
            return L::call(SolveInFull { navigator: self, pending, decision });
        };
        let found = walk.update::<L>(&setting, &mut self.monitor, pending, decision, &mut ())?;
        self.flags_since_start |= found.flags;
        self.latest = Latest::OfWalk(found);
        Ok(true)
    }

    /// The same at the start, with a magnetometer, and where what comes out is not the filter's
    /// solution alone.
    #[inline(always)]
    pub(super) fn update_general<L: Lanes>(
        &mut self,
        pending: &PendingSample,
        decision: &Decision,
    ) -> Result<bool, Error> {
        let setting = Setting { strapdown: &self.strapdown, filter: &self.config.filter };
        let Phase::Walking(walk) = &mut self.phase else {
            return self.solve_at_start::<L>(pending, decision);
        };
        let strides = self.strides.as_mut().map(StrideTracker::recorder);
        let mut recorder = (strides, self.smoother.as_mut().map(Smoother::recorder));
        let found =
            walk.update::<L>(&setting, &mut self.monitor, pending, decision, &mut recorder)?;
        if let Some(compass) = &mut self.compass {
            compass.update(&mut walk.filter, &mut self.monitor, found.zero_velocity, &mut recorder);
            walk.filter.check()?;
        }
        self.flags_since_start |= found.flags;
        let solution = walk.solution(found);
        Ok(self.delay(solution))
    }

    /// The same while the start is being aligned.
    #[inline(always)]
    pub(super) fn solve_at_start<L: Lanes>(
        &mut self,
        pending: &PendingSample,
        decision: &Decision,
    ) -> Result<bool, Error> {
        let solution = self.start::<L>(pending, decision)?;
        Ok(self.delay(solution))
    }

    /// Lets those who wait for what comes later take the filter's newest solution, and answers
    /// whether one came out.
    pub(super) fn delay(&mut self, found: Solution) -> bool {
        if let Some(strides) = &mut self.strides {
            strides.push(&found, self.phase.covariance_at_hand());
        }
        let due = match &mut self.smoother {
            None => Some(found),
            Some(smoother) => smoother.push(&found, self.phase.covariance_at_hand()),
        };
        let Some(solution) = due else { return false };
        self.emit(solution);
        true
    }

    /// A solution comes out.
    pub(super) fn emit(&mut self, mut solution: Solution) {
        if let Some(scale) = &mut self.scale {
            scale.widen(&mut solution);
        }
        if let Some(strides) = &mut self.strides {
            strides.on_output(&solution);
        }
        self.latest = Latest::Apart(solution);
    }
}

fn smoother(config: &Config, rate: f64) -> Option<Smoother> {
    match config.smoother.kind {
        SmootherKind::None => None,
        SmootherKind::Stepwise => {
            Some(Smoother::stepwise(samples(config.smoother.longest_step * rate)))
        }
        SmootherKind::Rts => Some(Smoother::fixed_interval()),
    }
}

fn strides(config: &Config) -> Option<StrideTracker> {
    config.output.strides.then(|| StrideTracker::new(config.alignment.forward_axis.vector()))
}

/// The newest solution that came out.
pub(crate) enum Latest {
    None,
    /// The walk's estimate as it is, with what was found beside it.
    OfWalk(Finding),
    /// That of the start, or one that was held back or changed after the filter found it.
    Apart(Solution),
}
