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
mod tests {
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    use super::*;
    use crate::filter::settings::FilterConfig;
    use crate::filter::setup::FilterSetup;
    use crate::ins::alignment::{Aligned, AlignmentConfig};
    use crate::ins::interval::Interval;
    use crate::ins::strapdown::{MechanizationKind, Strapdown, StrapdownStep};
    use crate::math::rotation::about_up;
    use crate::math::simd::Baseline;
    use crate::types::health::Flags;
    use crate::types::sample::ImuSample;
    use crate::types::sensor::SensorConfig;

    const DT: f64 = 0.01;
    const HEADING_STD: f64 = 0.1;

    /// A foot in a field (n), in stance now and then, with a filter whose heading is wrong.
    struct Trial {
        aid: MagneticHeading,
        filter: ErrorStateFilter<Baseline>,
        accepted: u64,
        rejected: u64,
        truth: UnitQuaternion<f64>,
    }

    fn aid() -> MagneticHeading {
        let config = MagnetometerConfig { heading: true, ..MagnetometerConfig::default() };
        MagneticHeading::new(&config).unwrap()
    }

    impl Trial {
        /// After a rest of half a second in the field.
        fn new(truth: UnitQuaternion<f64>, field: &Vector3<f64>) -> Self {
            let aligned = Aligned {
                attitude: truth,
                gyro_bias: Vector3::zeros(),
                at_rest: true,
                rest: 1.0,
                sway: 0.0,
            };
            let strapdown = Strapdown {
                kind: MechanizationKind::TwoSample,
                gravity: 9.81,
                earth_rate: Vector3::zeros(),
                nominal_interval: DT,
            };
            let setup = FilterSetup {
                sensor: &SensorConfig::default(),
                alignment: &AlignmentConfig::default(),
                filter: &FilterConfig::default(),
                strapdown: &strapdown,
                batches: false,
            };
            let filter = ErrorStateFilter::new(Baseline, &setup, &aligned, 0.0);
            let mut trial = Self { aid: aid(), filter, accepted: 0, rejected: 0, truth };
            trial.read(field);
            trial.aid.begin(&trial.filter.estimate.nav, true);
            trial.go(40, true, field);
            trial.go(40, false, field);
            trial
        }

        /// One interval of the filter and the aid.
        fn step(&mut self, stance: bool) {
            self.filter.estimate.nav.time += DT;
            let zero = Vector3::zeros();
            let step = StrapdownStep {
                dt: DT,
                velocity_increment_n: zero,
                attitude: nalgebra::Matrix3::identity(),
            };
            let interval =
                Interval { step, gap_duration: 0.0, angular_rate: zero, velocity_change: zero };
            let sample = ImuSample::new(self.filter.estimate.nav.time, [0.0; 3], [0.0; 3]);
            let flags = Flags::empty();
            let epoch = Epoch { sample: &sample, interval: &interval, stance, flags };
            self.aid.prepare(&epoch, Baseline);
            let outcome = self.aid.update(&mut self.filter, &epoch, &mut ());
            self.accepted += u64::from(outcome == Outcome::Accepted);
            self.rejected += u64::from(outcome == Outcome::Rejected);
        }

        /// The magnetometer reads the field, with a change that makes two readings distinct.
        fn read_at(&mut self, time: f64, field: &Vector3<f64>) {
            let reading = self.truth.inverse() * field * (1.0 + 1e-9 * time);
            self.aid.push(&MagSample::new(time, reading.into()).unwrap());
        }

        fn read(&mut self, field: &Vector3<f64>) {
            self.read_at(self.filter.estimate.nav.time, field);
        }

        fn go(&mut self, samples: u32, stance: bool, field: &Vector3<f64>) {
            for _ in 0..samples {
                let time = self.filter.estimate.nav.time + DT;
                self.read_at(time, field);
                self.step(stance);
            }
        }

        /// The estimated heading turns away by `error` (rad) from the true one, and is as uncertain
        /// as [`HEADING_STD`] says.
        fn turn_away(&mut self, error: f64) {
            self.filter.estimate.nav.attitude = about_up(-error) * self.truth;
            let variance =
                HEADING_STD.powi(2) - self.filter.covariance().diagonal(Block::Attitude).z;
            self.filter.inflate(Block::Attitude, variance, &mut ());
        }

        /// What is left of the error, rad.
        fn error(&self) -> f64 {
            (self.truth * self.filter.estimate.nav.attitude.inverse()).scaled_axis().z
        }

        fn counts(&self) -> (u64, u64) {
            (self.accepted, self.rejected)
        }
    }

