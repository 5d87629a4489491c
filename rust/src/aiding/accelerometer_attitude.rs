//! The attitude that the accelerometer shows at rest, against the computed one.
//!
//! Roll and pitch come from the direction of the specific force, which at rest is up.  Taken off
//! the computed attitude they leave a rotation about the vertical, but for the errors: with c the
//! matrix `C_est C_x C_y`, the tilt errors are `φ_x = c_23`, `φ_y = -c_13`.
//!
//! Wang et al. 2019 also read a heading error from it, `φ_z = -asin sqrt(c_21² + c_22² - 1)` (their
//! eq. 17; the signs here are those of truth minus estimate).  The rows of a rotation have length
//! one, so the radicand is `-c_23²` and there is no such angle: an accelerometer does not see a
//! heading.  Numbers come out only where the first-order update has left an attitude matrix that is
//! no rotation, and they measure how far it is from one.
//!
//! # References
//! Wang, Liu, Sun, Cai, Cheng, "Heading Calibration for Foot-Mounted Inertial
//! Pedestrian-Positioning Systems Based on Accelerometer Attitude", Electronics 8(12):1405, 2019:
//! eqs. 10, 16, 17.

use nalgebra::{Matrix3, Rotation3, Vector3};

/// Radicand up to which a rotation matrix is one to rounding.
const ROUNDING: f64 = 1.0e-12;

/// Attitude errors, truth minus estimate, as the accelerometer shows them, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ObservedAttitude {
    /// About n x and n y.
    pub(crate) tilt: [f64; 2],
    /// About n z, as published; none where the radicand is not positive.
    pub(crate) heading: Option<f64>,
}

/// Compares a computed attitude matrix with the specific force (b, m/s²) of a foot at rest.
pub(crate) fn observe(attitude: &Matrix3<f64>, specific_force: &Vector3<f64>) -> ObservedAttitude {
    let f = specific_force;
    let roll = f.y.atan2(f.z);
    let pitch = (-f.x).atan2(f.y.hypot(f.z));
    let level_to_sensor = Rotation3::from_euler_angles(roll, pitch, 0.0).inverse();
    let c = attitude * level_to_sensor.matrix();
    let radicand = c.m21.powi(2) + c.m22.powi(2) - 1.0;
    let heading = (radicand > ROUNDING).then(|| -radicand.sqrt().min(1.0).asin());
    ObservedAttitude { tilt: [c.m23, -c.m13], heading }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    use super::*;
    use crate::math::rotation;

    proptest! {
        #[test]
        fn a_small_tilt_is_found_and_no_heading(r in -1.4..1.4, p in -1.4..1.4, y in -3.0..3.0, e in [-0.01..0.01, -0.01..0.01, -0.01..0.01]) {
            let truth = UnitQuaternion::from_euler_angles(r, p, y);
            let error = Vector3::from(e);
            let estimate = rotation::exp(&-error) * truth;
            let observed = observe(estimate.to_rotation_matrix().matrix(), &(truth.inverse() * Vector3::new(0.0, 0.0, 9.8)));
            prop_assert!((observed.tilt[0] - error.x).abs() < 3e-4);
            prop_assert!((observed.tilt[1] - error.y).abs() < 3e-4);
            prop_assert_eq!(observed.heading, None);
        }

        #[test]
        fn a_heading_appears_only_where_the_matrix_is_no_rotation(y in -3.0..3.0, rate in 1e-4..0.1) {
            let turn = rate * Vector3::x();
            let truth = UnitQuaternion::from_euler_angles(0.0, 0.0, y);
            let first_order = truth.to_rotation_matrix().matrix() * (Matrix3::identity() + rotation::cross_matrix(&turn));
            let up = rotation::exp(&-turn) * Vector3::z();
            let heading = observe(&first_order, &up).heading;
            let stretch = first_order.row(1).norm_squared() - 1.0;
            let tilted = observe(&first_order, &up).tilt[0].powi(2);
            prop_assert_eq!(heading.is_some(), stretch - tilted > ROUNDING);
            if let Some(heading) = heading {
                prop_assert!((heading.sin().powi(2) - (stretch - tilted)).abs() < 1e-9);
                prop_assert!(heading < 0.0);
            }
        }
    }
}
