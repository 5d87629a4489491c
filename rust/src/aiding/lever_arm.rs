//! Lever arm from the point about which the foot rotates on the ground to the sensor.
//!
//! A foot in stance rolls from the heel to the ball.  A sensor at r (b) from the rotation centre has
//! the velocity `C (ω × r)`, some mm/s where the foot turns least, and always to the same side.
//! Taken for zero, it is an error of that velocity times the duration of the stride in the height of
//! each stride, and shortens the stride.
//!
//! r is estimated from contacts with the ground: the times around a stance in which the angular rate
//! stays below a limit.  In a contact the free-inertial velocity is known up to a constant c,
//!
//! ```text
//! u(t) = C (ω × r) + c
//! ```
//!
//! and r is the least-squares solution with c eliminated.  A contact is longer than the stance in it,
//! and the rates at its ends carry more information on r than the stillest moment does.
//!
//! The rotation centre moves from the heel to the ball; r belongs to a point between them, so the
//! velocity stays uncertain in proportion to the angular rate.

use nalgebra::{Matrix3, Vector3};

use crate::ins::interval::Interval;
use crate::ins::strapdown::StrapdownStep;
use crate::math::rotation_kernels;
use crate::math::simd::Simd;

/// Longest contact that is used, s: over a longer one the error of the free-inertial velocity is no
/// constant.
const MAX_CONTACT_DURATION: f64 = 1.0;
/// Variation of the angular rate at which a single contact weighs as much as the prior r = 0, rad/s.
const MIN_EXCITATION: f64 = 0.1;
/// Squared ratio of the motion of the rotation centre in a contact, 3 cm, to its distance from the
/// sensor, 10 cm.  It moves alike in every stride, so it does not average out.
const LEVER_ARM_VARIATION: f64 = 0.1;
/// Factor on the normal equations of earlier contacts at the end of a contact: a memory of some 20
/// strides.
const FORGETTING_FACTOR: f64 = 0.95;

/// Estimates the lever arm.
#[derive(Clone, Debug, Default)]
pub(crate) struct LeverArmEstimator {
    contact: Contact,
    normal: Matrix3<f64>,
    right: Vector3<f64>,
    lever: Vector3<f64>,
}

impl LeverArmEstimator {
    /// Velocity of the sensor on a foot that rotates with `angular_rate` (b, rad/s), b, m/s.
    #[inline]
    pub(crate) fn velocity(&self, angular_rate: &Vector3<f64>) -> Vector3<f64> {
        angular_rate.cross(&self.lever)
    }

    /// Propagates over an interval; a contact lasts while the angular rate is below `limit` (rad/s).
    #[inline(always)]
    pub(crate) fn step(&mut self, simd: impl Simd, interval: &Interval, stance: bool, limit: f64) {
        if interval.step.dt <= 0.0 {
            return;
        }
        if interval.angular_rate.norm_squared() < limit.powi(2) {
            self.contact.step(simd, interval, stance);
        } else if self.contact.duration > 0.0 {
            self.end_contact();
        }
    }

    /// Discards the present contact.
    pub(crate) fn interrupt(&mut self) {
        self.contact = Contact::default();
    }

    /// Adds the contact to the normal equations if it includes a stance.
    #[cold]
    fn end_contact(&mut self) {
        let contact = std::mem::take(&mut self.contact);
        if !contact.had_stance || contact.duration > MAX_CONTACT_DURATION {
            return;
        }
        let (normal, right) = contact.equations();
        self.normal = FORGETTING_FACTOR * self.normal + normal;
        self.right = FORGETTING_FACTOR * self.right + right;
        // Two of the three directions count: r along the rotation axis has no effect.
        let ridge = MIN_EXCITATION.powi(2) + LEVER_ARM_VARIATION * 0.5 * self.normal.trace();
        if let Some(factor) = (self.normal + Matrix3::from_diagonal_element(ridge)).cholesky() {
            self.lever = factor.solve(&self.right);
        }
    }
}

/// Integrals over a contact of `A = C [ω×]`, of the velocity u since it began, and of products: `ω
/// ωᵀ` for `Aᵀ A = |ω|² I - ω ωᵀ`, and `Aᵀ u`.
#[derive(Clone, Debug, Default)]
struct Contact {
    duration: f64,
    had_stance: bool,
    velocity: Vector3<f64>,
    a: Matrix3<f64>,
    u: Vector3<f64>,
    /// Of the squares and of the mixed products x y, y z and z x of the angular rate.
    squares: Vector3<f64>,
    mixed: Vector3<f64>,
    a_u: Vector3<f64>,
}

