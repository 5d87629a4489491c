//! Gravity update: in stance, where the accelerometer reads gravity alone, it indicates roll and
//! pitch.
//!
//! The indicated tilt is wrong by the accelerometer bias, so attitude and bias are observed together.

use crate::aiding::accelerometer_attitude::{self, AttitudeIndication};
use crate::aiding::aid::{Aid, Epoch, Outcome};
use crate::filter::error_state::{Block, LinearMap};
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::initial_covariance::tilt_of_accel_bias;
use crate::filter::recorder::FilterRecorder;
use crate::filter::settings::{AttitudeUpdate, FilterConfig, FilterKind};
use crate::ins::strapdown::StrapdownStep;
use crate::math::simd::Simd;
use crate::types::sample::ImuSample;

/// Roll and pitch from the direction of gravity.
#[derive(Clone, Debug)]
pub(crate) struct GravityTilt {
    indication: AttitudeIndication,
}

impl GravityTilt {
    /// None unless the settings ask for it; gravity in m/s².
    pub(crate) fn new(config: &FilterConfig, gravity: f64) -> Option<Self> {
        let is_used =
            config.attitude_update == AttitudeUpdate::Gravity && config.kind == FilterKind::Kf;
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
        let indicated = accelerometer_attitude::indicated(&step.attitude, &force).tilt;
        let tilt = tilt_of_accel_bias(&step.attitude, self.indication.gravity());
        filter.couple(&-tilt, recorder);
        let mut errors =
            self.indication.observe(filter, indicated.into_iter().enumerate(), recorder);
        filter.couple(&tilt, recorder);
        errors.add_transformed(filter.simd, Block::Attitude, Block::AccelBias, &tilt);
        filter.estimate.correct(filter.simd, &errors);
        Outcome::Accepted
    }
}

impl Aid for GravityTilt {
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
