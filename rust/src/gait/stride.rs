//! One stride: displacement, heading change and their covariance.

use nalgebra::{Matrix4, UnitQuaternion, Vector3};

use crate::math::rotation;
use crate::types::nav_state::NavState;

/// Minimum displacement of a stride, m; anything less is a shuffle in place.
const MIN_DISPLACEMENT: f64 = 0.05;
/// The default forward axis of the sensor.
pub(crate) const SENSOR_X: Vector3<f64> = Vector3::new(1.0, 0.0, 0.0);

/// The displacement and rotation of the foot from one stance to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Stride {
    /// Row of the start, counted over all solutions.
    pub start_row: usize,
    /// Row of the end.
    pub end_row: usize,
    /// Stamp of the start, s.
    pub start: f64,
    /// Stamp of the end, s.
    pub end: f64,
    /// Displacement from start to end in n, m.
    pub displacement: Vector3<f64>,
    /// Heading of the foot at the start, rad, anticlockwise from n x.
    pub start_heading: f64,
    /// Rotation of the foot about the vertical, rad within (-π, π], positive to the left.
    pub heading_change: f64,
    /// Covariance of displacement (m) and heading change (rad) in the frame of the start heading;
    /// none for a track without a filter.
    pub covariance: Option<Matrix4<f64>>,
}

impl Stride {
    /// The stride between the states of two rows.
    pub(crate) fn between(
        rows: (usize, usize),
        start: &NavState,
        end: &NavState,
        forward: &Vector3<f64>,
    ) -> Self {
        Self {
            start_row: rows.0,
            end_row: rows.1,
            start: start.time,
            end: end.time,
            displacement: end.position - start.position,
            start_heading: wrapped(rotation::yaw_and_elevation(&start.attitude, forward).0),
            heading_change: heading_change(&start.attitude, &end.attitude),
            covariance: None,
        }
    }

    /// The same stride between states that have been smoothed since.
    pub(crate) fn measured_again(
        &self,
        start: &NavState,
        end: &NavState,
        forward: &Vector3<f64>,
    ) -> Self {
        let covariance = self.covariance;
        Self { covariance, ..Self::between((self.start_row, self.end_row), start, end, forward) }
    }

    /// Adds the covariance, from the pose covariances at both ends and the cross-covariance of end
    /// and start.
    pub(crate) fn with_covariance(
        self,
        start: &Matrix4<f64>,
        end: &Matrix4<f64>,
        cross: &Matrix4<f64>,
    ) -> Self {
        let turn = *rotation::about_up(-self.start_heading).to_rotation_matrix().matrix();
        let g_e = turn.to_homogeneous();
        let mut g_s = g_e;
        let quarter = Vector3::new(-self.displacement.y, self.displacement.x, 0.0);
        g_s.fixed_view_mut::<3, 1>(0, 3).copy_from(&(turn * quarter));
        let both = g_e * cross * g_s.transpose();
        let covariance =
            g_e * end * g_e.transpose() + g_s * start * g_s.transpose() - both - both.transpose();
        Self { covariance: Some(0.5 * (covariance + covariance.transpose())), ..self }
    }

    /// Whether the displacement exceeds a shuffle in place.
    #[must_use]
    pub fn is_displaced(&self) -> bool {
        let displacement = &self.displacement;
        displacement.x.hypot(displacement.y) >= MIN_DISPLACEMENT
            || displacement.z.abs() >= MIN_DISPLACEMENT
    }

    /// Whether the stride starts or ends in `row`.
    pub(crate) fn touches(&self, row: usize) -> bool {
        self.start_row == row || self.end_row == row
    }
}

/// Rotation about the vertical between two attitudes, rad within (-π, π], for any mounting of the
/// sensor: `2 atan2(q_z, q_w)` of q = after before⁻¹.
fn heading_change(before: &UnitQuaternion<f64>, after: &UnitQuaternion<f64>) -> f64 {
    let turn = after * before.inverse();
    wrapped(2.0 * turn.k.atan2(turn.w))
}

