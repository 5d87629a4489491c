//! Corrections of new_unchecked gait cycles: the velocity that a stance finds wrong is taken off
//! the swing before it in proportion to time.
//!
//! What is wrong, μ, is read from the unaided velocity: that of the swing, carried on by the
//! strapdown through the stance as if the stance told nothing.  Linearly weighted interpolation
//! (LWI) takes its mean over the stance, and leaves `v - μ` of the unaided velocity in the stance;
//! the residual velocity (RV) is its value at the stance's first sample, and the velocity in the
//! stance is the one that the filter made of it.  In the swing from `t_start` to `t_end`,
//!
//! ```text
//! v' = v - μ (t - t_start) / (t_end - t_start)
//! ```
//!
//! and the position is integrated again from v'.  A swing that no stance follows stays as it is.
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

/// Corrects velocity and position of a new_unchecked track, given the unaided velocity (n, m/s) of
/// each row.
pub(crate) fn correct(kind: CorrectionKind, trajectory: &mut Trajectory, unaided: &[Vector3<f64>]) {
    let mut velocity = unaided.to_vec();
    let mut swing_start = 0;
    for stance in stances(&trajectory.zero_velocity) {
        let wrong = match kind {
            CorrectionKind::None => return,
            CorrectionKind::LinearlyWeighted => {
                unaided[stance.clone()].iter().sum::<Vector3<f64>>() / length(&stance)
            }
            CorrectionKind::ResidualVelocity => unaided[stance.start],
        };
        let (start, end) = (trajectory.time[swing_start], trajectory.time[stance.start]);
        let swing = swing_start..stance.start;
        for (velocity, time) in velocity[swing.clone()].iter_mut().zip(&trajectory.time[swing]) {
            *velocity -= wrong * ((time - start) / (end - start));
        }
        for (velocity, filtered) in
            velocity[stance.clone()].iter_mut().zip(&trajectory.velocity[stance.clone()])
        {
            *velocity = if kind == CorrectionKind::LinearlyWeighted {
                *velocity - wrong
            } else {
                (*filtered).into()
            };
        }
        swing_start = stance.end - 1;
    }
    integrate(trajectory, &velocity);
}

/// Runs of rows at rest.
fn stances(zero_velocity: &[bool]) -> impl Iterator<Item = Range<usize>> {
    let mut end = 0;
    std::iter::from_fn(move || {
        let start = end + zero_velocity[end..].iter().position(|&rests| rests)?;
        end = zero_velocity[start..]
            .iter()
            .position(|&rests| !rests)
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

    /// Rest, a swing of `swing` samples with constant acceleration that ends `wrong` too fast, a
    /// stance, and half a swing; samples at 100 Hz.
    fn track(swing: usize, wrong: f64) -> (Trajectory, Vec<Vector3<f64>>) {
        let mut trajectory = Trajectory::default();
        let mut unaided = Vec::new();
        for k in 0..swing + 30 {
            let (moving, stance) =
                (k > 10 && k < 10 + swing, (10 + swing..20 + swing).contains(&k));
            let share = (f64::from(u32::try_from(k).unwrap()) - 10.0)
                / f64::from(u32::try_from(swing).unwrap());
            let v = if moving {
                wrong * share
            } else if stance {
                wrong
            } else {
                0.0
            };
            trajectory.time.push(0.01 * f64::from(u32::try_from(k).unwrap()));
            trajectory.position.push([0.0; 3]);
            trajectory.velocity.push([if stance { 0.0 } else { v }, 0.0, 0.0]);
            trajectory.zero_velocity.push(k <= 10 || stance);
            unaided.push(Vector3::new(v, 0.0, 0.0));
        }
        (trajectory, unaided)
    }

    #[test]
    fn a_velocity_that_grew_in_proportion_to_time_is_taken_off_whole() {
        for kind in [CorrectionKind::LinearlyWeighted, CorrectionKind::ResidualVelocity] {
            let (mut trajectory, unaided) = track(40, 0.3);
            correct(kind, &mut trajectory, &unaided);
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
            let (mut trajectory, mut unaided) = track(40, 0.3);
            for (k, velocity) in unaided[50..60].iter_mut().enumerate() {
                velocity.x += 0.01 * f64::from(u32::try_from(k).unwrap());
            }
            correct(kind, &mut trajectory, &unaided);
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
    fn a_swing_that_no_stance_follows_stays_as_it_is() {
        let (mut trajectory, mut unaided) = track(40, 0.0);
        unaided[65].x = 0.5;
        correct(CorrectionKind::ResidualVelocity, &mut trajectory, &unaided);
        assert!((trajectory.velocity[65][0] - 0.5).abs() < 1e-12);
    }
}
