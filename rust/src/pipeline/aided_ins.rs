//! One foot on its way: the algorithm that is run for every sample.

use nalgebra::Vector3;

use crate::aiding::lever_arm::Rolling;
use crate::aiding::zupt_correlation::Footing;
use crate::config::{AttitudeUpdate, FilterConfig, FilterKind};
use crate::detectors::detector::Decision;
use crate::error::NumericalError;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::gait::stride_tracker::StrideTracker;
use crate::ins::interval::Interval;
use crate::ins::strapdown::{Increments, Step, Strapdown};
use crate::math::rotation_kernels;
use crate::math::simd::{Lanes, Work, dispatch};
use crate::pipeline::delay_line::PendingSample;
use crate::pipeline::health_monitor::HealthMonitor;
use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;
use crate::types::solution::Estimate;
use crate::types::solution::Solution;

/// What stays the same for all samples.
pub(crate) struct Setting<'a> {
    pub(crate) strapdown: &'a Strapdown,
    pub(crate) filter: &'a FilterConfig,
}

/// What an update found beside the estimate.
#[derive(Clone, Copy)]
pub(crate) struct Finding {
    pub(crate) zero_velocity: bool,
    pub(crate) flags: Flags,
}

/// The filter, with what it must remember from one sample to the next.
#[derive(Clone)]
pub(crate) struct Walk {
    pub(crate) filter: ErrorStateFilter,
    previous: ImuSample,
    increments: Increments,
    still_for: f64,
    rejected_for: f64,
    unaided: UnaidedVelocity,
    footing: Footing,
    rolling: Rolling,
}

/// The velocity (n, m/s) as it is without what the present stance tells.
#[derive(Clone, Copy)]
struct UnaidedVelocity {
    value: Vector3<f64>,
    in_stance: bool,
}

impl UnaidedVelocity {
    /// The strapdown alone led to `velocity`, by a `gain`.
    #[inline]
    fn step(&mut self, velocity: &Vector3<f64>, gain: &Vector3<f64>, in_stance: bool) {
        let goes_on = in_stance && self.in_stance;
        self.value = if goes_on { self.value + gain } else { *velocity };
        self.in_stance = in_stance;
    }
}

impl Walk {
    pub(crate) fn new(filter: ErrorStateFilter, sample: &ImuSample) -> Self {
        let unaided = UnaidedVelocity { value: filter.estimate.nav.velocity, in_stance: false };
        Self {
            filter,
            previous: *sample,
            increments: Increments::NONE,
            still_for: 0.0,
            rejected_for: 0.0,
            unaided,
            footing: Footing::default(),
            rolling: Rolling::default(),
        }
    }

    /// Goes through samples that came before the walk's first solution; a stride may start where
    /// the foot stood until then.
    #[inline(always)]
    pub(crate) fn through<L: Lanes>(
        mut self,
        strapdown: &Strapdown,
        samples: &[ImuSample],
        strides: Option<&mut StrideTracker>,
    ) -> Self {
        let mut recorder = strides.map(|strides| {
            strides.begin(&self.filter.covariance());
            strides.recorder()
        });
        for sample in samples {
            self.step::<L>(strapdown, sample, Flags::empty(), &mut recorder);
        }
        self
    }

    /// The algorithm: strapdown, prediction, and what the detector and a foot at rest know.
    ///
    /// What only needs the strapdown comes before the prediction, while its numbers are still at
    /// hand.
    #[inline(always)]
    pub(crate) fn update<L: Lanes>(
        &mut self,
        setting: &Setting<'_>,
        monitor: &mut HealthMonitor,
        pending: &PendingSample,
        decision: &Decision,
        recorder: &mut impl FilterRecorder,
    ) -> Result<Finding, NumericalError> {
        let (config, PendingSample { sample, events }) = (setting.filter, pending);
        let elapsed = sample.time - self.previous.time;
        if elapsed > monitor.longest_gap() {
            self.resume(sample, elapsed, recorder);
            monitor.mark_lost();
        }
        let interval = self.propagate::<L>(setting.strapdown, sample);
        let dt = interval.step.dt;
        let stationary = decision.stationary && is_held_up(&interval.step);
        self.unaided.step(&self.filter.estimate.nav.velocity, &interval.velocity_gain, stationary);
        self.rolling.step::<L>(&interval, stationary, config.contact_rate);
        let rests = self.rests(config, &interval, *events);
        self.predict::<L>(&interval, *events, !stationary && !rests, recorder);
        let stands =
            stationary && dt > 0.0 && self.stand::<L>(config, monitor, &interval, sample, recorder);
        if !stands {
            self.footing.go_on(dt, config.zupt_correlation);
        }
        if rests {
            let update =
                self.filter.zero_angular_rate::<L>(sample, config.zero_angular_rate_std, recorder);
            monitor.zero_angular_rate(update.accepted);
        }
        if stationary || rests { self.filter.check() } else { self.filter.check_prediction() }?;
        let flags = monitor.assess(sample.time, *events, || self.filter.tilt_std());
        Ok(Finding { zero_velocity: stationary, flags })
    }

