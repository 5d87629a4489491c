//! The navigator: one foot, sample by sample.

use nalgebra::Vector3;

use crate::aiding::Reading;
use crate::config::Config;
use crate::detectors::detector::Detector;
use crate::error::{ConfigError, DataError, Error, NumericalError};
use crate::filter::covariance::Covariance;
use crate::gait::stride::Stride;
use crate::ins::earth;
use crate::ins::strapdown::Strapdown;
#[cfg(target_arch = "x86_64")]
use crate::math::simd::Avx2;
use crate::math::simd::{Baseline, InstructionSet, detect};
use crate::pipeline::health_monitor::Health;
use crate::pipeline::stages::Stages;
use crate::types::nav_state::NavState;
use crate::types::rate::whole_hertz;
use crate::types::sample::ImuSample;
use crate::types::solution::Solution;
use crate::types::trajectory::Trajectory;

/// Navigates one foot, sample by sample.
///
/// The solution of a sample is output [`Navigator::latency`] samples later, because the detector
/// looks ahead.  During the alignment of the start the solutions stay at the origin, and are
/// flagged.
pub struct Navigator {
    stages: Compiled,
}

/// The stages, compiled for each instruction set.
enum Compiled {
    Baseline(Stages<Baseline>),
    #[cfg(target_arch = "x86_64")]
    Avx2(Stages<Avx2>),
}

/// The value of an expression in which a name stands for the stages.
macro_rules! with_stages {
    ($navigator:expr, $stages:ident => $value:expr) => {
        match $navigator {
            Compiled::Baseline($stages) => $value,
            #[cfg(target_arch = "x86_64")]
            Compiled::Avx2($stages) => $value,
        }
    };
}

impl Navigator {
    /// A navigator for samples at about `rate_hz`.
    ///
    /// The rate sets only the lengths of windows and what counts as a gap.  It is rounded to whole
    /// hertz, so that a measured rate and the nominal one give the same solution to the bit.
    ///
    /// # Errors
    /// [`ConfigError`] for a setting or a rate out of range, or a setting that needs the whole
    /// recording: see [`crate::Batch`].
    pub fn new(config: Config, rate_hz: f64) -> Result<Self, ConfigError> {
        config.validate_for_streaming()?;
        Self::new_unchecked(config, rate_hz, None)
    }

    /// A navigator with a stance detector of the caller's; `config.detector` is not used.
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

    /// A navigator whose solutions may wait for the end of the data.
    pub(crate) fn new_unchecked(
        config: Config,
        rate_hz: f64,
        detector: Option<Box<dyn Detector>>,
    ) -> Result<Self, ConfigError> {
        config.validate()?;
        let rate = whole_hertz(rate_hz)?;
        let detector = detector.unwrap_or_else(|| config.detector.build(rate, config.gravity()));
        let strapdown = strapdown(&config, 1.0 / rate);
        let stages = match detect() {
            InstructionSet::Baseline(simd) => {
                Compiled::Baseline(Stages::new(simd, config, strapdown, detector))
            }
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2(simd) => {
                Compiled::Avx2(Stages::new(simd, config, strapdown, detector))
            }
        };
        Ok(Self { stages })
    }

    /// Processes the next raw sample; returns the solution of the sample [`Navigator::latency`]
    /// before it, if there is one.
    ///
    /// # Errors
    /// [`DataError`] for a sample that is not finite or goes back in time: it is refused and counted,
    /// and the next valid one continues after a gap.  [`DataError`] when the start cannot be aligned
    /// and [`NumericalError`] when the filter fails; every later call repeats these until
    /// [`Navigator::reset`].
    #[inline]
    pub fn push(&mut self, raw: &ImuSample) -> Result<Option<Solution>, Error> {
        Ok(if self.advance(raw)? { self.latest() } else { None })
    }

    /// As [`Navigator::push`], without assembling the solution, which [`Navigator::latest`] returns;
    /// whether there is a new one.
    ///
    /// # Errors
    /// As [`Navigator::push`].
    #[inline]
    pub fn advance(&mut self, raw: &ImuSample) -> Result<bool, Error> {
        with_stages!(&mut self.stages, stages => stages.push_sample(raw))
    }

    /// Processes a block of raw samples; `output` takes each new solution, with the free-inertial
    /// velocity (n, m/s).
    pub(crate) fn process_block(
        &mut self,
        block: &[ImuSample],
        output: impl FnMut(&Solution, &Vector3<f64>),
    ) -> Result<(), Error> {
        self.check_block(block)?;
        with_stages!(&mut self.stages, stages => stages.push_block(block, output))
    }

    /// Takes a reading of another sensor, such as a magnetometer; it has to come before the first
    /// sample that is as new.
    ///
    /// It is used if the settings ask for its aid.
    pub fn push_reading(&mut self, reading: impl Into<Reading>) {
        with_stages!(&mut self.stages, stages => stages.push_reading(&reading.into()));
    }

