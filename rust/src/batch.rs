//! A whole recording: what needs its end as well as its beginning.

use nalgebra::Vector3;

use crate::config::{Config, CorrectionKind};
use crate::correction;
use crate::detector::Detector;
use crate::error::{ConfigError, DataError, Error};
use crate::gait::Stride;
use crate::health::Health;
use crate::navigator::Navigator;
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
    trajectory: Trajectory,
    newest: Chunk,
    /// Velocity of each row without what its stance tells; kept for a correction.
    unaided: Vec<Vector3<f64>>,
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
        Self {
            navigator,
            correction: config.correction.kind,
            refines: config.refines(),
            forward: config.alignment.forward_axis.vector(),
            trajectory: Trajectory::default(),
            newest: Chunk::default(),
            unaided: Vec::new(),
        }
    }

    /// Takes the next block of raw samples.
    ///
    /// # Errors
    /// As [`Navigator::push_block`].
    pub fn push_block(&mut self, block: &[ImuSample]) -> Result<(), Error> {
        self.navigator.check_block(block)?;
        self.reserve(block.len());
        for raw in block {
            if self.navigator.advance_checked(raw)? {
                self.keep_latest();
            }
        }
        Ok(())
    }

    /// Makes room for more samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.trajectory.reserve(samples);
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
            self.keep_latest();
            if self.rows().is_multiple_of(STRETCH) {
                watch()?;
            }
        }
        self.newest.hand_over(&mut self.trajectory);
        self.navigator.check_aligned().map_err(Error::from)?;
        let health = self.navigator.health_of_walk();
        if self.refines && health.counters.updates.zero_velocity == 0 {
            return Err(Error::from(DataError::NoStance { samples: health.counters.samples }).into());
        }
        correction::correct(self.correction, &mut self.trajectory, &self.unaided);
        let strides = self.strides();
        Ok((self.trajectory, health, strides))
    }

    /// The strides between the rows as they are in the end.
    fn strides(&mut self) -> Vec<Stride> {
        let state = |row: usize| self.trajectory.state(row);
        let between =
            |found: Stride| found.measured_again(&state(found.start_row), &state(found.end_row), &self.forward);
        self.navigator.take_strides().into_iter().map(between).filter(Stride::goes_somewhere).collect()
    }

    fn rows(&self) -> usize {
        self.trajectory.len() + self.newest.len()
    }

    fn keep_latest(&mut self) {
        if let Some(solution) = self.navigator.latest() {
            self.newest.push(solution, &mut self.trajectory);
        }
        if self.correction != CorrectionKind::None {
            self.unaided.push(self.navigator.unaided_velocity());
        }
    }
}
