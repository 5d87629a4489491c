//! Accelerometer attitude as published (IAA): roll, pitch and, where the formula has a value, a
//! heading.
//!
//! The accelerometer bias is not part of the published observation.
//!
//! # References
//! Wang, Liu, Sun, Cai, Cheng, "Heading Calibration for Foot-Mounted Inertial Pedestrian-Positioning
//! Systems Based on Accelerometer Attitude", Electronics 8(12):1405, 2019: eq. 17.

use nalgebra::Vector3;

use crate::aiding::accelerometer_attitude::{AttitudeIndicator, AttitudeMethod, indicated};
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::filter::settings::AttitudeUpdate;
use crate::ins::strapdown::StrapdownStep;
use crate::math::simd::Simd;

/// Index of the up axis of n.
const UP: usize = 2;

/// Roll, pitch and the published heading.
#[derive(Clone, Debug)]
pub(crate) struct Iaa;

impl AttitudeMethod for Iaa {
    const UPDATE: AttitudeUpdate = AttitudeUpdate::Iaa;

    fn correct<S: Simd>(
        indicator: &AttitudeIndicator,
        filter: &mut ErrorStateFilter<S>,
        step: &StrapdownStep,
        force: &Vector3<f64>,
        recorder: &mut impl FilterRecorder,
    ) {
        let attitude = indicated(&step.attitude, force);
        let heading = attitude.heading.map(|heading| (UP, heading));
        let axes = attitude.tilt.into_iter().enumerate().chain(heading);
        let errors = indicator.observe(filter, axes, recorder);
        filter.estimate.correct(filter.simd, &errors);
    }
}