    /// Processes a block of raw samples and returns the new solutions.
    ///
    /// # Errors
    /// As [`Navigator::push`]; a block with an invalid sample is refused as a whole, before any of it
    /// is used.
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
        self.process_block(block, |solution, _| solutions.extend(Some(*solution)))
    }

    /// Ends the data and returns the solutions of the last [`Navigator::latency`] samples.
    ///
    /// # Errors
    /// [`NumericalError`] when the filter fails.
    pub fn flush(&mut self) -> Result<Trajectory, Error> {
        let pending = with_stages!(&self.stages, stages => stages.pending());
        let mut solutions = Trajectory::with_capacity(pending);
        self.flush_into(&mut solutions)?;
        Ok(solutions)
    }

    /// As [`Navigator::flush`], for any collection of solutions.
    ///
    /// # Errors
    /// As [`Navigator::flush`].
    pub fn flush_into(&mut self, solutions: &mut impl Extend<Solution>) -> Result<(), Error> {
        with_stages!(&self.stages, stages => stages.check_running())?;
        while !self.drain(usize::MAX, |solution, _| solutions.extend(Some(*solution)))? {}
        with_stages!(&mut self.stages, stages => stages.end());
        Ok(())
    }

    /// Checks a block of raw samples before any of it is used.
    pub(crate) fn check_block(&self, block: &[ImuSample]) -> Result<(), Error> {
        with_stages!(&self.stages, stages => stages.check_block(block))
    }

    /// At the end of the data, processes up to `rows` of the samples and solutions that wait; whether
    /// all are done.
    ///
    /// # Errors
    /// [`NumericalError`] when the filter fails.
    pub(crate) fn drain(
        &mut self,
        rows: usize,
        output: impl FnMut(&Solution, &Vector3<f64>),
    ) -> Result<bool, Error> {
        with_stages!(&mut self.stages, stages => stages.drain(rows, output))
    }

    /// Reserves memory for solutions that wait for the end of the data.
    pub(crate) fn reserve(&mut self, solutions: usize) {
        with_stages!(&mut self.stages, stages => stages.reserve(solutions));
    }

    /// Discards everything but the settings.
    pub fn reset(&mut self) {
        with_stages!(&mut self.stages, stages => stages.reset());
    }

    /// Delay of the solutions, in samples.
    #[must_use]
    pub fn latency(&self) -> usize {
        with_stages!(&self.stages, stages => stages.latency())
    }

    /// The newest solution; none before the first, and after a failure.
    #[must_use]
    pub fn latest(&self) -> Option<Solution> {
        self.with_latest(|solution| *solution)
    }

    /// A function of the newest solution, which is assembled only as far as the function uses it.
    #[inline]
    pub(crate) fn with_latest<T>(&self, function: impl FnOnce(&Solution) -> T) -> Option<T> {
        with_stages!(&self.stages, stages => stages.with_latest(function))
    }

    /// The state at the newest sample: the newest solution, propagated by the mechanization alone.
    ///
    /// During the alignment that is the origin, levelled by the newest sample.  None before the first
    /// sample.
    ///
    /// # Errors
    /// [`NumericalError`] when the samples that wait for their decision are too large to integrate.
    pub fn now(&self) -> Result<Option<NavState>, NumericalError> {
        with_stages!(&self.stages, stages => stages.now())
    }

    /// Covariance of the error states; none during the alignment.
    #[must_use]
    pub fn covariance(&self) -> Option<Covariance> {
        with_stages!(&self.stages, stages => stages.covariance())
    }

    /// The strides that were completed since the last call.
    ///
    /// A stride is complete when the solutions of both of its ends are output and the foot has left
    /// the stance that it ends in for 0.1 s, has stood there for half a second, or the data have
    /// ended.
    ///
    /// # Errors
    /// [`ConfigError`] unless `config.output.strides` is set.
    pub fn strides(&mut self) -> Result<Vec<Stride>, ConfigError> {
        if !with_stages!(&self.stages, stages => stages.config.output.strides) {
            return Err(ConfigError::Inconsistent(
                "strides are not tracked: set output.strides = true".into(),
            ));
        }
        let mut strides = self.take_strides();
        strides.retain(Stride::is_displaced);
        Ok(strides)
    }

    /// As [`Navigator::strides`], with those that are too short; none unless they are tracked.
    pub(crate) fn take_strides(&mut self) -> Vec<Stride> {
        with_stages!(&mut self.stages, stages => stages.take_strides())
    }

    /// Health of the newest solution.
    #[must_use]
    pub fn health(&self) -> Health {
        with_stages!(&self.stages, stages => stages.health())
    }

    /// Health of the whole walk: all flags since the start was aligned.
    #[must_use]
    pub fn health_of_walk(&self) -> Health {
        with_stages!(&self.stages, stages => stages.health_of_walk())
    }

    /// Checks that the start was aligned.
    ///
    /// # Errors
    /// [`DataError::TooShort`].
    pub fn check_aligned(&self) -> Result<(), DataError> {
        with_stages!(&self.stages, stages => stages.check_aligned())
    }

    /// Checks that each aid that needs readings has had some.
    ///
    /// # Errors
    /// [`DataError::NoField`].
    pub(crate) fn check_readings(&self) -> Result<(), DataError> {
        with_stages!(&self.stages, stages => stages.check_readings())
    }
}

/// The mechanization that the settings describe.
fn strapdown(config: &Config, nominal_interval: f64) -> Strapdown {
    let (gravity, mechanization) = (config.gravity(), &config.mechanization);
    let latitude = config.latitude_deg().to_radians();
    let earth_rate =
        if mechanization.earth_rate { earth::rotation_rate(latitude) } else { Vector3::zeros() };
    Strapdown { kind: mechanization.kind, gravity, earth_rate, nominal_interval }
}
