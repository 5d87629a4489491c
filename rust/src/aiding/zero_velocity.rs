//! Zero-velocity updates (ZUPT).
//!
//! In stance the velocity of the sensor is that of a foot that rotates about a point on the ground.
//!
//! # References
//! Wu, Lu, Chen, "Research on Foot-Mounted Personal Navigation Algorithm based on MEMS Inertial
//! Sensors": eq. 6.

use nalgebra::{Matrix3, Vector3};

use crate::aiding::aid::{Aid, Epoch, Outcome};
use crate::aiding::lever_arm::LeverArmEstimator;
use crate::aiding::zupt_correlation::ZuptCorrelation;
use crate::filter::error_state::Block;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::filter::settings::{FilterConfig, FilterKind};
use crate::math::rotation_kernels;
use crate::math::simd::Simd;

/// Zero-velocity updates with the lever arm of the sensor and the correlation within a stance.
#[derive(Clone, Debug)]
pub(crate) struct ZeroVelocity {
    kind: FilterKind,
    variance: f64,
    lever_variance: f64,
    correlation_of_stance: f64,
    contact_rate: f64,
    gate: f64,
    rejection_limit: f64,
    lever_arm: LeverArmEstimator,
    correlation: ZuptCorrelation,
    /// Variance that the position gains in the next prediction, m².
    position_noise: f64,
    /// Time in stance since the last accepted update, s.
    rejected_for: f64,
}

impl ZeroVelocity {
    pub(crate) fn new(config: &FilterConfig) -> Self {
        Self {
            kind: config.kind,
            variance: config.zero_velocity_std.powi(2),
            lever_variance: config.zupt_lever_std.powi(2),
            correlation_of_stance: config.zupt_correlation,
            contact_rate: config.contact_rate,
            gate: config.chi2_gate,
            rejection_limit: config.rejection_limit,
            lever_arm: LeverArmEstimator::default(),
            correlation: ZuptCorrelation::default(),
            position_noise: 0.0,
            rejected_for: 0.0,
        }
    }

    /// Variance that the position gains in the next prediction by the correlation of the updates
    /// before, m².
    #[inline(always)]
    pub(crate) fn position_noise(&self) -> f64 {
        self.position_noise
    }

    /// Variance that the position has yet to gain, m²; it counts as gained.
    pub(crate) fn take_pending_position_noise(&mut self) -> f64 {
        self.correlation.take_position_variance()
    }

    /// Updates the filter with the velocity of a foot on the ground that has an `angular_rate` (b,
    /// rad/s), over an interval of `dt` (s).
    ///
    /// After rejections for longer than a limit the update is accepted by force: the variance of the
    /// velocity grows by its squared innovation first.
    #[inline(always)]
    pub(crate) fn apply<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        angular_rate: &Vector3<f64>,
        dt: f64,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        let velocity_b = self.lever_arm.velocity(angular_rate);
        let attitude = &filter.estimate.nav.attitude;
        let velocity = rotation_kernels::rotate(filter.simd, attitude, &velocity_b);
        let variance = self.variance + self.lever_variance * angular_rate.norm_squared();
        let innovation = velocity - filter.estimate.nav.velocity;
        if self.rejected_for > self.rejection_limit {
            filter.inflate(Block::Velocity, innovation.norm_squared(), recorder);
        }
        let r = Matrix3::from_diagonal_element(variance);
        let update = filter.observe(Block::Velocity, &innovation, &r, self.gate, recorder);
        self.rejected_for = if update.accepted { 0.0 } else { self.rejected_for + dt };
        if update.accepted {
            self.correlation.record(variance);
        }
        update.into()
    }

    /// Sets the velocity to zero and learns nothing else from it: dead reckoning.
    fn reset_velocity<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        filter.reset_velocity(self.variance, recorder);
        self.correlation.record(self.variance);
        Outcome::Accepted
    }
}

impl Aid for ZeroVelocity {
    fn observes(&self) -> Option<Block> {
        (self.kind != FilterKind::Ins).then_some(Block::Velocity)
    }

    #[inline(always)]
    fn prepare(&mut self, epoch: &Epoch<'_>, simd: impl Simd) -> bool {
        self.lever_arm.step(simd, epoch.interval, epoch.stance, self.contact_rate);
        self.position_noise = self.correlation.take_position_variance();
        if !epoch.stance {
            self.correlation.propagate(epoch.interval.step.dt, self.correlation_of_stance);
        }
        false
    }

    #[inline(always)]
    fn update<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        epoch: &Epoch<'_>,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        if !epoch.stance {
            return Outcome::None;
        }
        let dt = epoch.interval.step.dt;
        let outcome = match self.kind {
            _ if dt <= 0.0 => Outcome::None,
            FilterKind::Kf => self.apply(filter, &epoch.interval.angular_rate, dt, recorder),
            FilterKind::Dr => self.reset_velocity(filter, recorder),
            FilterKind::Ins => Outcome::None,
        };
        if outcome != Outcome::Accepted {
            self.correlation.propagate(dt, self.correlation_of_stance);
        }
        outcome
    }

    fn interrupt(&mut self) {
        self.lever_arm.interrupt();
        self.correlation = ZuptCorrelation::default();
        self.rejected_for = 0.0;
    }
}
