//! Corrections of whole gait cycles: the velocity error that a stance observes is removed from the
//! swing before it, in proportion to time.
//!
//! The error μ follows from the free-inertial velocity: that of the swing, propagated through the
//! stance without aids.  Linearly weighted interpolation (LWI) takes its mean over the stance, and
//! the velocity in the stance becomes the free-inertial velocity less μ.  The residual velocity (RV)
//! is the value at the first sample of the stance, and the velocity in the stance is that of the
//! filter.  In the swing from `t_start` to `t_end`,
//!
//! ```text
//! v' = v - μ (t - t_start) / (t_end - t_start)
//! ```
//!
//! and the position is integrated from v'.  A swing without a stance after it is unchanged.
//!
//! # References
//! Abdulrahim, Moore, Hide, Hill, "Understanding the Performance of Zero Velocity Updates in
//! MEMS-based Pedestrian Navigation": approaches 2, 3, 5 and 6.

use std::ops::Range;

use nalgebra::Vector3;

use crate::settings::{choices, settings};
use crate::types::trajectory::Trajectory;

choices! {
    /// Velocity that is taken off the swing before a stance (Abdulrahim et al.).
    pub enum CorrectionKind {
        /// None.
        None = "none",
        /// The mean over the stance: linearly weighted interpolation.
        LinearlyWeighted = "lwi",
        /// That at the first sample of the stance: residual velocity.
        ResidualVelocity = "rv",
    }
}

settings! {
    /// Correction of whole gait cycles, after the filter (Abdulrahim et al.).
    ///
    /// The velocity error found in a stance is taken off the swing before it in proportion to time,
    /// and the position is integrated again.  The uncertainties stay those of the filter.  Needs
    /// the whole recording.
    pub struct CorrectionConfig: "correction" {
        /// Velocity that is taken off.
        kind: CorrectionKind = CorrectionKind::None;
    }
}

/// Corrects velocity and position of a whole track, given the free-inertial velocity (n, m/s) of
/// each row.
pub(crate) fn correct(
    kind: CorrectionKind,
    trajectory: &mut Trajectory,
    free_inertial: &[Vector3<f64>],
) {
    let mut velocity = free_inertial.to_vec();
    let mut swing_start = 0;
    for stance in stances(&trajectory.zero_velocity) {
        let error = match kind {
            CorrectionKind::None => return,
            CorrectionKind::LinearlyWeighted => {
                free_inertial[stance.clone()].iter().sum::<Vector3<f64>>() / length(&stance)
            }
            CorrectionKind::ResidualVelocity => free_inertial[stance.start],
        };
        let (start, end) = (trajectory.time[swing_start], trajectory.time[stance.start]);
        let swing = swing_start..stance.start;
        for (velocity, time) in velocity[swing.clone()].iter_mut().zip(&trajectory.time[swing]) {
            *velocity -= error * ((time - start) / (end - start));
        }
        for (velocity, filtered) in
            velocity[stance.clone()].iter_mut().zip(&trajectory.velocity[stance.clone()])
        {
            *velocity = if kind == CorrectionKind::LinearlyWeighted {
                *velocity - error
            } else {
                (*filtered).into()
            };
        }
        swing_start = stance.end - 1;
    }
    integrate(trajectory, &velocity);
}

/// Runs of rows in stance.
fn stances(zero_velocity: &[bool]) -> impl Iterator<Item = Range<usize>> {
    let mut end = 0;
    std::iter::from_fn(move || {
        let start = end + zero_velocity[end..].iter().position(|&stance| stance)?;
        end = zero_velocity[start..]
            .iter()
            .position(|&stance| !stance)
            .map_or(zero_velocity.len(), |n| start + n);
        Some(start..end)
    })
}

#[expect(clippy::cast_precision_loss, reason = "a stance has fewer than 2^52 samples")]
fn length(stance: &Range<usize>) -> f64 {
    stance.len() as f64
}

