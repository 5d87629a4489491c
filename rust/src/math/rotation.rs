//! Rotation vectors, cross-product matrices and the angles between frames.
//!
//! An attitude is a [`UnitQuaternion`] that turns vectors of the sensor frame b into the navigation
//! frame n (Hamilton convention).

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::math::rotation_kernels;
use crate::math::simd::Baseline;

/// The matrix [v×] with [v×] u = v × u.
#[must_use]
#[inline]
pub fn cross_matrix(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// The rotation by |ρ| about ρ (rad).
///
/// Below half a radian, which a foot turns in no sample interval of 60 Hz or more, a polynomial in
/// |ρ/2|² replaces sine and cosine; its error is below 1e-16 there.
#[must_use]
#[inline]
pub fn exp(rotation_vector: &Vector3<f64>) -> UnitQuaternion<f64> {
    rotation_kernels::exp(Baseline, rotation_vector)
}

/// Yaw of the sensor's `axis` (rad, anticlockwise from n x) and its elevation (rad, up positive).
#[must_use]
pub fn yaw_and_elevation(attitude: &UnitQuaternion<f64>, axis: &Vector3<f64>) -> (f64, f64) {
    let v = attitude * axis;
    (v.y.atan2(v.x), v.z.atan2(v.x.hypot(v.y)))
}

/// The rotation by `angle` (rad) about the up axis of n.
#[must_use]
pub fn about_up(angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
        [-limit..limit, -limit..limit, -limit..limit].prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn exp_is_the_exponential_of_the_cross_matrix(v in vector(3.0)) {
            let series = (1..40).fold((Matrix3::identity(), Matrix3::identity()), |(sum, term), k| {
                let term = term * cross_matrix(&v) / f64::from(k);
                (sum + term, term)
            });
            prop_assert!((exp(&v).to_rotation_matrix().matrix() - series.0).norm() < 1e-12);
        }

        #[test]
        fn exp_of_a_small_vector_has_unit_length(v in vector(0.28)) {
            prop_assert!((exp(&v).into_inner().norm() - 1.0).abs() < 4e-16);
        }

        #[test]
        fn the_logarithm_undoes_exp(v in vector(1.5)) {
            prop_assert!((exp(&v).scaled_axis() - v).norm() < 1e-13);
        }

        #[test]
        fn cross_matrix_is_the_cross_product(u in vector(5.0), v in vector(5.0)) {
            prop_assert!((cross_matrix(&u) * v - u.cross(&v)).norm() < 1e-13);
        }
    }
}