    /// A sample at which the foot is known to rest.
    #[inline(always)]
    pub(crate) fn settle<L: Lanes>(
        &mut self,
        setting: &Setting<'_>,
        sample: &ImuSample,
    ) -> Result<(), NumericalError> {
        let interval = self.step::<L>(setting.strapdown, sample, Flags::empty(), &mut ());
        let dt = interval.step.dt;
        if dt > 0.0 {
            self.zero_velocity::<L>(setting.filter, &interval.angular_rate, &mut ());
        }
        if dt > 0.0 && setting.filter.zero_angular_rate {
            self.filter.zero_angular_rate::<L>(
                sample,
                setting.filter.zero_angular_rate_std,
                &mut (),
            );
        }
        self.filter.check()
    }

    /// What a foot on the ground tells, and whether its velocity was believed to be zero.
    #[inline(always)]
    fn stand<L: Lanes>(
        &mut self,
        config: &FilterConfig,
        monitor: &mut HealthMonitor,
        interval: &Interval,
        sample: &ImuSample,
        recorder: &mut impl FilterRecorder,
    ) -> bool {
        match config.kind {
            FilterKind::Kf => {
                if let Some(threshold) = config.attitude_threshold {
                    self.observe_attitude(config, threshold, interval.step, sample, recorder);
                }
                let accepted = self.zero_velocity::<L>(config, &interval.angular_rate, recorder);
                monitor.zero_velocity(sample.time, accepted);
                accepted
            }
            FilterKind::Dr => {
                let variance = config.zero_velocity_std.powi(2);
                self.filter.reset_velocity(variance, recorder);
                self.footing.stand(variance);
                monitor.zero_velocity(sample.time, true);
                true
            }
            FilterKind::Ins => false,
        }
    }

    /// What the accelerometer shows of the attitude, where it reads nothing but gravity.
    ///
    /// It owns the step, so that those of all other samples may stay in registers.
    fn observe_attitude(
        &mut self,
        config: &FilterConfig,
        threshold: f64,
        step: Step,
        sample: &ImuSample,
        recorder: &mut impl FilterRecorder,
    ) {
        if self.filter.gravity_residual(sample).abs() >= threshold {
            return;
        }
        match config.attitude_update {
            AttitudeUpdate::None => {}
            AttitudeUpdate::Gravity => {
                self.filter.gravity(&step, sample, config.attitude_std, recorder)
            }
            AttitudeUpdate::Iaa => {
                self.filter.accelerometer_attitude(&step, sample, config.attitude_std, recorder)
            }
        }
    }

    /// The velocity as it is without what the present stance tells, n, m/s.
    pub(crate) fn unaided_velocity(&self) -> Vector3<f64> {
        self.unaided.value
    }

    #[inline]
    pub(crate) fn solution(&self, Finding { zero_velocity, flags }: Finding) -> Solution {
        Solution {
            estimate: self.filter.estimate,
            position_std: self.filter.position_std(),
            zero_velocity,
            flags,
        }
    }

    /// Strapdown and prediction over the interval that `sample` ends.
    #[inline(always)]
    pub(crate) fn step<L: Lanes>(
        &mut self,
        strapdown: &Strapdown,
        sample: &ImuSample,
        events: Flags,
        recorder: &mut impl FilterRecorder,
    ) -> Interval {
        let interval = self.propagate::<L>(strapdown, sample);
        self.predict::<L>(&interval, events, false, recorder);
        interval
    }

    /// Prediction over an interval.
    #[inline(always)]
    fn predict<L: Lanes>(
        &mut self,
        interval: &Interval,
        events: Flags,
        swings: bool,
        recorder: &mut impl FilterRecorder,
    ) {
        let strayed = self.footing.take_strayed();
        let clipped = events.contains(Flags::CLIPPED);
        self.filter.predict::<L>(
            &interval.step,
            clipped,
            interval.bridged,
            strayed,
            swings,
            recorder,
        );
    }

