//! The attitude that the accelerometer indicates at rest, against the computed one.
//!
//! Roll and pitch follow from the direction of the specific force, which at rest points up.  Removed
//! from the computed attitude, they leave a rotation about the vertical, but for the errors: with c
//! the matrix `C_est C_x C_y`, the tilt errors are `φ_x = c_23`, `φ_y = -c_13`.
//!
//! Wang et al. 2019 also read a heading error from it, `φ_z = -asin sqrt(c_21² + c_22² - 1)` (their
//! eq. 17; the signs here are those of truth minus estimate).  The rows of a rotation matrix have
//! length one, so the radicand is `-c_23²` and there is no such angle: an accelerometer does not
//! observe the heading.  The formula has a value only where the first-order update has left an
//! attitude matrix that is no rotation, and it measures how far the matrix is from one.
//!
//! # References
//! Wang, Liu, Sun, Cai, Cheng, "Heading Calibration for Foot-Mounted Inertial Pedestrian-Positioning
//! Systems Based on Accelerometer Attitude", Electronics 8(12):1405, 2019: eqs. 10, 16, 17.

use std::marker::PhantomData;

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::aiding::aid::{Aid, Epoch, Outcome};
use crate::filter::error_state::{Block, ErrorStates};
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::filter::settings::{AttitudeUpdate, FilterConfig, FilterKind};
use crate::ins::strapdown::StrapdownStep;
use crate::math::simd::Simd;
use crate::types::sample::ImuSample;

/// Radicand below which a matrix is a rotation to rounding.
const ROUNDING: f64 = 1.0e-12;

/// Attitude errors, truth minus estimate, from the accelerometer, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct IndicatedAttitude {
    /// About n x and n y.
    pub(crate) tilt: [f64; 2],
    /// About n z, as published; none where the radicand is not positive.
    pub(crate) heading: Option<f64>,
}

/// Compares a computed attitude matrix with the specific force (b, m/s²) of a foot at rest.
pub(crate) fn indicated(
    attitude: &Matrix3<f64>,
    specific_force: &Vector3<f64>,
) -> IndicatedAttitude {
    let f = specific_force;
    let roll = f.y.atan2(f.z);
    let pitch = (-f.x).atan2(f.y.hypot(f.z));
    let level_to_sensor = Rotation3::from_euler_angles(roll, pitch, 0.0).inverse();
    let c = attitude * level_to_sensor.matrix();
    let radicand = c.m21.powi(2) + c.m22.powi(2) - 1.0;
    let heading = (radicand > ROUNDING).then(|| -radicand.sqrt().min(1.0).asin());
    IndicatedAttitude { tilt: [c.m23, -c.m13], heading }
}

/// How the indicated attitude corrects the filter.
pub(crate) trait AttitudeMethod {
    /// The value of the setting that selects it.
    const UPDATE: AttitudeUpdate;

    /// Updates the filter with the specific force (b, m/s²) at the end of a step, which is gravity
    /// alone.
    fn correct<S: Simd>(
        indicator: &AttitudeIndicator,
        filter: &mut ErrorStateFilter<S>,
        step: &StrapdownStep,
        force: &Vector3<f64>,
        recorder: &mut impl FilterRecorder,
    );
}

/// When and how well the accelerometer indicates the attitude.
#[derive(Clone, Debug)]
pub(crate) struct AttitudeIndicator {
    /// Difference of the specific force from gravity up to which it is taken for gravity, m/s².
    threshold: f64,
    variance: f64,
    gate: f64,
    /// Gravity, m/s².
    pub(crate) gravity: f64,
}

impl AttitudeIndicator {
    /// The specific force (b, m/s²) without its bias, if it is gravity alone.
    fn gravity_reaction<S>(
        &self,
        filter: &ErrorStateFilter<S>,
        sample: &ImuSample,
    ) -> Option<Vector3<f64>> {
        let force = sample.specific_force - filter.estimate.accel_bias;
        ((force.norm() - self.gravity).abs() < self.threshold).then_some(force)
    }

