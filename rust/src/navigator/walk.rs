//! One foot on its way: the algorithm that is run for every sample.

use crate::config::FilterConfig;
use crate::detector::Decision;
use crate::error::NumericalError;
use crate::filter::{ErrorStateFilter, Estimate};
use crate::health::{HealthMonitor, Reasons};
use crate::navigator::Solution;
use crate::sample::ImuSample;
use crate::strapdown::{Increments, NavState, Step, Strapdown};

/// The filter, with what it must remember from one sample to the next.
#[derive(Clone)]
pub(super) struct Walk {
    pub(super) filter: ErrorStateFilter,
    previous: ImuSample,
    increments: Increments,
    still_for: f64,
    rejected_for: f64,
}

impl Walk {
    pub(super) fn new(filter: ErrorStateFilter, sample: &ImuSample) -> Self {
        Self { filter, previous: *sample, increments: Increments::NONE, still_for: 0.0, rejected_for: 0.0 }
    }

    /// The algorithm: strapdown, prediction, and what the detector and a foot at rest know.
    #[inline]
    pub(super) fn update(
        &mut self,
        strapdown: &Strapdown,
        config: &FilterConfig,
        monitor: &mut HealthMonitor,
        sample: &ImuSample,
        events: Reasons,
        decision: &Decision,
    ) -> Result<Solution, NumericalError> {
        let elapsed = sample.time - self.previous.time;
        if elapsed > monitor.longest_gap() {
            self.resume(sample, elapsed);
            monitor.lose();
        }
        let step = self.step(strapdown, sample, events);
        if !decision.stationary {
            self.rejected_for = 0.0;
        } else if step.dt > 0.0 {
            monitor.zero_velocity(sample.time, self.zero_velocity(config, sample));
        }
        if self.rests(config, sample, step.dt, events) {
            monitor.zero_angular_rate(self.filter.zero_angular_rate(sample, config.zero_angular_rate_std).accepted);
        }
        self.filter.check()?;
        Ok(self.solution(decision, monitor.assess(sample.time, events, self.filter.tilt_std())))
    }

    #[inline]
    pub(super) fn solution(&self, decision: &Decision, reasons: Reasons) -> Solution {
        Solution {
            estimate: self.filter.estimate,
            position_std: self.filter.position_std(),
            zero_velocity: decision.stationary,
            reasons,
        }
    }

    /// Strapdown and prediction over the interval that `sample` ends.
    #[inline]
    pub(super) fn step(&mut self, strapdown: &Strapdown, sample: &ImuSample, events: Reasons) -> Step {
        let bridged = strapdown.bridged(&self.previous, sample);
        let step = self.propagate(strapdown, sample);
        self.filter.predict(&step, events.contains(Reasons::CLIPPED), bridged);
        step
    }

    /// Goes on after a gap that is too long to be bridged.
    fn resume(&mut self, sample: &ImuSample, elapsed: f64) {
        self.filter.resume(sample.time, elapsed);
        *self = Self::new(self.filter.clone(), sample);
    }

    /// Strapdown over the interval that `sample` ends.
    #[inline]
    pub(super) fn propagate(&mut self, strapdown: &Strapdown, sample: &ImuSample) -> Step {
        let Estimate { gyro_bias, accel_bias, nav } = &mut self.filter.estimate;
        let now = strapdown.increments(&self.previous, sample).without_bias(gyro_bias, accel_bias);
        let step = strapdown.advance(nav, &self.increments, &now);
        nav.time = sample.time;
        self.previous = *sample;
        self.increments = now;
        step
    }

    /// Where the strapdown alone leads from here.
    pub(super) fn ahead<'a>(
        &self,
        strapdown: &Strapdown,
        longest_gap: f64,
        samples: impl Iterator<Item = &'a ImuSample>,
    ) -> NavState {
        let mut walk = self.clone();
        for sample in samples {
            let elapsed = sample.time - walk.previous.time;
            if elapsed > longest_gap {
                walk.resume(sample, elapsed);
            }
            walk.propagate(strapdown, sample);
        }
        walk.filter.estimate.nav
    }

    /// Zero-velocity update; a foot that stays still against the filter's belief is right in the end.
    #[inline]
    fn zero_velocity(&mut self, config: &FilterConfig, sample: &ImuSample) -> bool {
        let rolling = config.zero_velocity_lever.powi(2) * self.angular_rate_squared(sample);
        let variance = config.zero_velocity_std.powi(2) + rolling;
        let accepted = self.filter.zero_velocity(variance, self.rejected_for > config.rejection_limit).accepted;
        self.rejected_for = if accepted { 0.0 } else { self.rejected_for + self.increments.dt };
        accepted
    }

    /// Whether the foot has not turned for so long that the gyroscope reads its own bias.
    #[inline]
    fn rests(&mut self, config: &FilterConfig, sample: &ImuSample, dt: f64, events: Reasons) -> bool {
        let seen = !events.contains(Reasons::GAP);
        let still = seen && self.angular_rate_squared(sample) < config.rest_rate.powi(2);
        self.still_for = if still { self.still_for + dt } else { 0.0 };
        config.zero_angular_rate && dt > 0.0 && self.still_for >= config.rest_duration
    }

    fn angular_rate_squared(&self, sample: &ImuSample) -> f64 {
        (sample.angular_rate - self.filter.estimate.gyro_bias).norm_squared()
    }
}
