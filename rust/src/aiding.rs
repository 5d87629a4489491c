//! Aids: sources of measurements that correct the inertial navigation, and their registry.
//!
//! A new aid is a file in this folder, and an entry in each of the lists below, which keep the order
//! in which the aids update the filter.

pub(crate) mod accelerometer_attitude;
pub(crate) mod aid;
pub(crate) mod gravity_tilt;
pub(crate) mod iaa;
pub(crate) mod lever_arm;
pub(crate) mod magnetic_heading;
pub(crate) mod magnetometer_settings;
pub mod position_fix;
pub(crate) mod zero_angular_rate;
pub(crate) mod zero_velocity;
pub(crate) mod zupt_correlation;

use crate::aiding::accelerometer_attitude::AccelerometerAttitude;
use crate::aiding::aid::{Aid, Epoch, Outcome, UpdateCount};
use crate::aiding::gravity_tilt::GravityTilt;
use crate::aiding::iaa::Iaa;
use crate::aiding::magnetic_heading::MagneticHeading;
use crate::aiding::magnetometer_settings::MagnetometerConfig;
use crate::aiding::position_fix::{PositionFix, PositionFixes};
use crate::aiding::zero_angular_rate::ZeroAngularRate;
use crate::aiding::zero_velocity::ZeroVelocity;
use crate::error::DataError;
use crate::filter::error_state::Block;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::filter::settings::{AttitudeUpdate, FilterConfig};
use crate::ins::interval::Interval;
use crate::ins::strapdown::Strapdown;
use crate::math::simd::Simd;
use crate::types::nav_state::NavState;
use crate::types::sample::{ImuSample, MagSample};

/// Updates by each aid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UpdateCounters {
    /// Roll and pitch from gravity.
    pub gravity_tilt: UpdateCount,
    /// Accelerometer attitude as published.
    pub iaa: UpdateCount,
    /// Zero-velocity updates.
    pub zero_velocity: UpdateCount,
    /// Zero-angular-rate updates.
    pub zero_angular_rate: UpdateCount,
    /// Magnetic heading.
    pub magnetic_heading: UpdateCount,
    /// Position fixes.
    pub position_fix: UpdateCount,
}

/// A reading beside those of the inertial measurement unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reading {
    /// Of a magnetometer.
    Magnetic(MagSample),
    /// A position fix.
    Position(PositionFix),
}

impl From<PositionFix> for Reading {
    fn from(fix: PositionFix) -> Self {
        Self::Position(fix)
    }
}

impl From<MagSample> for Reading {
    fn from(sample: MagSample) -> Self {
        Self::Magnetic(sample)
    }
}

/// The aids that the settings ask for.
#[derive(Clone, Debug)]
pub(crate) struct Aids {
    gravity_tilt: Option<AccelerometerAttitude<GravityTilt>>,
    iaa: Option<AccelerometerAttitude<Iaa>>,
    zero_velocity: ZeroVelocity,
    zero_angular_rate: Option<ZeroAngularRate>,
    magnetic_heading: Option<MagneticHeading>,
    position_fix: Option<PositionFixes>,
    /// Whether the accelerometer indicates the attitude.
    indicates_attitude: bool,
    /// Whether there was a reading of another sensor.
    has_readings: bool,
    position_is_due: bool,
    counters: UpdateCounters,
}

impl Aids {
    /// The aids for a mechanization.
    pub(crate) fn new(
        filter: &FilterConfig,
        magnetometer: &MagnetometerConfig,
        strapdown: &Strapdown,
    ) -> Self {
        let &Strapdown { gravity, earth_rate, .. } = strapdown;
        Self {
            gravity_tilt: AccelerometerAttitude::new(filter, gravity),
            iaa: AccelerometerAttitude::new(filter, gravity),
            zero_velocity: ZeroVelocity::new(filter),
            zero_angular_rate: ZeroAngularRate::new(filter, earth_rate),
            magnetic_heading: MagneticHeading::new(magnetometer),
            position_fix: PositionFixes::new(filter),
            indicates_attitude: filter.attitude_update != AttitudeUpdate::None,
            has_readings: false,
            position_is_due: false,
            counters: UpdateCounters::default(),
        }
    }

    /// Takes a reading; one of an aid that the settings do not ask for is ignored.
    pub(crate) fn push(&mut self, reading: &Reading) {
        self.has_readings = true;
        match reading {
            Reading::Magnetic(sample) => {
                self.magnetic_heading.iter_mut().for_each(|aid| aid.push(sample));
            }
            Reading::Position(fix) => self.position_fix.iter_mut().for_each(|aid| aid.push(fix)),
        }
    }

