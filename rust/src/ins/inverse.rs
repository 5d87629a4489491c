//! The mechanization backwards: from two states to the increments that lead from one to the other.
//!
//! Each form of the update is linear in the rotation vector, or a known function of it, and then
//! linear in the velocity increment, so that two 3x3 systems of the form (I + [a×]) x = b undo it
//! exactly.  What enters from the interval before is weighted by small angles; errors die out, none
//! ring.
//!
//! # References
//! The equations of [`Strapdown::advance`], solved for the increments.

use nalgebra::{UnitQuaternion, Vector3};

use crate::ins::strapdown::{Increments, MechanizationKind, Strapdown, coning_weight};
use crate::math::rotation;
use crate::types::nav_state::NavState;

impl Strapdown {
    /// The increments in b that [`advance`](Self::advance) needs to carry `from` to the time, the
    /// attitude and the velocity of `to`.
    ///
    /// `before` are the increments of the interval that ends at `from`, as for `advance`.  The
    /// position of `to` plays no part: it follows from the velocities.  With
    /// [`MechanizationKind::FirstOrder`] the attitude must turn by less than a right angle, more
    /// than which that form cannot turn in one step; every other form takes any turn below half a
    /// revolution.
    #[must_use]
    pub fn inverse(&self, before: &Increments, from: &NavState, to: &NavState) -> Increments {
        let dt = to.time - from.time;
        let rotation_vector = self.rotation_vector(dt, &from.attitude, &to.attitude);
        let velocity_increment_n =
            from.attitude.inverse() * self.velocity_increment_n(dt, from, to);
        let (angle, velocity) = match self.kind {
            MechanizationKind::TwoSample => {
                two_sample(dt, before, &rotation_vector, &velocity_increment_n)
            }
            MechanizationKind::SingleSample => {
                single_sample(&rotation_vector, &velocity_increment_n)
            }
            MechanizationKind::FirstOrder => first_order(&rotation_vector, &velocity_increment_n),
        };
        Increments { dt, angle, velocity }
    }

    /// Rotation vector (rad) of the sensor's turn from `from` to `to` relative to inertial space,
    /// in b at `from`; the first-order form has no Earth rate.
    fn rotation_vector(
        &self,
        dt: f64,
        from: &UnitQuaternion<f64>,
        to: &UnitQuaternion<f64>,
    ) -> Vector3<f64> {
        let earth_turn = match self.kind {
            MechanizationKind::FirstOrder => UnitQuaternion::identity(),
            _ => rotation::exp(&(dt * self.earth_rate)),
        };
        (from.inverse() * earth_turn * to).scaled_axis()
    }

    /// Integral of the specific force in n, m/s: the change of velocity less gravity and Coriolis.
    fn velocity_increment_n(&self, dt: f64, from: &NavState, to: &NavState) -> Vector3<f64> {
        let coriolis = 2.0 * self.earth_rate.cross(&from.velocity);
        to.velocity - from.velocity + dt * (coriolis + self.gravity * Vector3::z())
    }
}

fn two_sample(
    dt: f64,
    before: &Increments,
    rotation_vector: &Vector3<f64>,
    velocity_increment_n: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let weight = coning_weight(before.dt, dt);
    let angle = solve_with_cross(&(weight * before.angle), rotation_vector);
    let sculling_before = weight * before.velocity.cross(&angle);
    let velocity = solve_with_cross(
        &(0.5 * angle + weight * before.angle),
        &(velocity_increment_n - sculling_before),
    );
    (angle, velocity)
}

fn single_sample(
    rotation_vector: &Vector3<f64>,
    velocity_increment_n: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    (*rotation_vector, solve_with_cross(&(0.5 * rotation_vector), velocity_increment_n))
}

fn first_order(
    rotation_vector: &Vector3<f64>,
    velocity_increment_n: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let turn = rotation_vector.norm();
    let angle = if turn > 0.0 { rotation_vector * (turn.tan() / turn) } else { *rotation_vector };
    (angle, solve_with_cross(&angle, velocity_increment_n))
}

