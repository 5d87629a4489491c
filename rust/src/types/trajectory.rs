//! Solutions as columns.

use nalgebra::UnitQuaternion;

use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::solution::Solution;

/// Number of rows that are buffered before they are appended to the columns.
const BUFFERED_ROWS: usize = 64;

/// Defines the columns once: for each its documentation, name, type, and how a row follows from a
/// solution.
macro_rules! columns {
    ($($(#[$doc:meta])* $name:ident: $kind:ty = $row:expr, $empty:expr;)+) => {
        /// Solutions as columns, one row per sample.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Trajectory {
            $($(#[$doc])* pub $name: Vec<$kind>,)+
        }

        impl Trajectory {
            /// An empty trajectory with memory for `rows`.
            #[must_use]
            pub fn with_capacity(rows: usize) -> Self {
                Self { $($name: Vec::with_capacity(rows),)+ }
            }

            /// Reserves memory for more rows.
            pub(crate) fn reserve(&mut self, rows: usize) {
                $(self.$name.reserve(rows);)+
            }

            /// Appends one solution.
            pub fn push(&mut self, solution: &Solution) {
                $(self.$name.push($row(solution));)+
            }

            /// Appends the rows of another trajectory.
            pub fn append(&mut self, mut other: Self) {
                $(self.$name.append(&mut other.$name);)+
            }
        }

        /// Buffers rows, so that the columns grow once for many rows.
        #[derive(Clone, Debug)]
        pub(crate) struct RowBuffer {
            rows: usize,
            $($name: [$kind; BUFFERED_ROWS],)+
        }

        impl Default for RowBuffer {
            fn default() -> Self {
                Self { rows: 0, $($name: [$empty; BUFFERED_ROWS],)+ }
            }
        }

        impl RowBuffer {
            /// Takes one solution; a full buffer is appended to the trajectory.
            #[inline]
            pub(crate) fn push(&mut self, solution: &Solution, trajectory: &mut Trajectory) {
                let at = self.rows % BUFFERED_ROWS;
                $(self.$name[at] = $row(solution);)+
                self.rows = at + 1;
                if self.rows == BUFFERED_ROWS {
                    self.flush(trajectory);
                }
            }

            /// Appends the buffered rows to a trajectory.
            pub(crate) fn flush(&mut self, trajectory: &mut Trajectory) {
                let rows = std::mem::take(&mut self.rows);
                $(trajectory.$name.extend_from_slice(&self.$name[..rows]);)+
            }
        }
    };
}

columns! {
    /// Stamps, s.
    time: f64 = |s: &Solution| s.estimate.nav.time, 0.0;
    /// Position in n, m.
    position: [f64; 3] = |s: &Solution| s.estimate.nav.position.into(), [0.0; 3];
    /// Velocity in n, m/s.
    velocity: [f64; 3] = |s: &Solution| s.estimate.nav.velocity.into(), [0.0; 3];
    /// Rotation from the sensor frame to n, scalar last.
    quaternion: [f64; 4] = |s: &Solution| s.estimate.nav.attitude.coords.into(), [0.0; 4];
    /// Whether the foot is in stance.
    zero_velocity: bool = |s: &Solution| s.zero_velocity, false;
    /// One-sigma position uncertainty in n, m.
    position_std: [f64; 3] = |s: &Solution| s.position_std.into(), [0.0; 3];
    /// Gyroscope bias, rad/s.
    gyro_bias: [f64; 3] = |s: &Solution| s.estimate.gyro_bias.into(), [0.0; 3];
    /// Accelerometer bias, m/s².
    accel_bias: [f64; 3] = |s: &Solution| s.estimate.accel_bias.into(), [0.0; 3];
    /// Quality flags.
    flags: Flags = |s: &Solution| s.flags, Flags::empty();
}

impl Trajectory {
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

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
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
    fn buffered_rows_equal_rows_pushed_one_by_one() {
        for rows in [0, 1, 63, 64, 65, 200] {
            let (mut buffer, mut buffered, mut one_by_one) =
                (RowBuffer::default(), Trajectory::default(), Trajectory::default());
            for solution in (0..rows).map(solution) {
                buffer.push(&solution, &mut buffered);
                one_by_one.push(&solution);
                assert_eq!(buffered.len() + buffer.rows, one_by_one.len());
            }
            buffer.flush(&mut buffered);
            assert_eq!((buffered, buffer.rows), (one_by_one, 0));
        }
    }
}
