//! Solutions, column by column.

use nalgebra::UnitQuaternion;

use crate::batch::Batch;
use crate::config::Config;
use crate::error::{DataError, Error};
use crate::health::{Health, Reasons};
use crate::navigator::Solution;
use crate::sample::ImuSample;
use crate::strapdown::NavState;

mod chunk;

pub(crate) use chunk::Chunk;

/// A run of solutions, one row per sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectory {
    /// Stamps, s.
    pub time: Vec<f64>,
    /// Position in n, m.
    pub position: Vec<[f64; 3]>,
    /// Velocity in n, m/s.
    pub velocity: Vec<[f64; 3]>,
    /// Rotation from the sensor frame to n, scalar last.
    pub quaternion: Vec<[f64; 4]>,
    /// Whether the foot was at rest on the ground.
    pub zero_velocity: Vec<bool>,
    /// One-sigma position uncertainty in n, m.
    pub position_std: Vec<[f64; 3]>,
    /// Gyroscope bias, rad/s.
    pub gyro_bias: Vec<[f64; 3]>,
    /// Accelerometer bias, m/s².
    pub accel_bias: Vec<[f64; 3]>,
    /// What speaks against each row.
    pub reasons: Vec<Reasons>,
}

impl Trajectory {
    /// An empty trajectory with room for `rows`.
    #[must_use]
    pub fn with_capacity(rows: usize) -> Self {
        Self {
            time: Vec::with_capacity(rows),
            position: Vec::with_capacity(rows),
            velocity: Vec::with_capacity(rows),
            quaternion: Vec::with_capacity(rows),
            zero_velocity: Vec::with_capacity(rows),
            position_std: Vec::with_capacity(rows),
            gyro_bias: Vec::with_capacity(rows),
            accel_bias: Vec::with_capacity(rows),
            reasons: Vec::with_capacity(rows),
        }
    }

    /// Makes room for more rows.
    pub(crate) fn reserve(&mut self, rows: usize) {
        self.time.reserve(rows);
        self.position.reserve(rows);
        self.velocity.reserve(rows);
        self.quaternion.reserve(rows);
        self.zero_velocity.reserve(rows);
        self.position_std.reserve(rows);
        self.gyro_bias.reserve(rows);
        self.accel_bias.reserve(rows);
        self.reasons.reserve(rows);
    }

    /// Appends one solution.
    pub fn push(&mut self, solution: &Solution) {
        let estimate = &solution.estimate;
        self.time.push(estimate.nav.time);
        self.position.push(estimate.nav.position.into());
        self.velocity.push(estimate.nav.velocity.into());
        self.quaternion.push(estimate.nav.attitude.coords.into());
        self.zero_velocity.push(solution.zero_velocity);
        self.position_std.push(solution.position_std.into());
        self.gyro_bias.push(estimate.gyro_bias.into());
        self.accel_bias.push(estimate.accel_bias.into());
        self.reasons.push(solution.reasons);
    }

    /// Appends the rows of another trajectory.
    pub fn append(&mut self, mut other: Self) {
        self.time.append(&mut other.time);
        self.position.append(&mut other.position);
        self.velocity.append(&mut other.velocity);
        self.quaternion.append(&mut other.quaternion);
        self.zero_velocity.append(&mut other.zero_velocity);
        self.position_std.append(&mut other.position_std);
        self.gyro_bias.append(&mut other.gyro_bias);
        self.accel_bias.append(&mut other.accel_bias);
        self.reasons.append(&mut other.reasons);
    }

    /// The state in a row.
    pub(crate) fn state(&self, row: usize) -> NavState {
        NavState {
            time: self.time[row],
            position: self.position[row].into(),
            velocity: self.velocity[row].into(),
            attitude: UnitQuaternion::new_unchecked(self.quaternion[row].into()),
        }
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }
}

impl Extend<Solution> for Trajectory {
    fn extend<T: IntoIterator<Item = Solution>>(&mut self, solutions: T) {
        for solution in solutions {
            self.push(&solution);
        }
    }
}

/// Tracks a whole recording: one row per sample, and the health of the whole walk.
///
/// # Errors
/// [`crate::error::ConfigError`] for a setting out of range, [`DataError`] for samples that cannot be used or are too few,
/// [`crate::error::NumericalError`] when the filter cannot go on.
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

/// Samples per second: the inverse of the median of the intervals that are not zero; none when there is no such interval.
#[must_use]
pub fn sample_rate(samples: &[ImuSample]) -> Option<f64> {
    let intervals = samples.windows(2).map(|pair| pair[1].time - pair[0].time).filter(|&interval| interval > 0.0);
    // Positive numbers are in the order of their bits, which are compared with less work.
    let mut intervals: Vec<u64> = intervals.map(f64::to_bits).collect();
    let middle = intervals.len() / 2;
    if intervals.is_empty() {
        return None;
    }
    let even = intervals.len().is_multiple_of(2);
    let (below, &mut upper, _) = intervals.select_nth_unstable(middle);
    let lower = if even { below.iter().copied().fold(0, u64::max) } else { upper };
    Some(2.0 / (f64::from_bits(lower) + f64::from_bits(upper)))
}
