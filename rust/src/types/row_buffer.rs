//! The newest rows of a trajectory, on their way into its columns.

use crate::types::health::Flags;
use crate::types::solution::Solution;
use crate::types::trajectory::Trajectory;

/// Block3 that a chunk holds.
const ROWS: usize = 64;

/// Takes rows one by one and hands them over by the chunk, so that each column is asked for room
/// once per chunk.
#[derive(Clone, Debug)]
pub(crate) struct RowBuffer {
    rows: usize,
    time: [f64; ROWS],
    position: [[f64; 3]; ROWS],
    velocity: [[f64; 3]; ROWS],
    quaternion: [[f64; 4]; ROWS],
    zero_velocity: [bool; ROWS],
    position_std: [[f64; 3]; ROWS],
    gyro_bias: [[f64; 3]; ROWS],
    accel_bias: [[f64; 3]; ROWS],
    flags: [Flags; ROWS],
}

impl Default for RowBuffer {
    fn default() -> Self {
        let vectors = [[0.0; 3]; ROWS];
        Self {
            rows: 0,
            time: [0.0; ROWS],
            position: vectors,
            velocity: vectors,
            quaternion: [[0.0; 4]; ROWS],
            zero_velocity: [false; ROWS],
            position_std: vectors,
            gyro_bias: vectors,
            accel_bias: vectors,
            flags: [Flags::empty(); ROWS],
        }
    }
}

impl RowBuffer {
    /// Takes one solution; a full chunk goes into the trajectory.
    #[inline]
    pub(crate) fn push(&mut self, solution: &Solution, trajectory: &mut Trajectory) {
        let (at, estimate) = (self.rows % ROWS, &solution.estimate);
        self.time[at] = estimate.nav.time;
        self.position[at] = estimate.nav.position.into();
        self.velocity[at] = estimate.nav.velocity.into();
        self.quaternion[at] = estimate.nav.attitude.coords.into();
        self.zero_velocity[at] = solution.zero_velocity;
        self.position_std[at] = solution.position_std.into();
        self.gyro_bias[at] = estimate.gyro_bias.into();
        self.accel_bias[at] = estimate.accel_bias.into();
        self.flags[at] = solution.flags;
        self.rows = at + 1;
        if self.rows == ROWS {
            self.flush(trajectory);
        }
    }

    /// Number of rows that are not appended.
    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.rows
    }

    /// Appends the rows to a trajectory.
    pub(crate) fn flush(&mut self, trajectory: &mut Trajectory) {
        let rows = std::mem::take(&mut self.rows);
        trajectory.time.extend_from_slice(&self.time[..rows]);
        trajectory.position.extend_from_slice(&self.position[..rows]);
        trajectory.velocity.extend_from_slice(&self.velocity[..rows]);
        trajectory.quaternion.extend_from_slice(&self.quaternion[..rows]);
        trajectory.zero_velocity.extend_from_slice(&self.zero_velocity[..rows]);
        trajectory.position_std.extend_from_slice(&self.position_std[..rows]);
        trajectory.gyro_bias.extend_from_slice(&self.gyro_bias[..rows]);
        trajectory.accel_bias.extend_from_slice(&self.accel_bias[..rows]);
        trajectory.flags.extend_from_slice(&self.flags[..rows]);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::types::nav_state::NavState;
    use crate::types::solution::Estimate;

    /// A solution of which no two numbers are the same.
    fn solution(row: u16) -> Solution {
        let number = f64::from(row);
        let vector = |k: f64| Vector3::new(number + k, number - k, number * k);
        let nav = NavState {
            time: number,
            position: vector(0.1),
            velocity: vector(0.2),
            attitude: UnitQuaternion::from_scaled_axis(vector(0.3)),
        };
        Solution {
            estimate: Estimate { nav, gyro_bias: vector(0.4), accel_bias: vector(0.5) },
            position_std: vector(0.6),
            zero_velocity: row.is_multiple_of(3),
            flags: Flags::from_bits_truncate(row),
        }
    }

    #[test]
    fn rows_that_went_through_chunks_are_those_pushed_one_by_one() {
        for rows in [0, 1, 63, 64, 65, 200] {
            let (mut chunk, mut by_chunks, mut one_by_one) =
                (RowBuffer::default(), Trajectory::default(), Trajectory::default());
            for solution in (0..rows).map(solution) {
                chunk.push(&solution, &mut by_chunks);
                one_by_one.push(&solution);
                assert_eq!(by_chunks.len() + chunk.len(), one_by_one.len());
            }
            chunk.flush(&mut by_chunks);
            assert_eq!((by_chunks, chunk.len()), (one_by_one, 0));
        }
    }
}
