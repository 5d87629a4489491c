//! Rotations by fused multiply-adds, where the instruction set has them.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::math::simd::Simd;

/// Square of half an angle up to which a polynomial replaces sine and cosine.
const SMALL: f64 = 0.0625;

/// `a × b`.
#[inline(always)]
pub(crate) fn cross<S: Simd>(simd: S, a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        simd.mul_add(a.y, b.z, -a.z * b.y),
        simd.mul_add(a.z, b.x, -a.x * b.z),
        simd.mul_add(a.x, b.y, -a.y * b.x),
    )
}

/// `c + a × b`.
#[inline(always)]
pub(crate) fn add_cross<S: Simd>(
    simd: S,
    c: &Vector3<f64>,
    a: &Vector3<f64>,
    b: &Vector3<f64>,
) -> Vector3<f64> {
    Vector3::new(
        simd.mul_add(a.y, b.z, simd.mul_add(-a.z, b.y, c.x)),
        simd.mul_add(a.z, b.x, simd.mul_add(-a.x, b.z, c.y)),
        simd.mul_add(a.x, b.y, simd.mul_add(-a.y, b.x, c.z)),
    )
}

/// `c + a b`.
#[inline(always)]
pub(crate) fn add_scaled<S: Simd>(
    simd: S,
    c: &Vector3<f64>,
    a: f64,
    b: &Vector3<f64>,
) -> Vector3<f64> {
    Vector3::new(simd.mul_add(a, b.x, c.x), simd.mul_add(a, b.y, c.y), simd.mul_add(a, b.z, c.z))
}

/// `m + c [v×]`.
#[inline(always)]
pub(crate) fn add_cross_matrix_product<S: Simd>(
    simd: S,
    m: &Matrix3<f64>,
    c: &Matrix3<f64>,
    v: &Vector3<f64>,
) -> Matrix3<f64> {
    let a =
        add_cross(simd, &Vector3::new(m.m11, m.m12, m.m13), &Vector3::new(c.m11, c.m12, c.m13), v);
    let b =
        add_cross(simd, &Vector3::new(m.m21, m.m22, m.m23), &Vector3::new(c.m21, c.m22, c.m23), v);
    let c =
        add_cross(simd, &Vector3::new(m.m31, m.m32, m.m33), &Vector3::new(c.m31, c.m32, c.m33), v);
    Matrix3::new(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z)
}

/// `q v q*`.
#[inline(always)]
pub(crate) fn rotate<S: Simd>(simd: S, q: &UnitQuaternion<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let axis = Vector3::new(q.i, q.j, q.k);
    let moved = cross(simd, &axis, &(2.0 * v));
    add_cross(simd, &add_scaled(simd, v, q.w, &moved), &axis, &moved)
}

/// `q exp(ρ)`: the attitude after a rotation by |ρ| about ρ (rad) in b.
#[inline(always)]
pub(crate) fn rotate_in_body<S: Simd>(
    simd: S,
    q: &UnitQuaternion<f64>,
    rotation_vector: &Vector3<f64>,
) -> UnitQuaternion<f64> {
    let half = 0.5 * rotation_vector;
    let axis = Vector3::new(q.i, q.j, q.k);
    compose(simd, q, &half, &add_cross(simd, &(q.w * half), &axis, &half))
}

/// `exp(ρ) q`: the attitude after a rotation by |ρ| about ρ (rad) in n.
#[inline(always)]
pub(crate) fn rotate_in_nav<S: Simd>(
    simd: S,
    q: &UnitQuaternion<f64>,
    rotation_vector: &Vector3<f64>,
) -> UnitQuaternion<f64> {
    let half = 0.5 * rotation_vector;
    let axis = Vector3::new(q.i, q.j, q.k);
    compose(simd, q, &half, &add_cross(simd, &(q.w * half), &half, &axis))
}

/// `q cos |h| + q' sin |h| / |h|`, where q' is the product of q and h, and its vector needs not
/// wait for sine and cosine.
#[inline(always)]
fn compose<S: Simd>(
    simd: S,
    q: &UnitQuaternion<f64>,
    half: &Vector3<f64>,
    vector_of_product: &Vector3<f64>,
) -> UnitQuaternion<f64> {
    let (cos, sinc) = cos_and_sinc(simd, half);
    let scalar_of_product = simd.mul_add(q.i, half.x, simd.mul_add(q.j, half.y, q.k * half.z));
    UnitQuaternion::new_unchecked(Quaternion::new(
        simd.mul_add(-sinc, scalar_of_product, cos * q.w),
        simd.mul_add(sinc, vector_of_product.x, cos * q.i),
        simd.mul_add(sinc, vector_of_product.y, cos * q.j),
        simd.mul_add(sinc, vector_of_product.z, cos * q.k),
    ))
}

