//! The aids of a navigator, in the order in which they update the filter.
//!
//! A new aid is a file beside this one and an entry in each of the lists below.

use nalgebra::Vector3;

use crate::aiding::aid::{Aid, Epoch, Outcome};
use crate::aiding::gravity_tilt::GravityTilt;
use crate::aiding::iaa::Iaa;
use crate::aiding::magnetic_heading::MagneticHeading;
use crate::aiding::zero_angular_rate::ZeroAngularRate;
use crate::aiding::zero_velocity::ZeroVelocity;
use crate::config::Config;
use crate::error::DataError;
use crate::filter::error_state::Block;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::ins::interval::Interval;
use crate::math::simd::Simd;
use crate::types::nav_state::NavState;
use crate::types::sample::{ImuSample, MagSample};

/// One value for each aid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerAid<T> {
    /// Roll and pitch from gravity.
    pub gravity_tilt: T,
    /// Accelerometer attitude as published.
    pub iaa: T,
    /// Zero-velocity updates.
    pub zero_velocity: T,
    /// Zero-angular-rate updates.
    pub zero_angular_rate: T,
    /// Magnetic heading.
    pub magnetic_heading: T,
}

/// Number of aids.
const AIDS: usize = 5;

impl<T> PerAid<T> {
    /// Names of the aids.
    pub const NAMES: [&'static str; AIDS] =
        ["gravity_tilt", "iaa", "zero_velocity", "zero_angular_rate", "magnetic_heading"];

    /// The values in the order of [`PerAid::NAMES`].
    #[inline]
    pub fn iter(&self) -> std::array::IntoIter<&T, AIDS> {
        let Self { gravity_tilt, iaa, zero_velocity, zero_angular_rate, magnetic_heading } = self;
        [gravity_tilt, iaa, zero_velocity, zero_angular_rate, magnetic_heading].into_iter()
    }

    /// As [`PerAid::iter`].
    #[inline]
    pub fn iter_mut(&mut self) -> std::array::IntoIter<&mut T, AIDS> {
        let Self { gravity_tilt, iaa, zero_velocity, zero_angular_rate, magnetic_heading } = self;
        [gravity_tilt, iaa, zero_velocity, zero_angular_rate, magnetic_heading].into_iter()
    }
}

/// A reading beside those of the inertial measurement unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reading {
    /// Of a magnetometer.
    Magnetic(MagSample),
}

impl From<MagSample> for Reading {
    fn from(sample: MagSample) -> Self {
        Self::Magnetic(sample)
    }
}

/// The aids that the settings ask for.
#[derive(Clone, Debug)]
pub(crate) struct Aids {
    gravity_tilt: Option<GravityTilt>,
    iaa: Option<Iaa>,
    zero_velocity: ZeroVelocity,
    zero_angular_rate: Option<ZeroAngularRate>,
    magnetic_heading: Option<MagneticHeading>,
    position_is_due: bool,
}

impl Aids {
    /// The Earth rate is in n, rad/s.
    pub(crate) fn new(config: &Config, earth_rate: Vector3<f64>) -> Self {
        let (filter, gravity) = (&config.filter, config.gravity());
        Self {
            gravity_tilt: GravityTilt::new(filter, gravity),
            iaa: Iaa::new(filter, gravity),
            zero_velocity: ZeroVelocity::new(filter),
            zero_angular_rate: ZeroAngularRate::new(filter, earth_rate),
            magnetic_heading: MagneticHeading::new(&config.magnetometer),
            position_is_due: false,
        }
    }

    /// Takes a reading; one of an aid that the settings do not ask for is ignored.
    pub(crate) fn push(&mut self, reading: &Reading) {
        match reading {
            Reading::Magnetic(sample) => {
                self.magnetic_heading.iter_mut().for_each(|aid| aid.push(sample));
            }
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
    }

    /// Follows an interval before the covariance is propagated over it; whether a measurement may be
    /// due at its end, as it may in any stance.
    #[inline(always)]
    pub(crate) fn prepare(&mut self, epoch: &Epoch<'_>, simd: impl Simd) -> bool {
        let mut due = Due { any: epoch.stance, position: false };
        due.prepare(&mut self.gravity_tilt, epoch, simd);
        due.prepare(&mut self.iaa, epoch, simd);
        due.prepare(&mut self.zero_velocity, epoch, simd);
        due.prepare(&mut self.zero_angular_rate, epoch, simd);
        due.prepare(&mut self.magnetic_heading, epoch, simd);
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

    /// Updates the filter at the end of an interval.
    #[inline(always)]
    pub(crate) fn update<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        epoch: &Epoch<'_>,
        recorder: &mut impl FilterRecorder,
    ) -> PerAid<Outcome> {
        let outcomes = PerAid {
            gravity_tilt: self.gravity_tilt.update(filter, epoch, recorder),
            iaa: self.iaa.update(filter, epoch, recorder),
            zero_velocity: self.zero_velocity.update(filter, epoch, recorder),
            zero_angular_rate: self.zero_angular_rate.update(filter, epoch, recorder),
            magnetic_heading: self.magnetic_heading.update(filter, epoch, recorder),
        };
        if self.position_is_due {
            self.add_position_noise(filter, recorder);
        }
        outcomes
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

    /// Discards what the aids know of a motion that a long gap interrupted.
    pub(crate) fn interrupt(&mut self) {
        self.gravity_tilt.interrupt();
        self.iaa.interrupt();
        self.zero_velocity.interrupt();
        self.zero_angular_rate.interrupt();
        self.magnetic_heading.interrupt();
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