    /// Checks that each aid that needs readings has had some.
    ///
    /// # Errors
    /// [`DataError::NoField`].
    pub(crate) fn check_readings(&self) -> Result<(), DataError> {
        let has_field = self.magnetic_heading.as_ref().is_none_or(MagneticHeading::has_readings);
        if has_field { Ok(()) } else { Err(DataError::NoField) }
    }

    /// Starts at a state, before which the foot was at rest or moved.
    pub(crate) fn begin(&mut self, nav: &NavState, at_rest: bool) {
        self.gravity_tilt.begin(nav, at_rest);
        self.iaa.begin(nav, at_rest);
        self.zero_velocity.begin(nav, at_rest);
        self.zero_angular_rate.begin(nav, at_rest);
        self.magnetic_heading.begin(nav, at_rest);
        self.position_fix.begin(nav, at_rest);
    }

    /// Follows an interval before the covariance is propagated over it; whether a measurement may be
    /// due at its end, as it may in any stance.
    #[inline(always)]
    pub(crate) fn prepare(&mut self, epoch: &Epoch<'_>, simd: impl Simd) -> bool {
        let mut due = Due { any: epoch.stance, position: false };
        due.prepare(&mut self.zero_velocity, epoch, simd);
        due.prepare(&mut self.zero_angular_rate, epoch, simd);
        if self.has_readings {
            due.prepare(&mut self.magnetic_heading, epoch, simd);
            due.prepare(&mut self.position_fix, epoch, simd);
        }
        self.position_is_due = due.position;
        due.any
    }

    /// Variance of the position that the next prediction adds, m².
    ///
    /// It is noise that the propagation of the error model does not have: see
    /// [`crate::aiding::zupt_correlation`].  While no aid observes the position, it changes no gain
    /// but those of the position itself, so the track is the same with and without it.
    #[inline(always)]
    pub(crate) fn position_noise(&self) -> f64 {
        self.zero_velocity.position_noise()
    }

    /// Updates the filter at the end of an interval; returns the outcome of the zero-velocity update.
    #[inline(always)]
    pub(crate) fn update<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        epoch: &Epoch<'_>,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        let count = &mut self.counters;
        if self.indicates_attitude {
            count.gravity_tilt.add(self.gravity_tilt.update(filter, epoch, recorder));
            count.iaa.add(self.iaa.update(filter, epoch, recorder));
        }
        let zero_velocity = self.zero_velocity.update(filter, epoch, recorder);
        count.zero_velocity.add(zero_velocity);
        count.zero_angular_rate.add(self.zero_angular_rate.update(filter, epoch, recorder));
        if self.has_readings {
            count.magnetic_heading.add(self.magnetic_heading.update(filter, epoch, recorder));
        }
        if self.position_is_due {
            self.add_position_noise(filter, recorder);
            let outcome = self.position_fix.update(filter, epoch, recorder);
            self.counters.position_fix.add(outcome);
        }
        zero_velocity
    }

    /// Updates since the start.
    pub(crate) fn counters(&self) -> &UpdateCounters {
        &self.counters
    }

    /// Adds the position noise of this interval before the position is observed, which weighs it.
    fn add_position_noise<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        recorder: &mut impl FilterRecorder,
    ) {
        let variance = self.zero_velocity.take_pending_position_noise();
        filter.inflate(Block::Position, variance, recorder);
    }

    /// Updates the filter at a sample at which the foot is known to be at rest.
    #[inline(always)]
    pub(crate) fn update_at_rest<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        interval: &Interval,
        sample: &ImuSample,
    ) {
        let dt = interval.step.dt;
        if dt <= 0.0 {
            return;
        }
        self.zero_velocity.apply(filter, &interval.angular_rate, dt, &mut ());
        if let Some(aid) = &self.zero_angular_rate {
            aid.apply(filter, sample, &mut ());
        }
    }

    /// Discards the state of a motion that a long gap interrupted.
    pub(crate) fn interrupt(&mut self) {
        self.gravity_tilt.interrupt();
        self.iaa.interrupt();
        self.zero_velocity.interrupt();
        self.zero_angular_rate.interrupt();
        self.magnetic_heading.interrupt();
        self.position_fix.interrupt();
    }
}

/// Which measurements may be due.
struct Due {
    any: bool,
    position: bool,
}

impl Due {
    #[inline(always)]
    fn prepare(&mut self, aid: &mut impl Aid, epoch: &Epoch<'_>, simd: impl Simd) {
        let is_due = aid.prepare(epoch, simd);
        self.any |= is_due;
        self.position |= is_due && aid.observes() == Some(Block::Position);
    }
}
