//! A whole recording: what needs its end as well as its beginning.

use std::hint::black_box;

use nalgebra::Vector3;

use crate::config::{Config, CorrectionKind};
use crate::correction;
use crate::detector::Detector;
use crate::error::{ConfigError, DataError, Error};
use crate::gait::Stride;
use crate::health::Health;
use crate::navigator::{Navigator, Solution};
use crate::sample::{ImuSample, MagSample};
use crate::trajectory::{Chunk, Trajectory};
use crate::watch::{STRETCH, unwatched};

/// Tracks a recording that is handed over in blocks, and refines it as a whole once all of it is there.
pub struct Batch {
    navigator: Navigator,
    correction: CorrectionKind,
    refines: bool,
    /// Axis of the sensor that headings belong to.
    forward: Vector3<f64>,
    kept: Kept,
}

/// What is kept of the solutions that came out.
#[derive(Default)]
struct Kept {
    trajectory: Trajectory,
    newest: Chunk,
    /// Velocity of each row without what its stance tells, for a correction.
    unaided: Option<Vec<Vector3<f64>>>,
}

impl Kept {
    /// Makes room for more solutions.
    ///
    /// All of it is asked for in one piece first.  The C library of Linux gives memory back to the system once twice as much is free as the largest piece that ever came back, and a track whose
    /// columns are given back one by one would have it clear that memory anew for the next track: up to a tenth of the time in threads.
    fn reserve(&mut self, solutions: usize) {
        drop(black_box(Vec::<Solution>::with_capacity(solutions)));
        self.trajectory.reserve(solutions);
        self.unaided.iter_mut().for_each(|unaided| unaided.reserve(solutions));
    }

    /// Takes the navigator's newest solution.
    #[inline]
    fn take(&mut self, navigator: &Navigator) {
        navigator.look_at_latest(|solution| self.newest.push(solution, &mut self.trajectory));
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
        Ok(Self::of(&config.clone(), Navigator::whole(config, rate_hz, None)?))
    }

    /// With a stance detector of one's own; `config.detector` is not used.
    ///
    /// # Errors
    /// [`ConfigError`] for a setting or a rate out of range.
    pub fn with_detector(config: Config, rate_hz: f64, detector: Box<dyn Detector>) -> Result<Self, ConfigError> {
        Ok(Self::of(&config.clone(), Navigator::whole(config, rate_hz, Some(detector))?))
    }

    fn of(config: &Config, navigator: Navigator) -> Self {
        let unaided = (config.correction.kind != CorrectionKind::None).then(Vec::new);
        Self {
            navigator,
            correction: config.correction.kind,
            refines: config.refines(),
            forward: config.alignment.forward_axis.vector(),
            kept: Kept { unaided, ..Kept::default() },
        }
    }

    /// Takes the next block of raw samples.
    ///
    /// # Errors
    /// As [`Navigator::push_block`].
    pub fn push_block(&mut self, block: &[ImuSample]) -> Result<(), Error> {
        self.reserve(block.len());
        self.navigator.follow(block, |navigator| self.kept.take(navigator))
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

    /// Ends the recording: one row per sample, the health of the whole walk, and its strides if `config.output.strides` asks for them.
    ///
    /// A smoother or a correction moves the ends of a stride after the filter cloned their errors: its displacement is that between the rows, its covariance is the filter's, and conservative.
    ///
    /// # Errors
    /// [`DataError::NoField`] when a magnetometer was to hold the heading and was not read, [`DataError::TooShort`] when the start could not be aligned, [`DataError::NoStance`] when there is
    /// nothing to smooth or correct by, and [`crate::error::NumericalError`] when the filter cannot go on.
    pub fn finish(self) -> Result<(Trajectory, Health, Vec<Stride>), Error> {
        self.finish_watched(unwatched)
    }

    /// As [`Batch::finish`]; `watch` is asked every 10,000 samples and can end the work.
    ///
    /// # Errors
    /// That of `watch`, and those of [`Batch::finish`].
    pub fn finish_watched<E: From<Error>>(
        mut self,
        mut watch: impl FnMut() -> Result<(), E>,
    ) -> Result<(Trajectory, Health, Vec<Stride>), E> {
        self.navigator.check_field().map_err(Error::from)?;
        while !self.navigator.go_back(STRETCH)? {
            watch()?;
        }
        while self.navigator.drain()?.is_some() {
            self.kept.take(&self.navigator);
            if self.kept.rows().is_multiple_of(STRETCH) {
                watch()?;
            }
        }
        self.navigator.check_aligned().map_err(Error::from)?;
        let health = self.navigator.health_of_walk();
        if self.refines && health.counters.updates.zero_velocity == 0 {
            return Err(Error::from(DataError::NoStance { samples: health.counters.samples }).into());
        }
        let Kept { trajectory, newest, unaided } = &mut self.kept;
        newest.hand_over(trajectory);
        correction::correct(self.correction, trajectory, unaided.as_deref().unwrap_or_default());
        let strides = self.strides();
        Ok((self.kept.trajectory, health, strides))
    }

    /// The strides between the rows as they are in the end.
    fn strides(&mut self) -> Vec<Stride> {
        let state = |row: usize| self.kept.trajectory.state(row);
        let between =
            |found: Stride| found.measured_again(&state(found.start_row), &state(found.end_row), &self.forward);
        self.navigator.take_strides().into_iter().map(between).filter(Stride::goes_somewhere).collect()
    }
}