/// Replaces the velocities and integrates the position again, by the trapezoid, from where the
/// track begins.
fn integrate(trajectory: &mut Trajectory, velocity: &[Vector3<f64>]) {
    let Some(first) = trajectory.position.first() else { return };
    let mut position = Vector3::from(*first);
    for k in 0..velocity.len() {
        if k > 0 {
            let dt = trajectory.time[k] - trajectory.time[k - 1];
            position += 0.5 * dt * (velocity[k - 1] + velocity[k]);
        }
        trajectory.position[k] = position.into();
        trajectory.velocity[k] = velocity[k].into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rest, a swing of `swing` samples with constant acceleration that ends `error` too fast, a
    /// stance, and half a swing; samples at 100 Hz.
    fn track(swing: usize, error: f64) -> (Trajectory, Vec<Vector3<f64>>) {
        let mut trajectory = Trajectory::default();
        let mut free_inertial = Vec::new();
        for k in 0..swing + 30 {
            let (moving, stance) =
                (k > 10 && k < 10 + swing, (10 + swing..20 + swing).contains(&k));
            let share = (f64::from(u32::try_from(k).unwrap()) - 10.0)
                / f64::from(u32::try_from(swing).unwrap());
            let v = if moving {
                error * share
            } else if stance {
                error
            } else {
                0.0
            };
            trajectory.time.push(0.01 * f64::from(u32::try_from(k).unwrap()));
            trajectory.position.push([0.0; 3]);
            trajectory.velocity.push([if stance { 0.0 } else { v }, 0.0, 0.0]);
            trajectory.zero_velocity.push(k <= 10 || stance);
            free_inertial.push(Vector3::new(v, 0.0, 0.0));
        }
        (trajectory, free_inertial)
    }

    #[test]
    fn a_velocity_error_in_proportion_to_time_is_removed() {
        for kind in [CorrectionKind::LinearlyWeighted, CorrectionKind::ResidualVelocity] {
            let (mut trajectory, free_inertial) = track(40, 0.3);
            correct(kind, &mut trajectory, &free_inertial);
            for (velocity, position) in trajectory.velocity.iter().zip(&trajectory.position) {
                assert!(
                    velocity[0].abs() < 1e-12 && position[0].abs() < 1e-12,
                    "{kind:?} {velocity:?}"
                );
            }
        }
    }

    #[test]
    fn the_mean_and_the_first_velocity_of_a_drifting_stance_differ() {
        let drifting = |kind| {
            let (mut trajectory, mut free_inertial) = track(40, 0.3);
            for (k, velocity) in free_inertial[50..60].iter_mut().enumerate() {
                velocity.x += 0.01 * f64::from(u32::try_from(k).unwrap());
            }
            correct(kind, &mut trajectory, &free_inertial);
            trajectory
        };
        let (lwi, rv) = (
            drifting(CorrectionKind::LinearlyWeighted),
            drifting(CorrectionKind::ResidualVelocity),
        );
        // The mean of 0.00, 0.01, ... 0.09 is 0.045; half of the swing of 0.4 s moves that far too
        // little.
        assert!((lwi.velocity[50][0] + 0.045).abs() < 1e-12);
        assert!(
            (lwi.position[49][0] - (-0.045 * 0.39 * 0.39 / 0.4 / 2.0)).abs() < 1e-9,
            "{:?}",
            lwi.position[49]
        );
        assert!(rv.velocity[50][0].abs() < 1e-12 && rv.position[49][0].abs() < 1e-12);
        assert!(rv.velocity[59][0].abs() < 1e-12);
    }

    #[test]
    fn a_swing_without_a_stance_after_it_is_unchanged() {
        let (mut trajectory, mut free_inertial) = track(40, 0.0);
        free_inertial[65].x = 0.5;
        correct(CorrectionKind::ResidualVelocity, &mut trajectory, &free_inertial);
        assert!((trajectory.velocity[65][0] - 0.5).abs() < 1e-12);
    }
}
