//! Rotations in as few operations as the lanes allow: a multiplication and the addition after it
//! are one where the processor has that.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::math::simd::Lanes;

/// Square of half an angle up to which a polynomial replaces sine and cosine.
const SMALL: f64 = 0.0625;

/// `a × b`.
#[inline(always)]
pub(crate) fn cross<L: Lanes>(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        L::fused(a.y, b.z, -a.z * b.y),
        L::fused(a.z, b.x, -a.x * b.z),
        L::fused(a.x, b.y, -a.y * b.x),
    )
}

/// `c + a × b`.
#[inline(always)]
pub(crate) fn plus_cross<L: Lanes>(
    c: &Vector3<f64>,
    a: &Vector3<f64>,
    b: &Vector3<f64>,
) -> Vector3<f64> {
    Vector3::new(
        L::fused(a.y, b.z, L::fused(-a.z, b.y, c.x)),
        L::fused(a.z, b.x, L::fused(-a.x, b.z, c.y)),
        L::fused(a.x, b.y, L::fused(-a.y, b.x, c.z)),
    )
}

/// `c + a b`.
#[inline(always)]
pub(crate) fn plus_scaled<L: Lanes>(c: &Vector3<f64>, a: f64, b: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(L::fused(a, b.x, c.x), L::fused(a, b.y, c.y), L::fused(a, b.z, c.z))
}

/// `m + c [v×]`.
#[inline(always)]
pub(crate) fn plus_times_cross_matrix<L: Lanes>(
    m: &Matrix3<f64>,
    c: &Matrix3<f64>,
    v: &Vector3<f64>,
) -> Matrix3<f64> {
    let a =
        plus_cross::<L>(&Vector3::new(m.m11, m.m12, m.m13), &Vector3::new(c.m11, c.m12, c.m13), v);
    let b =
        plus_cross::<L>(&Vector3::new(m.m21, m.m22, m.m23), &Vector3::new(c.m21, c.m22, c.m23), v);
    let c =
        plus_cross::<L>(&Vector3::new(m.m31, m.m32, m.m33), &Vector3::new(c.m31, c.m32, c.m33), v);
    Matrix3::new(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z)
}

/// `q v q*`.
#[inline(always)]
pub(crate) fn rotate<L: Lanes>(q: &UnitQuaternion<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let axis = Vector3::new(q.i, q.j, q.k);
    let moved = cross::<L>(&axis, &(2.0 * v));
    plus_cross::<L>(&plus_scaled::<L>(v, q.w, &moved), &axis, &moved)
}

/// `q exp(ρ)`: a turn by |ρ| about ρ (rad) in the frame that q leads from.
#[inline(always)]
pub(crate) fn turn_before<L: Lanes>(
    q: &UnitQuaternion<f64>,
    rotation_vector: &Vector3<f64>,
) -> UnitQuaternion<f64> {
    let half = 0.5 * rotation_vector;
    let axis = Vector3::new(q.i, q.j, q.k);
    part_way::<L>(q, &half, &plus_cross::<L>(&(q.w * half), &axis, &half))
}

/// `exp(ρ) q`: a turn by |ρ| about ρ (rad) in the frame that q leads to.
#[inline(always)]
pub(crate) fn turn_after<L: Lanes>(
    q: &UnitQuaternion<f64>,
    rotation_vector: &Vector3<f64>,
) -> UnitQuaternion<f64> {
    let half = 0.5 * rotation_vector;
    let axis = Vector3::new(q.i, q.j, q.k);
    part_way::<L>(q, &half, &plus_cross::<L>(&(q.w * half), &half, &axis))
}

/// `q cos |h| + q' sin |h| / |h|`, where q' is the product of q and h, and its vector needs not
/// wait for sine and cosine.
#[inline(always)]
fn part_way<L: Lanes>(
    q: &UnitQuaternion<f64>,
    half: &Vector3<f64>,
    vector_of_product: &Vector3<f64>,
) -> UnitQuaternion<f64> {
    let (cos, sinc) = cos_and_sinc::<L>(half);
    let scalar_of_product = L::fused(q.i, half.x, L::fused(q.j, half.y, q.k * half.z));
    UnitQuaternion::new_unchecked(Quaternion::new(
        L::fused(-sinc, scalar_of_product, cos * q.w),
        L::fused(sinc, vector_of_product.x, cos * q.i),
        L::fused(sinc, vector_of_product.y, cos * q.j),
        L::fused(sinc, vector_of_product.z, cos * q.k),
    ))
}

