//! Inertial navigation sample by sample: the mechanization over each interval between two samples.

use crate::ins::interval::Interval;
use crate::ins::strapdown::{Increments, Strapdown};
use crate::math::simd::Simd;
use crate::types::sample::ImuSample;
use crate::types::solution::Estimate;

/// The mechanization, with what it keeps from one sample to the next.
#[derive(Clone, Debug)]
pub(crate) struct Ins<S> {
    strapdown: Strapdown,
    previous: ImuSample,
    /// Of the interval that the previous sample ended.
    increments: Increments,
    simd: S,
}

impl<S: Simd> Ins<S> {
    /// Integrates from `sample` on.
    pub(crate) fn new(simd: S, strapdown: Strapdown, sample: &ImuSample) -> Self {
        Self { strapdown, previous: *sample, increments: Increments::NONE, simd }
    }

    /// Time from the previous sample to `sample`, s.
    #[inline]
    pub(crate) fn elapsed(&self, sample: &ImuSample) -> f64 {
        sample.time - self.previous.time
    }

    /// Integrates from `sample` on, after a gap.
    pub(crate) fn restart(&mut self, sample: &ImuSample) {
        *self = Self::new(self.simd, self.strapdown, sample);
    }

    /// Propagates an estimate over the interval that `sample` ends.
    #[inline(always)]
    pub(crate) fn propagate(&mut self, estimate: &mut Estimate, sample: &ImuSample) -> Interval {
        let gap_duration = self.strapdown.gap_duration(&self.previous, sample);
        let Estimate { gyro_bias, accel_bias, nav } = estimate;
        let before = nav.velocity;
        let unbiased = sample.without_bias(gyro_bias, accel_bias);
        let previous = self.previous.without_bias(gyro_bias, accel_bias);
        let now = self.strapdown.increments(&previous, &unbiased);
        let step = self.strapdown.advance_with(self.simd, nav, &self.increments, &now);
        nav.time = sample.time;
        let velocity_change = nav.velocity - before;
        self.previous = *sample;
        self.increments = now;
        Interval { step, gap_duration, angular_rate: unbiased.angular_rate, velocity_change }
    }
}