    /// Observes attitude errors (rad) about some axes of n, one after the other; returns the
    /// estimated errors, which are not fed back.
    pub(crate) fn observe<S: Simd>(
        &self,
        filter: &mut ErrorStateFilter<S>,
        axes: impl Iterator<Item = (usize, f64)>,
        recorder: &mut impl FilterRecorder,
    ) -> ErrorStates {
        let mut errors = ErrorStates::default();
        for (axis, indicated) in axes {
            let innovation = indicated - errors.block(Block::Attitude)[axis];
            let state = (Block::Attitude, axis);
            let observed =
                filter.observe_axis(state, innovation, self.variance, self.gate, recorder);
            errors += observed.unwrap_or_default();
        }
        errors
    }
}

/// Corrects the attitude in stance, where the accelerometer reads gravity alone.
#[derive(Clone, Debug)]
pub(crate) struct AccelerometerAttitude<M> {
    indicator: AttitudeIndicator,
    method: PhantomData<M>,
}

impl<M: AttitudeMethod> AccelerometerAttitude<M> {
    /// None unless the settings select the method; gravity in m/s².
    pub(crate) fn new(config: &FilterConfig, gravity: f64) -> Option<Self> {
        let is_used = config.attitude_update == M::UPDATE && config.kind == FilterKind::Kf;
        let threshold = config.attitude_threshold.filter(|_| is_used)?;
        let (variance, gate) = (config.attitude_std.powi(2), config.chi2_gate);
        let indicator = AttitudeIndicator { threshold, variance, gate, gravity };
        Some(Self { indicator, method: PhantomData })
    }

    /// It owns the step, so that those of samples without this update may stay in registers.
    #[inline(never)]
    fn apply<S: Simd>(
        &self,
        filter: &mut ErrorStateFilter<S>,
        step: StrapdownStep,
        sample: &ImuSample,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        let Some(force) = self.indicator.gravity_reaction(filter, sample) else {
            return Outcome::None;
        };
        M::correct(&self.indicator, filter, &step, &force, recorder);
        Outcome::Accepted
    }
}

impl<M: AttitudeMethod> Aid for AccelerometerAttitude<M> {
    fn observes(&self) -> Option<Block> {
        Some(Block::Attitude)
    }

    #[inline(always)]
    fn update<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        epoch: &Epoch<'_>,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        if !epoch.stance || epoch.interval.step.dt <= 0.0 {
            return Outcome::None;
        }
        self.apply(filter, epoch.interval.step, epoch.sample, recorder)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    use super::*;
    use crate::math::rotation;

    proptest! {
        #[test]
        fn a_small_tilt_is_found_and_no_heading(
            r in -1.4..1.4,
            p in -1.4..1.4,
            y in -3.0..3.0,
            e in [-0.01..0.01, -0.01..0.01, -0.01..0.01],
        ) {
            let truth = UnitQuaternion::from_euler_angles(r, p, y);
            let error = Vector3::from(e);
            let estimate = rotation::exp(&-error) * truth;
            let observed =
                indicated(
                    estimate.to_rotation_matrix().matrix(),
                    &(truth.inverse() * Vector3::new(0.0, 0.0, 9.8)),
                );
            prop_assert!((observed.tilt[0] - error.x).abs() < 3e-4);
            prop_assert!((observed.tilt[1] - error.y).abs() < 3e-4);
            prop_assert_eq!(observed.heading, None);
        }

        #[test]
        fn a_heading_appears_only_where_the_matrix_is_no_rotation(y in -3.0..3.0, rate in 1e-4..0.1) {
            let turn = rate * Vector3::x();
            let truth = UnitQuaternion::from_euler_angles(0.0, 0.0, y);
            let first_order =
                truth.to_rotation_matrix().matrix() * (Matrix3::identity() + rotation::cross_matrix(&turn));
            let up = rotation::exp(&-turn) * Vector3::z();
            let heading = indicated(&first_order, &up).heading;
            let stretch = first_order.row(1).norm_squared() - 1.0;
            let tilted = indicated(&first_order, &up).tilt[0].powi(2);
            prop_assert_eq!(heading.is_some(), stretch - tilted > ROUNDING);
            if let Some(heading) = heading {
                prop_assert!((heading.sin().powi(2) - (stretch - tilted)).abs() < 1e-9);
                prop_assert!(heading < 0.0);
            }
        }
    }
}