/// The matrix of a rotation.
#[inline(always)]
pub(crate) fn matrix<S: Simd>(simd: S, q: &UnitQuaternion<f64>) -> Matrix3<f64> {
    let (x, y, z, w) = (q.i, q.j, q.k, q.w);
    let (x2, y2, z2) = (2.0 * x, 2.0 * y, 2.0 * z);
    let (xy, xz, yz) = (x2 * y, x2 * z, y2 * z);
    Matrix3::new(
        simd.mul_add(-y2, y, simd.mul_add(-z2, z, 1.0)),
        simd.mul_add(-z2, w, xy),
        simd.mul_add(y2, w, xz),
        simd.mul_add(z2, w, xy),
        simd.mul_add(-x2, x, simd.mul_add(-z2, z, 1.0)),
        simd.mul_add(-x2, w, yz),
        simd.mul_add(-y2, w, xz),
        simd.mul_add(x2, w, yz),
        simd.mul_add(-x2, x, simd.mul_add(-y2, y, 1.0)),
    )
}

/// The rotation by |ρ| about ρ (rad): see [`super::exp`].
#[inline(always)]
pub(crate) fn exp<S: Simd>(simd: S, rotation_vector: &Vector3<f64>) -> UnitQuaternion<f64> {
    let half = 0.5 * rotation_vector;
    let (cos, sinc) = cos_and_sinc(simd, &half);
    UnitQuaternion::new_unchecked(Quaternion::new(cos, sinc * half.x, sinc * half.y, sinc * half.z))
}

/// Cosine of |h| and its sine over |h|.
#[inline(always)]
fn cos_and_sinc<S: Simd>(simd: S, half: &Vector3<f64>) -> (f64, f64) {
    let x = simd.mul_add(half.x, half.x, half.y * half.y) + half.z * half.z;
    if x > SMALL {
        return cos_and_sinc_of_large(x);
    }
    let sinc = polynomial(
        simd,
        x,
        [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5_040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0, 0.0],
    );
    let cos = polynomial(
        simd,
        x,
        [
            1.0,
            -0.5,
            1.0 / 24.0,
            -1.0 / 720.0,
            1.0 / 40_320.0,
            -1.0 / 3_628_800.0,
            1.0 / 479_001_600.0,
        ],
    );
    (cos, sinc)
}

/// Estrin's scheme; the coefficients are in the order of the powers.
#[inline(always)]
fn polynomial<S: Simd>(simd: S, x: f64, [a, b, c, d, e, f, g]: [f64; 7]) -> f64 {
    let y = x * x;
    let low = simd.mul_add(y, simd.mul_add(x, d, c), simd.mul_add(x, b, a));
    let high = simd.mul_add(y, g, simd.mul_add(x, f, e));
    simd.mul_add(y * y, high, low)
}

#[cold]
fn cos_and_sinc_of_large(x: f64) -> (f64, f64) {
    let angle = x.sqrt();
    (angle.cos(), angle.sin() / angle)
}

/// The quaternion brought back to unit length by one Newton step, which is exact to rounding for
/// one that has drifted by less than 1e-8.
#[inline(always)]
pub(crate) fn renormalize<S: Simd>(simd: S, q: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let (x, y, z, w) = (q.i, q.j, q.k, q.w);
    let square = simd.mul_add(x, x, y * y) + simd.mul_add(z, z, w * w);
    UnitQuaternion::new_unchecked(q.into_inner() * simd.mul_add(-0.5, square, 1.5))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::rotation::cross_matrix;
    use crate::math::simd::{Baseline, on_best_instruction_set};

    /// Rotates the attitude by the vector in b and in n, and takes `m + c [v×]` of their matrices.
    fn rotations<S: Simd>(
        simd: S,
        attitude: &UnitQuaternion<f64>,
        vector: &Vector3<f64>,
    ) -> (UnitQuaternion<f64>, UnitQuaternion<f64>, Matrix3<f64>) {
        let before = rotate_in_body(simd, attitude, vector);
        let (m, c) = (matrix(simd, &before), matrix(simd, attitude));
        let sum = add_cross_matrix_product(simd, &m, &c, vector);
        (before, rotate_in_nav(simd, attitude, vector), sum)
    }

    fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
        [-limit..limit, -limit..limit, -limit..limit].prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn rotations_are_products_with_the_exponential_on_any_instruction_set(
            attitude in vector(3.0),
            vector in prop_oneof![vector(0.01), vector(0.5), vector(3.0)],
        ) {
            let attitude = UnitQuaternion::from_scaled_axis(attitude);
            let turn = UnitQuaternion::from_scaled_axis(vector);
            let best = on_best_instruction_set!(simd => rotations(simd, &attitude, &vector));
            for (before, after, sum) in [best, rotations(Baseline, &attitude, &vector)] {
                prop_assert!((before.coords - (attitude * turn).coords).norm() < 4e-15);
                prop_assert!((after.coords - (turn * attitude).coords).norm() < 4e-15);
                let [m, c] = [before, attitude].map(|q| q.to_rotation_matrix().into_inner());
                prop_assert!((sum - (m + c * cross_matrix(&vector))).norm() < 4e-14);
            }
        }

        #[test]
        fn renormalize_restores_unit_length(vector in vector(1.0), stretch in -1e-8..1e-8) {
            let unit = UnitQuaternion::from_scaled_axis(vector);
            let drifted = UnitQuaternion::new_unchecked(unit.into_inner() * (1.0 + stretch));
            prop_assert!((renormalize(Baseline, &drifted).into_inner().norm() - 1.0).abs() < 1e-15);
        }
    }
}