    fn attitudes() -> impl Strategy<Value = UnitQuaternion<f64>> {
        [-3.1..3.1, -1.5..1.5, -3.1..3.1]
            .prop_map(|[x, y, z]: [f64; 3]| UnitQuaternion::from_euler_angles(x, y, z))
    }

    fn north() -> Vector3<f64> {
        Vector3::new(0.0, 17.0, -45.0)
    }

    proptest! {
        #[test]
        fn a_stance_corrects_the_share_of_the_error_that_follows_from_the_variances(
            truth in attitudes(),
            azimuth in -3.2..3.2,
            error in -0.3..0.3,
        ) {
            let field = about_up(azimuth) * north();
            let mut trial = Trial::new(truth, &field);
            trial.turn_away(error);
            trial.go(40, true, &field);
            let observed = 10_f64.to_radians().powi(2);
            let left = observed / (observed + HEADING_STD.powi(2));
            prop_assert_eq!(trial.counts(), (1, 0));
            prop_assert!((trial.error() - left * error).abs() < 1e-7, "{} of {}", trial.error(), error);
        }

        #[test]
        fn a_disturbed_field_does_not_change_the_heading(
            truth in attitudes(),
            error in -0.1..0.1,
            turn in 0.8..5.4,
            stretch in 0.12..2.0,
            dip in 0.1..0.3,
        ) {
            let tilted = UnitQuaternion::from_euler_angles(dip, 0.0, 0.0);
            let (stronger, weaker) = (north() * (1.0 + stretch), north() / (1.0 + stretch));
            let (rotated, dipped) = (about_up(turn) * north(), tilted * north());
            for disturbed in [rotated, stronger, weaker, dipped, Vector3::zeros()] {
                let mut trial = Trial::new(truth, &north());
                trial.turn_away(error);
                trial.go(40, true, &disturbed);
                prop_assert_eq!(trial.counts(), (0, 1));
                prop_assert!((trial.error() - error).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn each_stance_is_used_once() {
        let mut trial = Trial::new(UnitQuaternion::identity(), &north());
        for stances in 1..=3 {
            trial.go(30, true, &north());
            trial.go(5, false, &north());
            trial.go(30, true, &north());
            assert_eq!(trial.counts(), (stances, 0));
            trial.go(30, false, &north());
        }
    }

    #[test]
    fn short_stances_are_not_used() {
        let mut trial = Trial::new(UnitQuaternion::identity(), &north());
        for _ in 0..5 {
            trial.go(8, true, &north());
            trial.go(30, false, &north());
        }
        assert_eq!(trial.counts(), (0, 0));
    }

    #[test]
    fn readings_of_the_swing_and_held_readings_are_not_used() {
        let mut trial = Trial::new(UnitQuaternion::identity(), &north());
        trial.go(30, false, &Vector3::new(50.0, 0.0, 0.0));
        let held = MagSample::new(trial.filter.estimate.nav.time, [30.0, 0.0, 0.0]).unwrap();
        for stance in [false, true] {
            for _ in 0..40 {
                trial.aid.push(&held);
                trial.step(stance);
            }
        }
        assert_eq!(trial.counts(), (0, 0));
        trial.go(1, true, &north());
        assert_eq!(trial.counts(), (1, 0));
    }

    #[test]
    fn a_stance_ends_at_a_gap() {
        let mut trial = Trial::new(UnitQuaternion::identity(), &north());
        trial.go(30, true, &north());
        trial.filter.estimate.nav.time += 10.0;
        trial.aid.interrupt();
        trial.go(30, true, &north());
        assert_eq!(trial.counts(), (2, 0));
    }

    #[test]
    fn after_a_start_in_motion_the_first_stance_is_the_reference() {
        let mut trial = Trial::new(UnitQuaternion::identity(), &north());
        trial.aid = aid();
        trial.read(&Vector3::new(99.0, 0.0, 0.0));
        trial.aid.begin(&trial.filter.estimate.nav, false);
        trial.go(30, false, &Vector3::new(99.0, 0.0, 0.0));
        trial.go(30, true, &north());
        trial.go(30, false, &north());
        trial.turn_away(0.05);
        trial.go(30, true, &north());
        assert_eq!(trial.counts(), (1, 0));
        assert!(trial.error() < 0.04, "{}", trial.error());
    }

    #[test]
    fn the_error_of_a_reading_that_is_not_finite_names_the_cure() {
        let error = MagSample::new(2.5, [1.0, f64::NAN, 3.0]).unwrap_err().to_string();
        assert!(
            error.starts_with(
                "at 2.5 s the magnetic field is [1.0, NaN, 3.0]; expected three finite numbers"
            ),
            "{error}"
        );
    }
}
