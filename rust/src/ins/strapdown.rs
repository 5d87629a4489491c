//! Strapdown mechanization: from increments of the inertial sensors to position, velocity and
//! attitude.
//!
//! A sample is the mean over the interval that it ends, so that rate times interval is an
//! increment.  A sample covers at most [`MAX_HOLD`] nominal intervals; what lies before that,
//! in a gap, is interpolated as the mean of the samples on both sides.
//!
//! # References
//! - P. G. Savage, "Strapdown Inertial Navigation Integration Algorithm Design", J. Guidance
//!   21(1-2), 1998: coning eq. 52, sculling eq. 59 of parts 1 and 2, in the form that pairs each
//!   increment with the one before it.
//! - Wu, Lu, Chen, "Research on Foot-Mounted Personal Navigation Algorithm based on MEMS Inertial
//!   Sensors": eq. 2 (trapezoidal position) and the two-sample update.
//! - Wang, Liu, Sun, Cai, Cheng, Electronics 8(12):1405, 2019: eq. 1 (first-order form).

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::math::rotation_kernels;
use crate::math::simd::{Baseline, Simd};
use crate::settings::choices;
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;

/// Number of nominal intervals for which a sample is held, at most.
pub const MAX_HOLD: f64 = 1.5;

choices! {
    /// How increments become attitude, velocity and position.
    pub enum MechanizationKind {
        /// Coning and sculling compensated with the increments of two successive samples (Wu et
        /// al.).
        TwoSample = "two-sample",
        /// Angular rate and specific force constant over the interval: rotation compensated, coning
        /// and sculling not.
        SingleSample = "single-sample",
        /// First-order form as published (Wang et al. 2019, eq. 1); the attitude is
        /// orthonormalized after each step, and Earth rate is not part of it.
        FirstOrder = "first-order",
    }
}

/// The sensor increments of one interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increments {
    /// Length of the interval, s.
    pub dt: f64,
    /// Integral of the angular rate in b, rad.
    pub angle: Vector3<f64>,
    /// Integral of the specific force in b, m/s.
    pub velocity: Vector3<f64>,
}

impl Increments {
    /// No interval at all.
    pub(crate) const NONE: Self =
        Self { dt: 0.0, angle: Vector3::new(0.0, 0.0, 0.0), velocity: Vector3::new(0.0, 0.0, 0.0) };
}

/// What one step of the mechanization did, as the error model needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrapdownStep {
    /// Length of the interval, s.
    pub dt: f64,
    /// Integral of the specific force over the interval in n, m/s.
    pub velocity_increment_n: Vector3<f64>,
    /// Attitude matrix `C_b^n` at the end of the interval; of the first-order form as its update
    /// leaves it, which is not quite a rotation.
    pub attitude: Matrix3<f64>,
}

/// The mechanization with the Earth that it runs on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strapdown {
    /// The form of the update.
    pub kind: MechanizationKind,
    /// Magnitude of gravity, m/s².
    pub gravity: f64,
    /// Rotation rate of the Earth in n, rad/s; zero when it is neglected.
    pub earth_rate: Vector3<f64>,
    /// Sample interval that the sensor promises, s.
    pub nominal_interval: f64,
}

impl Strapdown {
    /// The increments of the interval that ends with `current`.
    #[must_use]
    #[inline(always)]
    pub fn increments(&self, previous: &ImuSample, current: &ImuSample) -> Increments {
        let dt = current.time - previous.time;
        let mut now = Increments {
            dt,
            angle: dt * current.angular_rate,
            velocity: dt * current.specific_force,
        };
        let gap_duration = self.gap_duration(previous, current);
        if gap_duration > 0.0 {
            now.angle += 0.5 * gap_duration * (previous.angular_rate - current.angular_rate);
            now.velocity += 0.5 * gap_duration * (previous.specific_force - current.specific_force);
        }
        now
    }

    /// Part of the interval between two stamps that no sample covers, s; zero when none is
    /// missing.
    #[must_use]
    #[inline(always)]
    pub fn gap_duration(&self, previous: &ImuSample, current: &ImuSample) -> f64 {
        (current.time - previous.time - MAX_HOLD * self.nominal_interval).max(0.0)
    }

    /// Advances `state` over the interval of `now`; `before` are the increments of the interval
    /// that ended where this one begins.
    pub fn advance(
        &self,
        state: &mut NavState,
        before: &Increments,
        now: &Increments,
    ) -> StrapdownStep {
        self.advance_with(Baseline, state, before, now)
    }

    /// As [`Strapdown::advance`], with an instruction set.
    #[inline(always)]
    pub(crate) fn advance_with(
        &self,
        simd: impl Simd,
        state: &mut NavState,
        before: &Increments,
        now: &Increments,
    ) -> StrapdownStep {
        let dt = now.dt;
        let start = state.velocity;
        let (rotation_vector, velocity_increment_n) = match self.kind {
            MechanizationKind::TwoSample => two_sample(simd, before, now),
            MechanizationKind::SingleSample => single_sample(simd, now),
            MechanizationKind::FirstOrder => first_order(simd, now),
        };
        let velocity_increment_n =
            rotation_kernels::rotate(simd, &state.attitude, &velocity_increment_n);
        let attitude = self.rotated(simd, &state.attitude, &rotation_vector, dt);
        let matrix = match self.kind {
            MechanizationKind::FirstOrder => published(simd, &state.attitude, &now.angle),
            _ => rotation_kernels::matrix(simd, &attitude),
        };
        state.velocity += velocity_increment_n;
        state.velocity.z = simd.mul_add(-dt, self.gravity, state.velocity.z);
        if is_rotating(&self.earth_rate) {
            state.velocity -= 2.0 * dt * self.earth_rate.cross(&start);
        }
        state.position = match self.kind {
            MechanizationKind::FirstOrder => {
                state.position + dt * (1.5 * state.velocity - 0.5 * start)
            }
            _ => rotation_kernels::add_scaled(
                simd,
                &state.position,
                0.5 * dt,
                &(start + state.velocity),
            ),
        };
        state.attitude = attitude;
        state.time += dt;
        StrapdownStep { dt, velocity_increment_n, attitude: matrix }
    }

