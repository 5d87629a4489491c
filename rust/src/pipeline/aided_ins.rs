//! Aided inertial navigation: the algorithm that runs for each sample.

use nalgebra::Vector3;

use crate::aiding::Aids;
use crate::aiding::aid::Epoch;
use crate::detectors::detector::Decision;
use crate::error::NumericalError;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::ins::integration::Ins;
use crate::ins::strapdown::Strapdown;
use crate::math::simd::{Simd, WithSimd};
use crate::pipeline::delay_line::PendingSample;
use crate::pipeline::health_monitor::HealthMonitor;
use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;
use crate::types::solution::Solution;

/// Result of an update beside the estimate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UpdateResult {
    pub(crate) zero_velocity: bool,
    pub(crate) flags: Flags,
}

/// Inertial navigation, the filter that estimates its errors, and the aids that observe them.
#[derive(Clone, Debug)]
pub(crate) struct AidedIns<S> {
    ins: Ins<S>,
    pub(crate) filter: ErrorStateFilter<S>,
    pub(crate) aids: Aids,
    free_inertial: FreeInertialVelocity,
}

/// The velocity (n, m/s) of the swing, propagated through the stance without aids.
#[derive(Clone, Copy, Debug)]
struct FreeInertialVelocity {
    value: Vector3<f64>,
    in_stance: bool,
}

impl FreeInertialVelocity {
    fn new(velocity: Vector3<f64>) -> Self {
        Self { value: velocity, in_stance: false }
    }

    /// Takes the propagated `velocity` and its `change` over the interval.
    #[inline]
    fn step(&mut self, velocity: &Vector3<f64>, change: &Vector3<f64>, stance: bool) {
        let continues = stance && self.in_stance;
        self.value = if continues { self.value + change } else { *velocity };
        self.in_stance = stance;
    }
}

impl<S: Simd> AidedIns<S> {
    /// Starts with the estimate of the filter at `sample`.
    pub(crate) fn new(
        filter: ErrorStateFilter<S>,
        strapdown: Strapdown,
        aids: Aids,
        sample: &ImuSample,
    ) -> Self {
        let free_inertial = FreeInertialVelocity::new(filter.estimate.nav.velocity);
        let ins = Ins::new(filter.simd, strapdown, sample);
        Self { ins, filter, aids, free_inertial }
    }

    /// The algorithm: mechanization, prediction, and the updates of the aids.
    ///
    /// What needs the mechanization alone precedes the prediction, while its numbers are in
    /// registers.
    #[inline(always)]
    pub(crate) fn update(
        &mut self,
        pending: &PendingSample,
        decision: &Decision,
        health: &mut HealthMonitor,
        recorder: &mut impl FilterRecorder,
    ) -> Result<UpdateResult, NumericalError> {
        let PendingSample { sample, flags } = pending;
        if self.ins.elapsed(sample) > health.longest_gap() {
            self.restart(sample, recorder);
            health.mark_lost();
        }
        let interval = self.ins.propagate(&mut self.filter.estimate, sample);
        let stance = decision.stationary && interval.supported_by_ground();
        let velocity = &self.filter.estimate.nav.velocity;
        self.free_inertial.step(velocity, &interval.velocity_change, stance);
        let epoch = Epoch { sample, interval: &interval, stance, flags: *flags };
        let is_due = self.aids.prepare(&epoch, self.filter.simd);
        let (noise, clipped) = (self.aids.position_noise(), flags.contains(Flags::CLIPPED));
        self.filter.predict(&interval, clipped, noise, !is_due, recorder);
        if is_due {
            let outcome = self.aids.update(&mut self.filter, &epoch, recorder);
            health.record_zero_velocity(sample.time, outcome);
            self.filter.check()?;
        } else {
            self.filter.check_prediction()?;
        }
        let flags = health.assess(sample.time, *flags, || self.filter.tilt_std());
        Ok(UpdateResult { zero_velocity: stance, flags })
    }

    /// As [`AidedIns::update`], at a sample at which the foot is known to be at rest.
    #[inline(always)]
    pub(crate) fn update_at_rest(&mut self, sample: &ImuSample) -> Result<(), NumericalError> {
        let interval = self.ins.propagate(&mut self.filter.estimate, sample);
        self.filter.predict(&interval, false, 0.0, false, &mut ());
        self.aids.update_at_rest(&mut self.filter, &interval, sample);
        self.filter.check()
    }

    /// Propagates over samples without updates: those before the first solution.
    pub(crate) fn replay(&mut self, samples: &[ImuSample], recorder: &mut impl FilterRecorder) {
        for sample in samples {
            self.filter.simd.vectorize(Replay { ins: self, sample, recorder });
        }
    }

    /// Restarts after a gap that is too long to be interpolated.
    fn restart(&mut self, sample: &ImuSample, recorder: &mut impl FilterRecorder) {
        self.filter.restart(sample.time, self.ins.elapsed(sample), recorder);
        self.ins.restart(sample);
        self.aids.interrupt();
        self.free_inertial = FreeInertialVelocity::new(self.filter.estimate.nav.velocity);
    }

    /// The velocity without the aids of the present stance, n, m/s.
    #[inline]
    pub(crate) fn free_inertial_velocity(&self) -> &Vector3<f64> {
        &self.free_inertial.value
    }

    /// The solution at the newest sample.
    #[inline]
    pub(crate) fn solution(&self, result: UpdateResult) -> Solution {
        let UpdateResult { zero_velocity, flags } = result;
        let position_std = self.filter.position_std();
        Solution { estimate: self.filter.estimate, position_std, zero_velocity, flags }
    }

    /// The state that the mechanization alone reaches over later samples.
    pub(crate) fn extrapolate<'a>(
        &self,
        longest_gap: f64,
        samples: impl Iterator<Item = &'a ImuSample>,
    ) -> NavState {
        let (mut ins, mut estimate) = (self.ins.clone(), self.filter.estimate);
        for sample in samples {
            if ins.elapsed(sample) > longest_gap {
                ins.restart(sample);
                estimate.nav.velocity = Vector3::zeros();
            }
            ins.propagate(&mut estimate, sample);
        }
        estimate.nav
    }
}

/// See [`AidedIns::replay`].
struct Replay<'a, S, R> {
    ins: &'a mut AidedIns<S>,
    sample: &'a ImuSample,
    recorder: &'a mut R,
}

impl<S: Simd, R: FilterRecorder> WithSimd for Replay<'_, S, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) {
        let Self { ins: AidedIns { ins, filter, .. }, sample, recorder } = self;
        let interval = ins.propagate(&mut filter.estimate, sample);
        filter.predict(&interval, false, 0.0, false, recorder);
    }
}
