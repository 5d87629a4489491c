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
        let variance = HEADING_STD.powi(2) - self.filter.covariance().diagonal(Block::Attitude).z;
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