/// The matrix of a rotation.
#[inline(always)]
pub(crate) fn matrix<L: Lanes>(q: &UnitQuaternion<f64>) -> Matrix3<f64> {
    let (x, y, z, w) = (q.i, q.j, q.k, q.w);
    let (x2, y2, z2) = (2.0 * x, 2.0 * y, 2.0 * z);
    let (xy, xz, yz) = (x2 * y, x2 * z, y2 * z);
    Matrix3::new(
        L::fused(-y2, y, L::fused(-z2, z, 1.0)),
        L::fused(-z2, w, xy),
        L::fused(y2, w, xz),
        L::fused(z2, w, xy),
        L::fused(-x2, x, L::fused(-z2, z, 1.0)),
        L::fused(-x2, w, yz),
        L::fused(-y2, w, xz),
        L::fused(x2, w, yz),
        L::fused(-x2, x, L::fused(-y2, y, 1.0)),
    )
}

/// The rotation by |ρ| about ρ (rad): see [`super::exp`].
#[inline(always)]
pub(crate) fn exp<L: Lanes>(rotation_vector: &Vector3<f64>) -> UnitQuaternion<f64> {
    let half = 0.5 * rotation_vector;
    let (cos, sinc) = cos_and_sinc::<L>(&half);
    UnitQuaternion::new_unchecked(Quaternion::new(cos, sinc * half.x, sinc * half.y, sinc * half.z))
}

/// Cosine of |h| and its sine over |h|.
#[inline(always)]
fn cos_and_sinc<L: Lanes>(half: &Vector3<f64>) -> (f64, f64) {
    let x = L::fused(half.x, half.x, half.y * half.y) + half.z * half.z;
    if x > SMALL {
        return cos_and_sinc_of_large(x);
    }
    let sinc = polynomial::<L>(
        x,
        [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5_040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0, 0.0],
    );
    let cos = polynomial::<L>(
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

/// Estrin's scheme; the coefficients come in the order of the powers.
#[inline(always)]
fn polynomial<L: Lanes>(x: f64, [a, b, c, d, e, f, g]: [f64; 7]) -> f64 {
    let y = x * x;
    let low = L::fused(y, L::fused(x, d, c), L::fused(x, b, a));
    let high = L::fused(y, g, L::fused(x, f, e));
    L::fused(y * y, high, low)
}

#[cold]
fn cos_and_sinc_of_large(x: f64) -> (f64, f64) {
    let angle = x.sqrt();
    (angle.cos(), angle.sin() / angle)
}

/// The quaternion brought back to unit length by one Newton step, which is exact to rounding for
/// one that has drifted by less than 1e-8.
#[inline(always)]
pub(crate) fn renormalize<L: Lanes>(q: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let (x, y, z, w) = (q.i, q.j, q.k, q.w);
    let square = L::fused(x, x, y * y) + L::fused(z, z, w * w);
    UnitQuaternion::new_unchecked(q.into_inner() * L::fused(-0.5, square, 1.5))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::rotation::cross_matrix;
    use crate::math::simd::{Baseline, Work, dispatch};

    /// Turns the attitude before and after by the vector, and takes `m + c [v×]` of them.
    struct Turns {
        attitude: UnitQuaternion<f64>,
        vector: Vector3<f64>,
    }

    impl Work for Turns {
        type Output = (UnitQuaternion<f64>, UnitQuaternion<f64>, Matrix3<f64>);

        #[inline(always)]
        fn run<L: Lanes>(self) -> Self::Output {
            let Self { attitude, vector } = self;
            let (before, after) =
                (turn_before::<L>(&attitude, &vector), turn_after::<L>(&attitude, &vector));
            let sum = plus_times_cross_matrix::<L>(
                &matrix::<L>(&before),
                &matrix::<L>(&attitude),
                &vector,
            );
            (before, after, sum)
        }
    }

    fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
        [-limit..limit, -limit..limit, -limit..limit].prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn turns_are_products_with_the_exponential_on_any_lanes(
            attitude in vector(3.0),
            vector in prop_oneof![vector(0.01), vector(0.5), vector(3.0)],
        ) {
            let attitude = UnitQuaternion::from_scaled_axis(attitude);
            let turn = UnitQuaternion::from_scaled_axis(vector);
            let turns = || Turns { attitude, vector };
            for (before, after, sum) in [dispatch(turns()), turns().run::<Baseline>()] {
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
            prop_assert!((renormalize::<Baseline>(&drifted).into_inner().norm() - 1.0).abs() < 1e-15);
        }
    }
}