    /// The attitude after a turn of the sensor, and of the Earth but for the first-order form.
    ///
    /// It is the attitude before that is brought back to unit length: that needs not wait for the
    /// turn, and one turn leaves no more than rounding.
    #[inline(always)]
    fn rotated(
        &self,
        simd: impl Simd,
        attitude: &UnitQuaternion<f64>,
        rotation_vector: &Vector3<f64>,
        dt: f64,
    ) -> UnitQuaternion<f64> {
        let turned = rotation_kernels::rotate_in_body(
            simd,
            &rotation_kernels::renormalize(simd, attitude),
            rotation_vector,
        );
        if self.kind == MechanizationKind::FirstOrder || !is_rotating(&self.earth_rate) {
            return turned;
        }
        rotation_kernels::rotate_in_nav(simd, &turned, &(-dt * self.earth_rate))
    }
}

// Each form gives the rotation vector (rad) and the integral of the specific force (m/s) in b as it
// was when the interval began.

/// Coning turns the rotation vector by `w θ' × θ`; rotation and sculling turn the velocity by `½ θ
/// × v + w (θ' × v + v' × θ)`.
#[inline(always)]
fn two_sample(
    simd: impl Simd,
    before: &Increments,
    now: &Increments,
) -> (Vector3<f64>, Vector3<f64>) {
    let weight = coning_weight(before.dt, now.dt);
    let coning = rotation_kernels::cross(simd, &before.angle, &now.angle);
    let sculling = rotation_kernels::cross(simd, &before.angle, &now.velocity);
    let sculling = rotation_kernels::add_cross(simd, &sculling, &before.velocity, &now.angle);
    let (rotation_vector, rotated) = single_sample(simd, now);
    (
        rotation_kernels::add_scaled(simd, &rotation_vector, weight, &coning),
        rotation_kernels::add_scaled(simd, &rotated, weight, &sculling),
    )
}

/// Rotation turns the velocity by `½ θ × v`.
#[inline(always)]
fn single_sample(simd: impl Simd, now: &Increments) -> (Vector3<f64>, Vector3<f64>) {
    (now.angle, rotation_kernels::add_cross(simd, &now.velocity, &(0.5 * now.angle), &now.velocity))
}

/// The rotation nearest to C (I + [θ×]) turns by atan |θ| about θ; the velocity turns with the
/// matrix before it is made orthonormal, as published.
#[inline(always)]
fn first_order(simd: impl Simd, now: &Increments) -> (Vector3<f64>, Vector3<f64>) {
    let angle = now.angle.norm();
    let nearest = if angle > 0.0 { angle.atan() / angle } else { 1.0 };
    (
        nearest * now.angle,
        rotation_kernels::add_cross(simd, &now.velocity, &now.angle, &now.velocity),
    )
}

/// C (I + [θ×]), as published.
#[inline(always)]
fn published(
    simd: impl Simd,
    attitude: &UnitQuaternion<f64>,
    angle: &Vector3<f64>,
) -> Matrix3<f64> {
    let matrix = rotation_kernels::matrix(simd, attitude);
    rotation_kernels::add_cross_matrix_product(simd, &matrix, &matrix, angle)
}

/// Whether a rotation rate of the Earth is not neglected.
#[inline]
pub(crate) fn is_rotating(rate: &Vector3<f64>) -> bool {
    rate.norm_squared() > 0.0
}

/// The weight of the products of increments in coning and sculling, from rate and specific force
/// that change linearly between the middles of the two intervals.
///
/// For equal intervals it is the textbook's 1/12; zero when there is no interval before.
#[inline]
pub(crate) fn coning_weight(before: f64, now: f64) -> f64 {
    if before > 0.0 { now * now / (6.0 * before * (before + now)) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_attitude_keeps_unit_length_over_a_million_turns() {
        for kind in [
            MechanizationKind::TwoSample,
            MechanizationKind::SingleSample,
            MechanizationKind::FirstOrder,
        ] {
            let earth_rate = Vector3::new(0.0, 5e-5, 5e-5);
            let strapdown = Strapdown { kind, gravity: 9.81, earth_rate, nominal_interval: 0.01 };
            let mut state = NavState::at_rest(0.0, UnitQuaternion::identity());
            let mut before = Increments::NONE;
            for k in 0..1_000_000_u32 {
                let phase = 0.1 * f64::from(k);
                let angle =
                    0.2 * Vector3::new(phase.sin(), (1.7 * phase).cos(), (0.3 * phase).sin());
                let now = Increments { dt: 0.01, angle, velocity: Vector3::new(0.0, 0.0, 0.0981) };
                strapdown.advance(&mut state, &before, &now);
                before = now;
            }
            assert!((state.attitude.coords.norm() - 1.0).abs() < 1e-15, "{kind:?}");
        }
    }
}
