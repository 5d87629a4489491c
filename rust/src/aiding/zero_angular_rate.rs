//! Zero-angular-rate updates (ZARU): at rest the gyroscope reads the Earth rate and its bias.

use nalgebra::{Matrix3, Vector3};

use crate::aiding::aid::{Aid, Epoch, Outcome};
use crate::filter::error_state::Block;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::filter::settings::{FilterConfig, FilterKind};
use crate::math::simd::Simd;
use crate::types::health::Flags;
use crate::types::sample::ImuSample;

/// Zero-angular-rate updates while the angular rate has stayed small for long enough.
#[derive(Clone, Debug)]
pub(crate) struct ZeroAngularRate {
    kind: FilterKind,
    variance: f64,
    rest_rate: f64,
    rest_duration: f64,
    gate: f64,
    earth_rate: Vector3<f64>,
    /// Time since the angular rate was last above the limit, s.
    at_rest_for: f64,
    is_due: bool,
}

impl ZeroAngularRate {
    /// None unless the settings ask for it; the Earth rate is in n, rad/s.
    pub(crate) fn new(config: &FilterConfig, earth_rate: Vector3<f64>) -> Option<Self> {
        config.zero_angular_rate.then(|| Self {
            kind: config.kind,
            variance: config.zero_angular_rate_std.powi(2),
            rest_rate: config.rest_rate,
            rest_duration: config.rest_duration,
            gate: config.chi2_gate,
            earth_rate,
            at_rest_for: 0.0,
            is_due: false,
        })
    }

    /// Updates the filter at a sample at which the foot is at rest.
    #[inline(always)]
    pub(crate) fn apply<S: Simd>(
        &self,
        filter: &mut ErrorStateFilter<S>,
        sample: &ImuSample,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        let earth_rate = filter.estimate.nav.attitude.inverse() * self.earth_rate;
        let innovation = sample.angular_rate - earth_rate - filter.estimate.gyro_bias;
        let r = Matrix3::from_diagonal_element(self.variance);
        filter.observe(Block::GyroBias, &innovation, &r, self.gate, recorder).into()
    }
}

impl Aid for ZeroAngularRate {
    fn observes(&self) -> Option<Block> {
        Some(Block::GyroBias)
    }

    #[inline(always)]
    fn prepare(&mut self, epoch: &Epoch<'_>, _: impl Simd) -> bool {
        let dt = epoch.interval.step.dt;
        let below_limit = epoch.interval.angular_rate.norm_squared() < self.rest_rate.powi(2);
        let at_rest = below_limit && !epoch.flags.contains(Flags::GAP);
        self.at_rest_for = if at_rest { self.at_rest_for + dt } else { 0.0 };
        let is_used = self.kind == FilterKind::Kf && dt > 0.0;
        self.is_due = is_used && self.at_rest_for >= self.rest_duration;
        self.is_due
    }

    #[inline(always)]
    fn update<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        epoch: &Epoch<'_>,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        if self.is_due { self.apply(filter, epoch.sample, recorder) } else { Outcome::None }
    }

    fn interrupt(&mut self) {
        self.at_rest_for = 0.0;
    }
}
