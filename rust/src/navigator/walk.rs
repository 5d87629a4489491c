//! One foot on its way: the algorithm that is run for every sample.

use nalgebra::Vector3;

use crate::config::{AttitudeUpdate, FilterConfig, FilterKind};
use crate::detector::Decision;
use crate::error::NumericalError;
use crate::filter::journal::Journal;
use crate::filter::{ErrorStateFilter, Estimate};
use crate::gait::Measured;
use crate::health::{HealthMonitor, Reasons};
use crate::lanes::{Lanes, Work, dispatch};
use crate::navigator::footing::Footing;
use crate::navigator::interval::Interval;
use crate::navigator::rolling::Rolling;
use crate::navigator::{Arrived, Solution};
use crate::rotation::fused;
use crate::sample::ImuSample;
use crate::strapdown::{Increments, NavState, Step, Strapdown};

/// What stays the same for all samples.
pub(super) struct Setting<'a> {
    pub(super) strapdown: &'a Strapdown,
    pub(super) filter: &'a FilterConfig,
}

/// What an update found beside the estimate.
#[derive(Clone, Copy)]
pub(super) struct Finding {
    pub(super) zero_velocity: bool,
    pub(super) reasons: Reasons,
}

/// The filter, with what it must remember from one sample to the next.
#[derive(Clone)]
pub(super) struct Walk {
    pub(super) filter: ErrorStateFilter,
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
    pub(super) fn new(filter: ErrorStateFilter, sample: &ImuSample) -> Self {
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

    /// Goes through samples that came before the walk's first solution; a stride may start where the foot stood until then.
    #[inline(always)]
    pub(super) fn through<L: Lanes>(
        mut self,
        strapdown: &Strapdown,
        samples: &[ImuSample],
        strides: Option<&mut Measured>,
    ) -> Self {
        let mut journal = strides.map(|strides| {
            strides.begin(&self.filter.covariance());
            strides.journal()
        });
        for sample in samples {
            self.step::<L>(strapdown, sample, Reasons::empty(), &mut journal);
        }
        self
    }

    /// The algorithm: strapdown, prediction, and what the detector and a foot at rest know.
    ///
    /// What only needs the strapdown comes before the prediction, while its numbers are still at hand.
    #[inline(always)]
    pub(super) fn update<L: Lanes>(
        &mut self,
        setting: &Setting<'_>,
        monitor: &mut HealthMonitor,
        arrived: &Arrived,
        decision: &Decision,
        journal: &mut impl Journal,
    ) -> Result<Finding, NumericalError> {
        let (config, Arrived { sample, events }) = (setting.filter, arrived);
        let elapsed = sample.time - self.previous.time;
        if elapsed > monitor.longest_gap() {
            self.resume(sample, elapsed, journal);
            monitor.lose();
        }
        let interval = self.propagate::<L>(setting.strapdown, sample);
        let dt = interval.step.dt;
        let stationary = decision.stationary && is_held_up(&interval.step);
        self.unaided.step(&self.filter.estimate.nav.velocity, &interval.velocity_gain, stationary);
        self.rolling.step::<L>(&interval, stationary, config.rolling_rate);
        let rests = self.rests(config, &interval, *events);
        self.predict::<L>(&interval, *events, !stationary && !rests, journal);
        let stands = stationary && dt > 0.0 && self.stand::<L>(config, monitor, &interval, sample, journal);
        if !stands {
            self.footing.go_on(dt, config.zero_velocity_shared);
        }
        if rests {
            let update = self.filter.zero_angular_rate::<L>(sample, config.zero_angular_rate_std, journal);
            monitor.zero_angular_rate(update.accepted);
        }
        if stationary || rests { self.filter.check() } else { self.filter.check_prediction() }?;
        let reasons = monitor.assess(sample.time, *events, || self.filter.tilt_std());
        Ok(Finding { zero_velocity: stationary, reasons })
    }

    /// A sample at which the foot is known to rest.
    #[inline(always)]
    pub(super) fn settle<L: Lanes>(&mut self, setting: &Setting<'_>, sample: &ImuSample) -> Result<(), NumericalError> {
        let interval = self.step::<L>(setting.strapdown, sample, Reasons::empty(), &mut ());
        let dt = interval.step.dt;
        if dt > 0.0 {
            self.zero_velocity::<L>(setting.filter, &interval.angular_rate, &mut ());
        }
        if dt > 0.0 && setting.filter.zero_angular_rate {
            self.filter.zero_angular_rate::<L>(sample, setting.filter.zero_angular_rate_std, &mut ());
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
        journal: &mut impl Journal,
    ) -> bool {
        match config.kind {
            FilterKind::Kf => {
                if let Some(threshold) = config.attitude_threshold {
                    self.observe_attitude(config, threshold, interval.step, sample, journal);
                }
                let accepted = self.zero_velocity::<L>(config, &interval.angular_rate, journal);
                monitor.zero_velocity(sample.time, accepted);
                accepted
            }
            FilterKind::Dr => {
                let variance = config.zero_velocity_std.powi(2);
                self.filter.stop(variance, journal);
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
        journal: &mut impl Journal,
    ) {
        if self.filter.gravity_residual(sample).abs() >= threshold {
            return;
        }
        match config.attitude_update {
            AttitudeUpdate::None => {}
            AttitudeUpdate::Gravity => self.filter.gravity(&step, sample, config.attitude_std, journal),
            AttitudeUpdate::Iaa => self.filter.accelerometer_attitude(&step, sample, config.attitude_std, journal),
        }
    }

    /// The velocity as it is without what the present stance tells, n, m/s.
    pub(super) fn unaided_velocity(&self) -> Vector3<f64> {
        self.unaided.value
    }

    #[inline]
    pub(super) fn solution(&self, Finding { zero_velocity, reasons }: Finding) -> Solution {
        Solution { estimate: self.filter.estimate, position_std: self.filter.position_std(), zero_velocity, reasons }
    }

    /// Strapdown and prediction over the interval that `sample` ends.
    #[inline(always)]
    pub(super) fn step<L: Lanes>(
        &mut self,
        strapdown: &Strapdown,
        sample: &ImuSample,
        events: Reasons,
        journal: &mut impl Journal,
    ) -> Interval {
        let interval = self.propagate::<L>(strapdown, sample);
        self.predict::<L>(&interval, events, false, journal);
        interval
    }

    /// Prediction over an interval.
    #[inline(always)]
    fn predict<L: Lanes>(&mut self, interval: &Interval, events: Reasons, swings: bool, journal: &mut impl Journal) {
        let strayed = self.footing.take_strayed();
        let clipped = events.contains(Reasons::CLIPPED);
        self.filter.predict::<L>(&interval.step, clipped, interval.bridged, strayed, swings, journal);
    }

    /// Goes on after a gap that is too long to be bridged.
    fn resume(&mut self, sample: &ImuSample, elapsed: f64, journal: &mut impl Journal) {
        self.filter.resume(sample.time, elapsed, journal);
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
        let now = strapdown.increments(&self.previous.without_bias(gyro_bias, accel_bias), &unbiased);
        let step = strapdown.advance_on::<L>(nav, &self.increments, &now);
        nav.time = sample.time;
        let velocity_gain = nav.velocity - before;
        self.previous = *sample;
        self.increments = now;
        Interval { step, bridged, angular_rate: unbiased.angular_rate, velocity_gain }
    }

    /// Where the strapdown alone leads from here.
    pub(super) fn ahead<'a>(
        &self,
        strapdown: &Strapdown,
        longest_gap: f64,
        samples: impl Iterator<Item = &'a ImuSample>,
    ) -> NavState {
        dispatch(Ahead { walk: self.clone(), strapdown, longest_gap, samples })
    }

    /// Zero-velocity update, up to what the foot rolls; a foot that stays still against the filter's belief is right in the end.
    #[inline(always)]
    fn zero_velocity<L: Lanes>(
        &mut self,
        config: &FilterConfig,
        angular_rate: &Vector3<f64>,
        journal: &mut impl Journal,
    ) -> bool {
        let velocity = fused::rotate::<L>(&self.filter.estimate.nav.attitude, &self.rolling.velocity(angular_rate));
        let wandering = config.zero_velocity_lever.powi(2) * angular_rate.norm_squared();
        let variance = config.zero_velocity_std.powi(2) + wandering;
        let insist = self.rejected_for > config.rejection_limit;
        let accepted = self.filter.zero_velocity::<L>(&velocity, variance, insist, journal).accepted;
        self.rejected_for = if accepted { 0.0 } else { self.rejected_for + self.increments.dt };
        if accepted {
            self.footing.stand(variance);
        }
        accepted
    }

    /// Whether the foot has not turned for so long that the gyroscope reads its own bias.
    #[inline(always)]
    fn rests(&mut self, config: &FilterConfig, interval: &Interval, events: Reasons) -> bool {
        let dt = interval.step.dt;
        let seen = !events.contains(Reasons::GAP);
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

/// Whether the ground carries the foot.  A detector looks at magnitudes, and a foot that is braked with twice gravity on its way up feels the magnitude of gravity, upside down.
#[inline]
fn is_held_up(step: &Step) -> bool {
    step.specific_velocity.z > 0.0 || step.dt == 0.0
}
