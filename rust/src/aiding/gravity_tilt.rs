//! Gravity update: in stance, where the accelerometer reads gravity alone, it indicates roll and
//! pitch.
//!
//! The indicated tilt is wrong by the accelerometer bias, so attitude and bias are observed together.

use nalgebra::Vector3;

use crate::aiding::accelerometer_attitude::{AttitudeIndicator, AttitudeMethod, indicated};
use crate::filter::error_state::{Block, LinearMap};
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::initial_covariance::tilt_of_accel_bias;
use crate::filter::recorder::FilterRecorder;
use crate::filter::settings::AttitudeUpdate;
use crate::ins::strapdown::StrapdownStep;
use crate::math::simd::Simd;

/// Roll and pitch from the direction of gravity.
#[derive(Clone, Debug)]
pub(crate) struct GravityTilt;

impl AttitudeMethod for GravityTilt {
    const UPDATE: AttitudeUpdate = AttitudeUpdate::Gravity;

    fn correct<S: Simd>(
        indicator: &AttitudeIndicator,
        filter: &mut ErrorStateFilter<S>,
        step: &StrapdownStep,
        force: &Vector3<f64>,
        recorder: &mut impl FilterRecorder,
    ) {
        let axes = indicated(&step.attitude, force).tilt.into_iter().enumerate();
        let tilt = tilt_of_accel_bias(&step.attitude, indicator.gravity);
        filter.couple(&-tilt, recorder);
        let mut errors = indicator.observe(filter, axes, recorder);
        filter.couple(&tilt, recorder);
        errors.add_transformed(filter.simd, Block::Attitude, Block::AccelBias, &tilt);
        filter.estimate.correct(filter.simd, &errors);
    }
}