impl Contact {
    #[inline(always)]
    fn step(&mut self, simd: impl Simd, interval: &Interval, stance: bool) {
        let Interval {
            step: StrapdownStep { dt, attitude, .. },
            angular_rate,
            velocity_change,
            ..
        } = interval;
        // The angular rate is the mean over the interval, so it goes with the velocity in the
        // middle.
        let u = rotation_kernels::add_scaled(simd, &self.velocity, 0.5, velocity_change);
        self.velocity += velocity_change;
        self.duration += dt;
        self.had_stance |= stance;
        let angle = *dt * angular_rate;
        self.a = rotation_kernels::add_cross_matrix_product(simd, &self.a, attitude, &angle);
        self.u = rotation_kernels::add_scaled(simd, &self.u, *dt, &u);
        self.squares += angle.component_mul(angular_rate);
        self.mixed += angle.component_mul(&angular_rate.yzx());
        self.a_u = rotation_kernels::add_cross(simd, &self.a_u, &attitude.tr_mul(&u), &angle);
    }

    /// The normal equations of r with c eliminated; each contact has the same say however long it
    /// was.
    fn equations(&self) -> (Matrix3<f64>, Vector3<f64>) {
        let (a, u) = (self.a / self.duration, self.u / self.duration);
        let ([xx, yy, zz], [xy, yz, zx]) = (self.squares.into(), self.mixed.into());
        let a_a = Matrix3::new(yy + zz, -xy, -zx, -xy, zz + xx, -yz, -zx, -yz, xx + yy);
        (a_a / self.duration - a.tr_mul(&a), self.a_u / self.duration - a.tr_mul(&u))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    use super::*;
    use crate::math::rotation::exp;
    use crate::math::simd::Baseline;

    const DT: f64 = 0.002;
    const LIMIT: f64 = 2.0;

    fn interval(
        angular_rate: Vector3<f64>,
        attitude: Matrix3<f64>,
        velocity_change: Vector3<f64>,
        dt: f64,
    ) -> Interval {
        let step = StrapdownStep { dt, velocity_increment_n: Vector3::zeros(), attitude };
        Interval { step, gap_duration: 0.0, angular_rate, velocity_change }
    }

    /// A contact of `duration` s on a point at -`lever` (b) from the sensor, with a velocity that
    /// is wrong by a constant, and a fast swing after it.
    fn contact(
        estimator: &mut LeverArmEstimator,
        lever: &Vector3<f64>,
        duration: f64,
        stationary: bool,
    ) {
        let mut attitude = UnitQuaternion::from_euler_angles(0.1, -0.2, 0.7);
        let mut time = 0.0;
        let mut before = None;
        while time < duration {
            let phase = time / duration;
            let rate = Vector3::new(
                0.3 * (9.0 * phase).sin(),
                3.0 * (phase - 0.4).powi(2) + 0.2,
                0.4 * phase,
            );
            let velocity = |attitude: &UnitQuaternion<f64>| attitude * rate.cross(lever);
            let began = before.unwrap_or_else(|| velocity(&attitude));
            attitude *= exp(&(rate * DT));
            let now = velocity(&attitude);
            let matrix = attitude.to_rotation_matrix().into_inner();
            estimator.step(
                Baseline,
                &interval(rate, matrix, now - began, DT),
                stationary && (0.3..0.5).contains(&phase),
                LIMIT,
            );
            before = Some(now);
            time += DT;
        }
        let swing =
            interval(Vector3::new(0.0, 5.0, 0.0), Matrix3::identity(), Vector3::zeros(), DT);
        estimator.step(Baseline, &swing, false, LIMIT);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn it_finds_what_the_foot_rolls_about(
            lever in [-0.15..0.15, -0.15..0.15, -0.15..0.15_f64].prop_map(Vector3::from),
        ) {
            let mut estimator = LeverArmEstimator::default();
            for _ in 0..60 {
                contact(&mut estimator, &lever, 0.5, true);
            }
            let rate = Vector3::new(0.0, 0.2, 0.0);
            let (found, truth) = (estimator.velocity(&rate), rate.cross(&lever));
            // The estimate is shrunk by the variation of the lever arm.
            prop_assert!(
                (found - truth).norm() < 0.2 * rate.norm() * lever.norm() + 1e-3,
                "{found}, {truth}"
            );
        }
    }

    #[test]
    fn a_slow_swing_and_a_long_rest_tell_nothing() {
        let lever = Vector3::new(0.05, 0.0, 0.1);
        let mut estimator = LeverArmEstimator::default();
        contact(&mut estimator, &lever, 0.5, false);
        contact(&mut estimator, &lever, 1.1, true);
        assert_eq!(estimator.velocity(&Vector3::y()), Vector3::zeros());
        contact(&mut estimator, &lever, 0.5, true);
        assert!(estimator.velocity(&Vector3::y()).norm() > 0.05);
    }

    #[test]
    fn a_repeated_stamp_does_not_end_a_contact_but_an_interruption_does() {
        let turn = |rate: f64, dt: f64| {
            interval(
                Vector3::new(0.0, rate, 0.0),
                Matrix3::identity(),
                Vector3::new(0.01, 0.0, 0.0),
                dt,
            )
        };
        let mut estimator = LeverArmEstimator::default();
        estimator.step(Baseline, &turn(0.5, DT), true, LIMIT);
        estimator.step(Baseline, &turn(5.0, 0.0), false, LIMIT);
        assert!(estimator.contact.had_stance);
        estimator.interrupt();
        assert!(!estimator.contact.had_stance && estimator.contact.duration == 0.0);
    }
}
