//! Accelerometer attitude as published (IAA): roll, pitch and, where the formula has a value, a
//! heading.
//!
//! The accelerometer bias is not part of the published observation.
//!
//! # References
//! Wang, Liu, Sun, Cai, Cheng, "Heading Calibration for Foot-Mounted Inertial Pedestrian-Positioning
//! Systems Based on Accelerometer Attitude", Electronics 8(12):1405, 2019: eq. 17.

use crate::aiding::accelerometer_attitude::{self, AttitudeIndication};
use crate::aiding::aid::{Aid, Epoch, Outcome};
use crate::filter::error_state::Block;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::filter::settings::{AttitudeUpdate, FilterConfig, FilterKind};
use crate::ins::strapdown::StrapdownStep;
use crate::math::simd::Simd;
use crate::types::sample::ImuSample;

/// Index of the up axis of n.
const UP: usize = 2;

/// Roll, pitch and the published heading.
#[derive(Clone, Debug)]
pub(crate) struct Iaa {
    indication: AttitudeIndication,
}

impl Iaa {
    /// None unless the settings ask for it; gravity in m/s².
    pub(crate) fn new(config: &FilterConfig, gravity: f64) -> Option<Self> {
        let is_used =
            config.attitude_update == AttitudeUpdate::Iaa && config.kind == FilterKind::Kf;
        let indication = AttitudeIndication::new(config, gravity).filter(|_| is_used);
        indication.map(|indication| Self { indication })
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
        let Some(force) = self.indication.gravity_reaction(filter, sample) else {
            return Outcome::None;
        };
        let indicated = accelerometer_attitude::indicated(&step.attitude, &force);
        let heading = indicated.heading.map(|heading| (UP, heading));
        let axes = indicated.tilt.into_iter().enumerate().chain(heading);
        let errors = self.indication.observe(filter, axes, recorder);
        filter.estimate.correct(filter.simd, &errors);
        Outcome::Accepted
    }
}

impl Aid for Iaa {
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