    /// Goes on after a gap that is too long to be bridged.
    fn resume(&mut self, sample: &ImuSample, elapsed: f64, recorder: &mut impl FilterRecorder) {
        self.filter.resume(sample.time, elapsed, recorder);
        let mut rolling = std::mem::take(&mut self.rolling);
        rolling.interrupt();
        *self = Self { rolling, ..Self::new(self.filter.clone(), sample) };
    }

    /// Strapdown over the interval that `sample` ends.
    #[inline(always)]
    fn propagate<L: Lanes>(&mut self, strapdown: &Strapdown, sample: &ImuSample) -> Interval {
        let bridged = strapdown.bridged(&self.previous, sample);
        let Estimate { gyro_bias, accel_bias, nav } = &mut self.filter.estimate;
        let before = nav.velocity;
        let unbiased = sample.without_bias(gyro_bias, accel_bias);
        let now =
            strapdown.increments(&self.previous.without_bias(gyro_bias, accel_bias), &unbiased);
        let step = strapdown.advance_on::<L>(nav, &self.increments, &now);
        nav.time = sample.time;
        let velocity_gain = nav.velocity - before;
        self.previous = *sample;
        self.increments = now;
        Interval { step, bridged, angular_rate: unbiased.angular_rate, velocity_gain }
    }

    /// Where the strapdown alone leads from here.
    pub(crate) fn ahead<'a>(
        &self,
        strapdown: &Strapdown,
        longest_gap: f64,
        samples: impl Iterator<Item = &'a ImuSample>,
    ) -> NavState {
        dispatch(Ahead { walk: self.clone(), strapdown, longest_gap, samples })
    }

    /// Zero-velocity update, up to what the foot rolls; a foot that stays still against the
    /// filter's belief is right in the end.
    #[inline(always)]
    fn zero_velocity<L: Lanes>(
        &mut self,
        config: &FilterConfig,
        angular_rate: &Vector3<f64>,
        recorder: &mut impl FilterRecorder,
    ) -> bool {
        let velocity = rotation_kernels::rotate::<L>(
            &self.filter.estimate.nav.attitude,
            &self.rolling.velocity(angular_rate),
        );
        let wandering = config.zupt_lever_std.powi(2) * angular_rate.norm_squared();
        let variance = config.zero_velocity_std.powi(2) + wandering;
        let insist = self.rejected_for > config.rejection_limit;
        let accepted =
            self.filter.zero_velocity::<L>(&velocity, variance, insist, recorder).accepted;
        self.rejected_for = if accepted { 0.0 } else { self.rejected_for + self.increments.dt };
        if accepted {
            self.footing.stand(variance);
        }
        accepted
    }

    /// Whether the foot has not turned for so long that the gyroscope reads its own bias.
    #[inline(always)]
    fn rests(&mut self, config: &FilterConfig, interval: &Interval, events: Flags) -> bool {
        let dt = interval.step.dt;
        let seen = !events.contains(Flags::GAP);
        let still = seen && interval.angular_rate.norm_squared() < config.rest_rate.powi(2);
        self.still_for = if still { self.still_for + dt } else { 0.0 };
        let used = config.zero_angular_rate && config.kind == FilterKind::Kf;
        used && dt > 0.0 && self.still_for >= config.rest_duration
    }
}

/// See [`Walk::ahead`].
struct Ahead<'a, I> {
    walk: Walk,
    strapdown: &'a Strapdown,
    longest_gap: f64,
    samples: I,
}

impl<'a, I: Iterator<Item = &'a ImuSample>> Work for Ahead<'_, I> {
    type Output = NavState;

    #[inline(always)]
    fn run<L: Lanes>(self) -> NavState {
        let Self { mut walk, strapdown, longest_gap, samples } = self;
        for sample in samples {
            let elapsed = sample.time - walk.previous.time;
            if elapsed > longest_gap {
                walk.resume(sample, elapsed, &mut ());
            }
            walk.propagate::<L>(strapdown, sample);
        }
        walk.filter.estimate.nav
    }
}

/// Whether the ground carries the foot.  A detector looks at magnitudes, and a foot that is braked
/// with twice gravity on its way up feels the magnitude of gravity, upside down.
#[inline]
fn is_held_up(step: &Step) -> bool {
    step.velocity_increment_n.z > 0.0 || step.dt == 0.0
}
