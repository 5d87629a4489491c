//! Magnetic heading: in stance the direction of the magnetic field corrects the heading, where the
//! field is undisturbed.
//!
//! Steel and currents disturb the field of the Earth, and a disturbed field rarely keeps both its
//! strength and its dip (Roetenberg et al. 2005).  The field of a stance is compared with that of the
//! rest at the start, and where strength, dip and heading agree, the heading is observed, once in a
//! stance: the errors of its readings have the disturbance in common.
//!
//! # References
//! Roetenberg, Luinge, Baten, Veltink, "Compensation of Magnetic Disturbances Improves Inertial and
//! Magnetic Sensing of Human Body Segment Orientation", IEEE Trans. Neural Syst. Rehabil. Eng.
//! 13(3):395-405, 2005.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};
use std::iter;

use nalgebra::Vector3;

use crate::aiding::aid::{Aid, Epoch, Outcome};
use crate::aiding::magnetometer_settings::MagnetometerConfig;
use crate::filter::error_state::Block;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::math::simd::Simd;
use crate::types::nav_state::NavState;
use crate::types::sample::MagSample;

/// Time in stance before the field is used, s: the bandwidth of magnetometers is some tens of hertz.
const SETTLING_TIME: f64 = 0.1;
/// Time out of stance from which on the next stance is another one, s.
const MIN_SWING: f64 = 0.1;
/// Squared Mahalanobis distance of a heading beyond which it is rejected: a magnetic disturbance is
/// not Gaussian.
const CHI2_GATE: f64 = 9.0;
/// Index of the up axis of n.
const UP: usize = 2;

/// Readings that wait for their samples, the field of the present stance, and the reference.
#[derive(Clone, Debug)]
pub(crate) struct MagneticHeading {
    config: MagnetometerConfig,
    pending: VecDeque<MagSample>,
    newest: Option<Vector3<f64>>,
    stance: StanceField,
    reference: Option<Reference>,
}

/// The field since the start of the stance.
#[derive(Clone, Copy, Debug, Default)]
struct StanceField {
    /// Sum of the readings in n, and their number.
    sum: Vector3<f64>,
    readings: f64,
    time_in_stance: f64,
    time_since_stance: f64,
    used: bool,
}

/// A field in n.
#[derive(Clone, Copy, Debug)]
struct Field {
    strength: f64,
    /// Below the horizontal, rad.
    dip: f64,
    /// Of the horizontal part, anticlockwise from n x, rad.
    azimuth: f64,
}

/// The undisturbed field.
#[derive(Clone, Copy, Debug)]
struct Reference {
    field: Field,
    /// Variance of the heading at which it was measured, rad².
    heading_variance: f64,
}

impl MagneticHeading {
    /// None unless the settings ask for it.
    pub(crate) fn new(config: &MagnetometerConfig) -> Option<Self> {
        config.heading.then(|| Self {
            config: config.clone(),
            pending: VecDeque::new(),
            newest: None,
            stance: StanceField::default(),
            reference: None,
        })
    }

    /// Takes a reading; one that is identical to the bit is the one before, held by a magnetometer
    /// that is slower than the samples.
    pub(crate) fn push(&mut self, reading: &MagSample) {
        if self.newest.replace(reading.field()) != Some(reading.field()) {
            self.pending.push_back(*reading);
        }
    }

    /// Whether there was any reading.
    pub(crate) fn has_readings(&self) -> bool {
        self.newest.is_some()
    }

    /// The next of the readings (b) that are not newer than `time`.
    fn next_until(&mut self, time: f64) -> Option<Vector3<f64>> {
        let is_due = self.pending.front()?.time() <= time;
        if is_due { self.pending.pop_front().map(|reading| reading.field()) } else { None }
    }
}

impl Aid for MagneticHeading {
    fn observes(&self) -> Option<Block> {
        Some(Block::Attitude)
    }

    fn begin(&mut self, nav: &NavState, at_rest: bool) {
        while let Some(reading) = self.next_until(nav.time) {
            if at_rest {
                self.stance.time_in_stance = SETTLING_TIME;
                self.stance.add(&(nav.attitude * reading));
            }
        }
    }

