//! Rotations in as few operations as the lanes allow: a multiplication and the addition after it are one where the processor has that.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::lanes::Lanes;

/// Square of half an angle up to which a polynomial replaces sine and cosine.
const SMALL: f64 = 0.0625;

/// `c + a × b`.
#[inline(always)]
pub(crate) fn plus_cross<L: Lanes>(c: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
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

/// `q v q*`.
#[inline(always)]
pub(crate) fn rotate<L: Lanes>(q: &UnitQuaternion<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let axis = Vector3::new(q.i, q.j, q.k);
    let moved = plus_cross::<L>(&Vector3::zeros(), &axis, &(2.0 * v));
    plus_cross::<L>(&plus_scaled::<L>(v, q.w, &moved), &axis, &moved)
}

/// Hamilton's product.
#[inline(always)]
pub(crate) fn product<L: Lanes>(p: &UnitQuaternion<f64>, q: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(
        L::fused(p.w, q.w, L::fused(-p.i, q.i, L::fused(-p.j, q.j, -p.k * q.k))),
        L::fused(p.w, q.i, L::fused(p.i, q.w, L::fused(p.j, q.k, -p.k * q.j))),
        L::fused(p.w, q.j, L::fused(p.j, q.w, L::fused(p.k, q.i, -p.i * q.k))),
        L::fused(p.w, q.k, L::fused(p.k, q.w, L::fused(p.i, q.j, -p.j * q.i))),
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
    let x = L::fused(half.x, half.x, L::fused(half.y, half.y, half.z * half.z));
    if x > SMALL {
        return exp_of_large(rotation_vector);
    }
    let sinc =
        polynomial::<L, 6>(x, [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5_040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0]);
    let cos = polynomial::<L, 7>(
        x,
        [1.0, -0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0, -1.0 / 3_628_800.0, 1.0 / 479_001_600.0],
    );
    UnitQuaternion::new_unchecked(Quaternion::new(cos, sinc * half.x, sinc * half.y, sinc * half.z))
}

/// Horner's scheme; the coefficients come in the order of the powers.
#[inline(always)]
fn polynomial<L: Lanes, const N: usize>(x: f64, coefficients: [f64; N]) -> f64 {
    let mut sum = coefficients[N - 1];
    for k in (0..N - 1).rev() {
        sum = L::fused(x, sum, coefficients[k]);
    }
    sum
}

#[cold]
fn exp_of_large(rotation_vector: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(*rotation_vector)
}

/// A quaternion that has drifted a little brought back to unit length: see [`super::renormalize`].
#[inline(always)]
pub(crate) fn renormalize<L: Lanes>(q: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let (x, y, z, w) = (q.i, q.j, q.k, q.w);
    let square = L::fused(x, x, L::fused(y, y, L::fused(z, z, w * w)));
    UnitQuaternion::new_unchecked(q.into_inner() * L::fused(-0.5, square, 1.5))
}
