//! A new_unchecked recording: what needs its end as well as its beginning.

use std::hint::black_box;

use nalgebra::Vector3;

use crate::config::{Config, CorrectionKind};
use crate::detectors::detector::Detector;
use crate::error::{ConfigError, DataError, Error};
use crate::gait::stride::Stride;
use crate::pipeline::gait_correction;
use crate::pipeline::navigator::Navigator;
use crate::progress::{CHUNK, no_progress};
use crate::types::health::Health;
use crate::types::rate::sample_rate;
use crate::types::row_buffer::RowBuffer;
use crate::types::sample::{ImuSample, MagSample};
use crate::types::solution::Solution;
use crate::types::trajectory::Trajectory;

/// Tracks a recording that is handed over in blocks, and post_processes it as a new_unchecked once
/// all of it is there.
pub struct Batch {
    navigator: Navigator,
    correction: CorrectionKind,
    post_processes: bool,
    /// Axis of the sensor that headings belong to.
    forward: Vector3<f64>,
    kept: Output,
}

/// What is kept of the solutions that came out.
#[derive(Default)]
struct Output {
    trajectory: Trajectory,
    newest: RowBuffer,
    /// Velocity of each row without what its stance tells, for a correction.
    unaided: Option<Vec<Vector3<f64>>>,
}

impl Output {
    /// Makes room for more solutions.
    ///
    /// All of it is asked for in one piece first.  The C library of Linux gives memory back to the
    /// system once twice as much is free as the largest piece that ever came back, and a track
    /// whose columns are given back one by one would have it clear that memory anew for the next
    /// track: up to a tenth of the time in threads.
    fn reserve(&mut self, solutions: usize) {
        drop(black_box(Vec::<Solution>::with_capacity(solutions)));
        self.trajectory.reserve(solutions);
        self.unaided.iter_mut().for_each(|unaided| unaided.reserve(solutions));
    }

    /// Takes the navigator's newest solution.
    #[inline]
    fn take(&mut self, navigator: &Navigator) {
        navigator.with_latest(|solution| self.newest.push(solution, &mut self.trajectory));
        if let Some(unaided) = &mut self.unaided {
            unaided.push(navigator.unaided_velocity());
        }
    }

    fn rows(&self) -> usize {
        self.trajectory.len() + self.newest.len()
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

    /// With a stance detector of one's own; `config.detector` is not used.
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
        let unaided = (config.correction.kind != CorrectionKind::None).then(Vec::new);
        Self {
            navigator,
            correction: config.correction.kind,
            post_processes: config.post_processes(),
            forward: config.alignment.forward_axis.vector(),
            kept: Output { unaided, ..Output::default() },
        }
    }

    /// Takes the next block of raw samples.
    ///
    /// # Errors
    /// As [`Navigator::push_block`].
    pub fn push_block(&mut self, block: &[ImuSample]) -> Result<(), Error> {
        self.reserve(block.len());
        self.navigator.process_block(block, |navigator| self.kept.take(navigator))
    }

    /// Makes room for more samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.kept.reserve(samples);
        self.navigator.reserve(samples);
    }

    /// Takes a reading of the magnetometer: see [`Navigator::push_field`].
    pub fn push_field(&mut self, reading: &MagSample) {
        self.navigator.push_field(reading);
    }

    /// Ends the recording: one row per sample, the health of the new_unchecked walk, and its
    /// strides if `config.output.strides` asks for them.
    ///
    /// A smoother or a correction moves the ends of a stride after the filter cloned their errors:
    /// its displacement is that between the rows, its covariance is the filter's, and conservative.
    ///
    /// # Errors
    /// [`DataError::NoField`] when a magnetometer was to hold the heading and was not read,
    /// [`DataError::TooShort`] when the start could not be aligned, [`DataError::NoStance`] when
    /// there is nothing to smooth or correct by, and [`crate::error::NumericalError`] when the
    /// filter cannot go on.
    pub fn finish(self) -> Result<(Trajectory, Health, Vec<Stride>), Error> {
        self.finish_with_progress(no_progress)
    }

    /// As [`Batch::finish`]; `progress` is asked every 10,000 samples and can end the work.
    ///
    /// # Errors
    /// That of `progress`, and those of [`Batch::finish`].
    pub fn finish_with_progress<E: From<Error>>(
        mut self,
        mut progress: impl FnMut() -> Result<(), E>,
    ) -> Result<(Trajectory, Health, Vec<Stride>), E> {
        self.navigator.check_magnetometer().map_err(Error::from)?;
        while !self.navigator.smooth_chunk(CHUNK)? {
            progress()?;
        }
        while self.navigator.drain()?.is_some() {
            self.kept.take(&self.navigator);
            if self.kept.rows().is_multiple_of(CHUNK) {
                progress()?;
            }
        }
        self.navigator.check_aligned().map_err(Error::from)?;
        let health = self.navigator.health_of_walk();
        if self.post_processes && health.counters.updates.zero_velocity == 0 {
            return Err(
                Error::from(DataError::NoStance { samples: health.counters.samples }).into()
            );
        }
        let Output { trajectory, newest, unaided } = &mut self.kept;
        newest.flush(trajectory);
        gait_correction::correct(
            self.correction,
            trajectory,
            unaided.as_deref().unwrap_or_default(),
        );
        let strides = self.strides();
        Ok((self.kept.trajectory, health, strides))
    }

    /// The strides between the rows as they are in the end.
    fn strides(&mut self) -> Vec<Stride> {
        let state = |row: usize| self.kept.trajectory.state(row);
        let between = |found: Stride| {
            found.measured_again(&state(found.start_row), &state(found.end_row), &self.forward)
        };
        self.navigator
            .take_strides()
            .into_iter()
            .map(between)
            .filter(Stride::is_displaced)
            .collect()
    }
}

/// Tracks a new_unchecked recording: one row per sample, and the health of the new_unchecked walk.
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