/// The angle wrapped to (-π, π].
fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    PI - (PI - angle).rem_euclid(TAU)
}

#[cfg(test)]
mod tests {
    use nalgebra::{SMatrix, SVector, Vector4};
    use proptest::prelude::*;

    use super::*;

    type Dense = SMatrix<f64, 8, 8>;

    /// Position and heading at the start, then at the end.
    type Ends = SVector<f64, 8>;

    fn ends() -> impl Strategy<Value = Ends> {
        prop::collection::vec(-2.0..2.0, 8).prop_map(|values| Ends::from_column_slice(&values))
    }

    fn covariances() -> impl Strategy<Value = Dense> {
        prop::collection::vec(-1.0..1.0, 64).prop_map(|values| {
            let a = Dense::from_column_slice(&values);
            a * a.transpose()
        })
    }

    fn state(ends: &Ends, first: usize) -> NavState {
        let position = ends.fixed_rows::<3>(first).into_owned();
        NavState { position, ..NavState::at_rest(0.0, rotation::about_up(ends[first + 3])) }
    }

    fn stride(ends: &Ends, p: &Dense) -> Stride {
        let part = |row, column| p.fixed_view::<4, 4>(row, column).into_owned();
        let stride = Stride::between((0, 1), &state(ends, 0), &state(ends, 4), &SENSOR_X);
        stride.with_covariance(&part(0, 0), &part(4, 4), &part(4, 0))
    }

    /// Displacement and heading change in the frame of the stride.
    fn local(ends: &Ends) -> Vector4<f64> {
        let displacement = ends.fixed_rows::<3>(4) - ends.fixed_rows::<3>(0);
        (rotation::about_up(-ends[3]) * displacement).push(ends[7] - ends[3])
    }

    fn covariance(stride: &Stride) -> Matrix4<f64> {
        stride.covariance.unwrap()
    }

    proptest! {
        #[test]
        fn covariance_equals_that_of_the_linearized_displacement(
            ends in ends(), p in covariances(),
        ) {
            let mut jacobian = SMatrix::<f64, 4, 8>::zeros();
            for k in 0..8 {
                let mut nudge = Ends::zeros();
                nudge[k] = 1e-4;
                jacobian.set_column(k, &((local(&(ends + nudge)) - local(&(ends - nudge))) / 2e-4));
            }
            let expected = jacobian * p * jacobian.transpose();
            let found = covariance(&stride(&ends, &p));
            prop_assert!((found - expected).norm() < 1e-6 * (1.0 + expected.norm()));
            prop_assert_eq!(found, found.transpose());
        }

        #[test]
        fn covariance_is_invariant_to_rotation_and_translation_of_n(
            ends in ends(), p in covariances(), angle in -3.0..3.0,
            shift in [-9.0..9.0, -9.0..9.0, -9.0..9.0],
        ) {
            let turn = *rotation::about_up(angle).to_rotation_matrix().matrix();
            let mut both = Dense::identity();
            both.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
            both.fixed_view_mut::<3, 3>(4, 4).copy_from(&turn);
            let mut moved = both * ends;
            for first in [0, 4] {
                (0..3).for_each(|axis| moved[first + axis] += shift[axis]);
                moved[first + 3] += angle;
            }
            let (here, there) = (stride(&ends, &p), stride(&moved, &(both * p * both.transpose())));
            let difference = covariance(&here) - covariance(&there);
            prop_assert!(difference.norm() < 1e-10 * (1.0 + p.norm()));
            let shift = turn * here.displacement - there.displacement;
            prop_assert!(shift.norm() < 1e-12 * (1.0 + moved.norm()));
        }
    }

    #[test]
    fn common_errors_of_both_ends_cancel() {
        let ends = Ends::from_column_slice(&[3.0, -2.0, 1.0, 0.4, 3.0, -2.0, 1.0, 1.4]);
        let p = Dense::repeat(4.0);
        assert!(covariance(&stride(&ends, &p)).norm() < 1e-14);
    }
}
