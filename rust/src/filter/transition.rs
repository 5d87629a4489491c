//! The transition matrix F of the error model over one step or several, as a product of shears.
//!
//! Position moves in two halves around the change of velocity, as in the trapezoid of the
//! mechanization.  Each shear is undone, transposed or applied to a covariance by itself, so the
//! smoother's Fᵀ is the same few products in the reverse order.

use nalgebra::{Matrix3, Vector3};

use crate::filter::error_state::{Block, LinearMap};
use crate::ins::strapdown::{Step, earth_turns};
use crate::math::rotation;

/// Variances that a transition adds to the errors, the same on each axis; what is added is
/// independent of all that was before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Of the position, m².
    pub position: f64,
    /// Of the velocity, m²/s².
    pub velocity: f64,
    /// Of the attitude, rad².
    pub attitude: f64,
    /// Of the gyroscope's bias, rad²/s².
    pub gyro_bias: f64,
    /// Of the accelerometer's bias, m²/s⁴.
    pub accel_bias: f64,
    /// Covariance of position and velocity, m²/s.
    pub position_velocity: f64,
}

impl Noise {
    /// What this noise and `next`, of a transition of `dt` (s) after it, add together: the velocity
    /// that was added first leads the position on.
    #[must_use]
    #[inline(always)]
    pub fn then(&self, next: &Self, dt: f64) -> Self {
        let led_on = dt * (2.0 * self.position_velocity + dt * self.velocity);
        Self {
            position: self.position + led_on + next.position,
            velocity: self.velocity + next.velocity,
            attitude: self.attitude + next.attitude,
            gyro_bias: self.gyro_bias + next.gyro_bias,
            accel_bias: self.accel_bias + next.accel_bias,
            position_velocity: self.position_velocity + dt * self.velocity + next.position_velocity,
        }
    }
}

/// The transition over one step of the mechanization, or over several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    dt: f64,
    tilt: Vector3<f64>,
    bias: Matrix3<f64>,
    earth_rate: Vector3<f64>,
}

impl Transition {
    /// Over no time at all.
    pub(crate) const NONE: Self = Self {
        dt: 0.0,
        tilt: Vector3::new(0.0, 0.0, 0.0),
        bias: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        earth_rate: Vector3::new(0.0, 0.0, 0.0),
    };

    /// The transition that belongs to a step on an Earth that turns with `earth_rate` (rad/s, n).
    #[must_use]
    #[inline]
    pub fn new(step: &Step, earth_rate: &Vector3<f64>) -> Self {
        Self {
            dt: step.dt,
            tilt: -step.velocity_increment_n,
            bias: -step.dt * step.attitude,
            earth_rate: *earth_rate,
        }
    }

    /// This transition and `next` as one.
    ///
    /// It takes what the velocity gains for spread evenly over the time, and has the gyroscope's
    /// bias turn the attitude at the end of it.  So it differs from the product of both by the
    /// second order of their time.
    #[must_use]
    #[inline(always)]
    pub fn then(&self, next: &Self) -> Self {
        Self {
            dt: self.dt + next.dt,
            tilt: self.tilt + next.tilt,
            bias: self.bias + next.bias,
            ..*next
        }
    }

    /// The time that it takes, s.
    #[must_use]
    #[inline]
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// `x` becomes F x; a covariance becomes F P Fᵀ.
    pub fn apply(&self, x: &mut impl LinearMap) {
        let (half, tilt, bias) = self.shears();
        x.add_scaled(Block::Position, Block::Velocity, half);
        x.add_transformed(Block::Velocity, Block::Attitude, &rotation::cross_matrix(&tilt));
        x.add_transformed(Block::Velocity, Block::AccelBias, &bias);
        x.add_scaled(Block::Position, Block::Velocity, half);
        x.add_transformed(Block::Attitude, Block::GyroBias, &bias);
        self.turn_with_earth(x);
    }

    /// What velocity turns into position twice, s; the vector s of [s×], which turns a tilt into
    /// velocity, m/s; and the matrix that turns a bias into velocity or attitude, s.
    #[inline]
    pub(crate) fn shears(&self) -> (f64, Vector3<f64>, Matrix3<f64>) {
        (0.5 * self.dt, self.tilt, self.bias)
    }

    /// Whether the Earth turns.
    #[inline]
    pub(crate) fn turns_with_earth(&self) -> bool {
        earth_turns(&self.earth_rate)
    }

    /// The last step: the Earth turned.
    #[inline]
    pub(crate) fn turn_with_earth(&self, x: &mut impl LinearMap) {
        if let Some((velocity, attitude)) = self.turn() {
            x.transform(Block::Velocity, &velocity);
            x.transform(Block::Attitude, &attitude);
        }
    }

    /// `x` becomes Fᵀ x; an information matrix becomes Fᵀ Λ F.
    #[inline]
    pub fn apply_transposed(&self, x: &mut impl LinearMap) {
        if let Some((velocity, attitude)) = self.turn() {
            x.transform(Block::Attitude, &attitude.transpose());
            x.transform(Block::Velocity, &velocity.transpose());
        }
        let (half, tilt, bias) = self.shears();
        x.move_back(half, &rotation::cross_matrix(&tilt), &bias);
    }

    /// How the Earth turns velocity and attitude; none when it is at rest.
    #[inline]
    fn turn(&self) -> Option<(Matrix3<f64>, Matrix3<f64>)> {
        if !self.turns_with_earth() {
            return None;
        }
        let turn = -self.dt * rotation::cross_matrix(&self.earth_rate);
        Some((Matrix3::identity() + 2.0 * turn, Matrix3::identity() + turn))
    }
}