/// The x of (I + [a×]) x = b, by the closed form of that inverse.
fn solve_with_cross(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    (b - a.cross(b) + a * a.dot(b)) / (1.0 + a.norm_squared())
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;
    use proptest::prelude::*;

    use super::*;

    fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
        [-limit..limit, -limit..limit, -limit..limit].prop_map(Vector3::from)
    }

    fn increments() -> impl Strategy<Value = Increments> {
        (0.001..0.02, vector(0.3), vector(1.0)).prop_map(|(dt, angle, velocity)| Increments {
            dt,
            angle,
            velocity,
        })
    }

    fn state() -> impl Strategy<Value = NavState> {
        (vector(3.0), vector(10.0)).prop_map(|(turn, velocity)| NavState {
            velocity,
            ..NavState::at_rest(0.0, UnitQuaternion::from_scaled_axis(turn))
        })
    }

    fn strapdown() -> impl Strategy<Value = Strapdown> {
        let kind = prop_oneof![
            Just(MechanizationKind::TwoSample),
            Just(MechanizationKind::SingleSample),
            Just(MechanizationKind::FirstOrder)
        ];
        // A thousand Earth rates, so that a wrong sign cannot hide below the tolerance.
        (kind, vector(0.07)).prop_map(|(kind, earth_rate)| Strapdown {
            kind,
            gravity: 9.81,
            earth_rate,
            nominal_interval: 0.01,
        })
    }

    proptest! {
        #[test]
        fn the_inverse_finds_the_increments_of_a_step(
            strapdown in strapdown(), before in increments(), now in increments(), from in state()
        ) {
            let mut to = from;
            strapdown.advance(&mut to, &before, &now);
            let found = strapdown.inverse(&before, &from, &to);
            prop_assert!((found.dt - now.dt).abs() < 1e-15);
            prop_assert!((found.angle - now.angle).norm() < 1e-13, "{} {}", found.angle, now.angle);
            prop_assert!(
                (found.velocity - now.velocity).norm() < 1e-12,
                "{} {}",
                found.velocity,
                now.velocity
            );
        }

        #[test]
        fn a_step_with_the_inverse_reaches_the_state(
            strapdown in strapdown(),
            before in increments(),
            from in state(),
            turn in vector(0.5),
            velocity in vector(10.0),
        ) {
            let to =
                NavState { time: 0.01, velocity, attitude: from.attitude * rotation::exp(&turn), ..from };
            let mut reached = from;
            strapdown.advance(&mut reached, &before, &strapdown.inverse(&before, &from, &to));
            prop_assert!(reached.attitude.angle_to(&to.attitude) < 1e-7);
            prop_assert!((reached.attitude * turn - to.attitude * turn).norm() < 1e-13);
            prop_assert!((reached.velocity - to.velocity).norm() < 1e-12);
        }

        #[test]
        fn without_an_interval_before_the_inverse_is_exact_too(
            strapdown in strapdown(), now in increments(), from in state()
        ) {
            let mut to = from;
            strapdown.advance(&mut to, &Increments::NONE, &now);
            prop_assert!((strapdown.inverse(&Increments::NONE, &from, &to).angle - now.angle).norm() < 1e-13);
        }

        #[test]
        fn the_closed_form_solves_the_system(a in vector(2.0), b in vector(5.0)) {
            let x = solve_with_cross(&a, &b);
            prop_assert!(((Matrix3::identity() + rotation::cross_matrix(&a)) * x - b).norm() < 1e-13);
        }
    }

    #[test]
    fn a_disturbance_of_one_state_dies_out_within_a_few_samples() {
        let strapdown = Strapdown {
            kind: MechanizationKind::TwoSample,
            gravity: 9.81,
            earth_rate: Vector3::zeros(),
            nominal_interval: 0.01,
        };
        let turning = |k: i32| {
            let time = 0.01 * f64::from(k);
            NavState::at_rest(time, rotation::exp(&(time * Vector3::new(3.0, -8.0, 2.0))))
        };
        let replay = |disturbance: f64| {
            let mut before = Increments {
                dt: 0.01,
                angle: Vector3::zeros(),
                velocity: disturbance * Vector3::x(),
            };
            for k in 0..8 {
                before = strapdown.inverse(&before, &turning(k), &turning(k + 1));
            }
            before
        };
        assert!((replay(1.0).velocity - replay(0.0).velocity).norm() < 1e-12);
    }
}
