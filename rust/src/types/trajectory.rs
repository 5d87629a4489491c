//! Solutions, column by column.

use nalgebra::UnitQuaternion;

use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::solution::Solution;

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
    pub flags: Vec<Flags>,
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
            flags: Vec::with_capacity(rows),
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
        self.flags.reserve(rows);
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
        self.flags.push(solution.flags);
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
        self.flags.append(&mut other.flags);
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
