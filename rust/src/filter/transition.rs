//! The transition matrix F of the error model over one step or several, as a product of factors.
//!
//! Position moves in two halves around the change of velocity, as in the trapezoid of the
//! mechanization.  Each factor is the identity and one block beside the diagonal.  It is inverted,
//! transposed or applied to a covariance by itself, so the smoother's Fᵀ is the same few products in
//! the reverse order.

use nalgebra::{Matrix3, Vector3};

use crate::filter::error_state::{Block, LinearMap};
use crate::ins::strapdown::{StrapdownStep, is_rotating};
use crate::math::rotation;
use crate::math::simd::Simd;

/// The transition over one step of the mechanization, or over several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Transition {
    dt: f64,
    tilt: Vector3<f64>,
    bias: Matrix3<f64>,
    earth_rate: Vector3<f64>,
}

impl Transition {
    /// Over an interval of zero length.
    pub(crate) const NONE: Self = Self {
        dt: 0.0,
        tilt: Vector3::new(0.0, 0.0, 0.0),
        bias: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        earth_rate: Vector3::new(0.0, 0.0, 0.0),
    };

    /// The transition of a step with an Earth rate (n, rad/s).
    #[must_use]
    #[inline]
    pub(crate) fn new(step: &StrapdownStep, earth_rate: &Vector3<f64>) -> Self {
        Self {
            dt: step.dt,
            tilt: -step.velocity_increment_n,
            bias: -step.dt * step.attitude,
            earth_rate: *earth_rate,
        }
    }

    /// This transition and `next` as one.
    ///
    /// The change of velocity is taken as uniform over the time, and the gyroscope bias acts on the
    /// attitude at the end of it, so the result differs from the product in the second order of the
    /// time.
    #[must_use]
    #[inline(always)]
    pub(crate) fn compose(&self, next: &Self) -> Self {
        Self {
            dt: self.dt + next.dt,
            tilt: self.tilt + next.tilt,
            bias: self.bias + next.bias,
            ..*next
        }
    }

    /// Duration, s.
    #[must_use]
    #[inline]
    pub(crate) fn dt(&self) -> f64 {
        self.dt
    }

    /// `x` becomes F x; a covariance becomes F P Fᵀ.
    #[cfg(test)]
    pub(crate) fn apply(&self, simd: impl Simd, x: &mut impl LinearMap) {
        let (half, tilt, bias) = self.factors();
        x.add_scaled(simd, Block::Position, Block::Velocity, half);
        x.add_transformed(simd, Block::Velocity, Block::Attitude, &rotation::cross_matrix(&tilt));
        x.add_transformed(simd, Block::Velocity, Block::AccelBias, &bias);
        x.add_scaled(simd, Block::Position, Block::Velocity, half);
        x.add_transformed(simd, Block::Attitude, Block::GyroBias, &bias);
        self.apply_earth_rate(x);
    }

    /// The factors: velocity to position, applied twice, s; the vector s of [s×], tilt to velocity,
    /// m/s; and the matrix from bias to velocity or attitude, s.
    #[inline]
    pub(crate) fn factors(&self) -> (f64, Vector3<f64>, Matrix3<f64>) {
        (0.5 * self.dt, self.tilt, self.bias)
    }

    /// Whether the Earth rate is not neglected.
    #[inline]
    pub(crate) fn has_earth_rate(&self) -> bool {
        is_rotating(&self.earth_rate)
    }

    /// Applies the Earth rate, the last factor.
    #[inline]
    pub(crate) fn apply_earth_rate(&self, x: &mut impl LinearMap) {
        if let Some((velocity, attitude)) = self.earth_rotation() {
            x.transform(Block::Velocity, &velocity);
            x.transform(Block::Attitude, &attitude);
        }
    }

    /// `x` becomes Fᵀ x; an information matrix becomes Fᵀ Λ F.
    #[inline]
    pub(crate) fn apply_transposed(&self, simd: impl Simd, x: &mut impl LinearMap) {
        if let Some((velocity, attitude)) = self.earth_rotation() {
            x.transform(Block::Attitude, &attitude.transpose());
            x.transform(Block::Velocity, &velocity.transpose());
        }
        let (half, tilt, bias) = self.factors();
        x.apply_transposed_factors(simd, half, &rotation::cross_matrix(&tilt), &bias);
    }

    /// Effect of the Earth rate on velocity and attitude; none if it is neglected.
    #[inline]
    fn earth_rotation(&self) -> Option<(Matrix3<f64>, Matrix3<f64>)> {
        if !self.has_earth_rate() {
            return None;
        }
        let turn = -self.dt * rotation::cross_matrix(&self.earth_rate);
        Some((Matrix3::identity() + 2.0 * turn, Matrix3::identity() + turn))
    }
}
