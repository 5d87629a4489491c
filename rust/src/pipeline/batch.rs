//! Batch tracking of a whole recording: what needs its end as well as its start.

use std::hint::black_box;

use nalgebra::Vector3;

use crate::aiding::Reading;
use crate::config::Config;
use crate::detectors::detector::Detector;
use crate::error::{ConfigError, DataError, Error};
use crate::gait::correction;
use crate::gait::correction::CorrectionKind;
use crate::gait::stride::Stride;
use crate::pipeline::health_monitor::Health;
use crate::pipeline::navigator::Navigator;
use crate::progress::{CHUNK, no_progress};
use crate::types::rate::sample_rate;
use crate::types::sample::ImuSample;
use crate::types::solution::Solution;
use crate::types::trajectory::{RowBuffer, Trajectory};

/// Tracks a recording that is given in blocks, and post-processes it once all of it is there.
pub struct Batch {
    navigator: Navigator,
    correction: CorrectionKind,
    post_processes: bool,
    /// Axis of the sensor to which headings belong.
    forward: Vector3<f64>,
    output: Output,
}

/// The solutions so far.
#[derive(Default)]
struct Output {
    trajectory: Trajectory,
    newest: RowBuffer,
    /// Free-inertial velocity of each row, for a correction.
    free_inertial: Option<Vec<Vector3<f64>>>,
}

impl Output {
    /// Reserves memory for more solutions.
    ///
    /// All of it is allocated in one piece first.  The C library of Linux returns memory to the
    /// system once twice as much is free as the largest piece that was ever freed, and without that
    /// piece it would return the columns of each track and clear their memory for the next one: up
    /// to a tenth of the time in threads.
    fn reserve(&mut self, solutions: usize) {
        drop(black_box(Vec::<Solution>::with_capacity(solutions)));
        self.trajectory.reserve(solutions);
        self.free_inertial.iter_mut().for_each(|velocities| velocities.reserve(solutions));
    }

    #[inline]
    fn push(&mut self, solution: &Solution, free_inertial: &Vector3<f64>) {
        self.newest.push(solution, &mut self.trajectory);
        if let Some(velocities) = &mut self.free_inertial {
            velocities.push(*free_inertial);
        }
    }
}

impl Batch {
    /// For a recording at about `rate_hz`.
    ///
    /// # Errors
    /// [`ConfigError`] for a setting or a rate out of range.
    pub fn new(config: Config, rate_hz: f64) -> Result<Self, ConfigError> {
        Ok(Self::of(&config.clone(), Navigator::new_unchecked(config, rate_hz, None)?))
    }

    /// With a stance detector of the caller's; `config.detector` is not used.
    ///
    /// # Errors
    /// [`ConfigError`] for a setting or a rate out of range.
    pub fn with_detector(
        config: Config,
        rate_hz: f64,
        detector: Box<dyn Detector>,
    ) -> Result<Self, ConfigError> {
        Ok(Self::of(&config.clone(), Navigator::new_unchecked(config, rate_hz, Some(detector))?))
    }

    fn of(config: &Config, navigator: Navigator) -> Self {
        let free_inertial = (config.correction.kind != CorrectionKind::None).then(Vec::new);
        Self {
            navigator,
            correction: config.correction.kind,
            post_processes: config.post_processes(),
            forward: config.alignment.forward_axis.vector(),
            output: Output { free_inertial, ..Output::default() },
        }
    }

    /// Processes the next block of raw samples.
    ///
    /// # Errors
    /// As [`Navigator::push_block`].
    pub fn push_block(&mut self, block: &[ImuSample]) -> Result<(), Error> {
        self.reserve(block.len());
        let output = &mut self.output;
        self.navigator.process_block(block, |solution, velocity| output.push(solution, velocity))
    }

    /// Reserves memory for more samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.output.reserve(samples);
        self.navigator.reserve(samples);
    }

    /// Takes a reading of another sensor: see [`Navigator::push_reading`].
    pub fn push_reading(&mut self, reading: impl Into<Reading>) {
        self.navigator.push_reading(reading);
    }

    /// Ends the recording: one row per sample, the health of the whole walk, and its strides if
    /// `config.output.strides` is set.
    ///
    /// A smoother or a correction moves the ends of a stride after the filter has cloned their
    /// errors: its displacement is that between the rows, its covariance is the filter's, and
    /// conservative.
    ///
    /// # Errors
    /// [`DataError::NoField`] without readings of a magnetometer that the settings ask for,
    /// [`DataError::TooShort`] when the start could not be aligned, [`DataError::NoStance`] without a
    /// stance to smooth or correct by, and [`crate::error::NumericalError`] when the filter fails.
    pub fn finish(self) -> Result<(Trajectory, Health, Vec<Stride>), Error> {
        self.finish_with_progress(no_progress)
    }

    /// As [`Batch::finish`]; `progress` is called every 10,000 samples, and its error cancels the
    /// work.
    ///
    /// # Errors
    /// That of `progress`, and those of [`Batch::finish`].
    pub fn finish_with_progress<E: From<Error>>(
        mut self,
        mut progress: impl FnMut() -> Result<(), E>,
    ) -> Result<(Trajectory, Health, Vec<Stride>), E> {
        self.navigator.check_readings().map_err(Error::from)?;
        let output = &mut self.output;
        while !self.navigator.drain(CHUNK, |solution, velocity| output.push(solution, velocity))? {
            progress()?;
        }
        self.navigator.check_aligned().map_err(Error::from)?;
        let health = self.navigator.health_of_walk();
        if self.post_processes && health.counters.updates.zero_velocity.accepted == 0 {
            let samples = health.counters.samples;
            return Err(Error::from(DataError::NoStance { samples }).into());
        }
        let Output { trajectory, newest, free_inertial } = &mut self.output;
        newest.flush(trajectory);
        let velocities = free_inertial.as_deref().unwrap_or_default();
        correction::correct(self.correction, trajectory, velocities);
        let strides = self.strides();
        Ok((self.output.trajectory, health, strides))
    }

    /// The strides between the final rows.
    fn strides(&mut self) -> Vec<Stride> {
        let state = |row: usize| self.output.trajectory.state(row);
        let remeasured = |stride: Stride| {
            let (start, end) = (state(stride.start_row), state(stride.end_row));
            stride.measured_again(&start, &end, &self.forward)
        };
        let strides = self.navigator.take_strides().into_iter();
        strides.map(remeasured).filter(Stride::is_displaced).collect()
    }
}

/// Tracks a whole recording: one row per sample, and the health of the whole walk.
///
/// # Errors
/// [`crate::error::ConfigError`] for a setting out of range, [`DataError`] for samples that cannot
/// be used or are too few, [`crate::error::NumericalError`] when the filter cannot go on.
pub fn track(samples: &[ImuSample], config: &Config) -> Result<(Trajectory, Health), Error> {
    let Some(rate) = sample_rate(samples) else {
        let (samples, needed) = (samples.len() as u64, config.alignment.duration);
        return Err(DataError::TooShort { samples, duration: 0.0, needed }.into());
    };
    let mut batch = Batch::new(config.clone(), rate)?;
    batch.push_block(samples)?;
    let (trajectory, health, _) = batch.finish()?;
    Ok((trajectory, health))
}