    #[inline(always)]
    fn prepare(&mut self, epoch: &Epoch<'_>, _: impl Simd) -> bool {
        if !epoch.stance {
            self.swing(epoch.sample.time, epoch.interval.step.dt);
        }
        self.stance.is_complete()
    }

    #[inline(always)]
    fn update<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        epoch: &Epoch<'_>,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        self.apply(filter, epoch.stance, epoch.interval.step.dt, recorder)
    }

    fn interrupt(&mut self) {
        self.stance = StanceField::default();
    }
}

impl MagneticHeading {
    /// Propagates over an interval of `dt` (s) in swing; its readings are not used.
    fn swing(&mut self, time: f64, dt: f64) {
        self.stance.time_since_stance += dt;
        while self.next_until(time).is_some() {}
    }

    /// The mean field of the stance as soon as it is known, once.
    fn mean_field(&mut self, nav: &NavState, stance: bool, dt: f64) -> Option<Field> {
        if stance {
            self.stance.stand(dt);
            if let Some(reading) = iter::from_fn(|| self.next_until(nav.time)).last() {
                self.stance.add(&(nav.attitude * reading));
            }
        }
        self.stance.take_mean()
    }

    /// Compares the mean field of the stance with the reference, and corrects the heading.
    #[inline(never)]
    fn apply<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        stance: bool,
        dt: f64,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        let nav = filter.estimate.nav;
        let Some(field) = self.mean_field(&nav, stance, dt) else { return Outcome::None };
        let Some(reference) = &self.reference else {
            self.reference = Reference::new(field, filter);
            return Outcome::None;
        };
        if !reference.field.agrees(&field, &self.config) {
            return Outcome::Rejected;
        }
        let variance = self.config.std_deg.to_radians().powi(2) + reference.heading_variance;
        let innovation = wrapped(reference.field.azimuth - field.azimuth);
        let state = (Block::Attitude, UP);
        let errors = filter.observe_axis(state, innovation, variance, CHI2_GATE, recorder);
        if let Some(errors) = &errors {
            filter.estimate.correct(filter.simd, errors);
        }
        Outcome::tested(errors.is_some())
    }
}

impl Reference {
    /// A field, measured with the heading of the filter; none where there is no field.
    fn new<S: Simd>(field: Field, filter: &ErrorStateFilter<S>) -> Option<Self> {
        let heading_variance = filter.covariance().diagonal(Block::Attitude)[UP];
        (field.strength > 0.0).then_some(Self { field, heading_variance })
    }
}

impl StanceField {
    /// Propagates over `dt` (s) in stance.
    fn stand(&mut self, dt: f64) {
        if self.time_since_stance > MIN_SWING {
            *self = Self::default();
        }
        self.time_since_stance = 0.0;
        self.time_in_stance += dt;
    }

    fn add(&mut self, field: &Vector3<f64>) {
        self.sum += field;
        self.readings += 1.0;
    }

    /// Whether the mean field is known, and not used yet.
    fn is_complete(&self) -> bool {
        !self.used && self.readings > 0.0 && self.time_in_stance >= SETTLING_TIME
    }

    /// The mean field, once.
    fn take_mean(&mut self) -> Option<Field> {
        if !self.is_complete() {
            return None;
        }
        self.used = true;
        Some(Field::new(&(self.sum / self.readings)))
    }
}

impl Field {
    fn new(field: &Vector3<f64>) -> Self {
        let dip = (-field.z).atan2(field.x.hypot(field.y));
        Self { strength: field.norm(), dip, azimuth: field.y.atan2(field.x) }
    }

    fn agrees(&self, other: &Self, config: &MagnetometerConfig) -> bool {
        (other.strength / self.strength - 1.0).abs() <= config.strength_tolerance
            && (other.dip - self.dip).abs() <= config.dip_tolerance_deg.to_radians()
    }
}

/// The angle within [-π, π).
fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests;
