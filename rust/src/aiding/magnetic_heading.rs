//! The heading that a magnetometer holds, where its field can be believed.
//!
//! Steel and currents bend the field of the Earth, and a bent field rarely keeps both its strength
//! and its dip (Roetenberg et al. 2005).  A stance is held against the field of the rest at the
//! start, and where strength, dip and heading agree with it, the heading is observed.  That happens
//! once in a stance: its readings are all wrong by what bends the field there.
//!
//! # References
//! Roetenberg, Luinge, Baten, Veltink, "Compensation of Magnetic Disturbances Improves Inertial and
//! Magnetic Sensing of Human Body Segment Orientation", IEEE Trans. Neural Syst. Rehabil. Eng.
//! 13(3):395-405, 2005.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};
use std::iter;

use nalgebra::Vector3;

use crate::config::MagnetometerConfig;
use crate::filter::error_state::Block;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::pipeline::health_monitor::HealthMonitor;
use crate::types::nav_state::NavState;
use crate::types::sample::MagSample;

/// How long a foot has to stand before the field is taken, s: the bandwidth of magnetometers is
/// some tens of hertz.
const SETTLED: f64 = 0.1;
/// How long the foot has to be gone for the next stance to be another one, s.
const GONE: f64 = 0.1;

/// Readings that wait for their samples, the field of the present stance, and the one that it is
/// held against.
pub(crate) struct Compass {
    config: MagnetometerConfig,
    waiting: VecDeque<MagSample>,
    newest: Option<Vector3<f64>>,
    time: f64,
    stance: Stance,
    reference: Option<Reference>,
}

/// What was seen of the field since the foot came to stand.
#[derive(Clone, Copy, Debug, Default)]
struct Stance {
    /// Sum of the readings in n, and their number.
    sum: Vector3<f64>,
    readings: f64,
    stood_for: f64,
    gone_for: f64,
    told: bool,
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

/// The field that stances are held against.
#[derive(Clone, Copy, Debug)]
struct Reference {
    field: Field,
    /// Variance of the heading that it was seen with, rad².
    heading_variance: f64,
}

impl Compass {
    /// None unless the settings ask for one.
    pub(crate) fn new(config: &MagnetometerConfig) -> Option<Self> {
        config.heading.then(|| Self {
            config: config.clone(),
            waiting: VecDeque::new(),
            newest: None,
            time: 0.0,
            stance: Stance::default(),
            reference: None,
        })
    }

    /// Takes a reading in; one that is the same to the bit is the one before, still held by a slow
    /// magnetometer.
    pub(crate) fn push(&mut self, reading: &MagSample) {
        if self.newest.replace(reading.field()) != Some(reading.field()) {
            self.waiting.push_back(*reading);
        }
    }

    /// Whether there was any reading.
    pub(crate) fn has_read(&self) -> bool {
        self.newest.is_some()
    }

    /// The walk begins at a state, until which the foot was at rest or was not.
    pub(crate) fn begin(&mut self, nav: &NavState, at_rest: bool) {
        self.time = nav.time;
        while let Some(reading) = self.next_until(nav.time) {
            if at_rest {
                self.stance.stood_for = SETTLED;
                self.stance.gather(&(nav.attitude * reading));
            }
        }
    }

    /// Goes on to the filter's newest state; corrects its heading if a stance shows a field that
    /// can be believed.
    pub(crate) fn update(
        &mut self,
        filter: &mut ErrorStateFilter,
        monitor: &mut HealthMonitor,
        stationary: bool,
        recorder: &mut impl FilterRecorder,
    ) {
        let Some(field) = self.go_on(&filter.estimate.nav, stationary, monitor.longest_gap())
        else {
            return;
        };
        let Some(reference) = &self.reference else {
            self.reference = Reference::of(field, filter);
            return;
        };
        let agrees = reference.field.agrees(&field, &self.config);
        let variance = self.config.std_deg.to_radians().powi(2) + reference.heading_variance;
        let turned = within_half_a_turn(reference.field.azimuth - field.azimuth);
        monitor.magnetic(agrees && filter.heading(turned, variance, recorder).accepted);
    }

    /// Goes on to a state; the field of its stance as soon as it is known, once.
    fn go_on(&mut self, nav: &NavState, stationary: bool, longest_gap: f64) -> Option<Field> {
        let elapsed = nav.time - std::mem::replace(&mut self.time, nav.time);
        if elapsed > longest_gap {
            self.stance = Stance::default();
        }
        self.stance.step(stationary, elapsed);
        let newest = iter::from_fn(|| self.next_until(nav.time)).last();
        if let Some(reading) = newest.filter(|_| stationary) {
            self.stance.gather(&(nav.attitude * reading));
        }
        self.stance.tell()
    }

    /// The next of the readings (b) that are not newer than `time`.
    fn next_until(&mut self, time: f64) -> Option<Vector3<f64>> {
        let is_due = self.waiting.front()?.time() <= time;
        if is_due { self.waiting.pop_front().map(|reading| reading.field()) } else { None }
    }
}

impl Reference {
    /// A field, seen with the filter's heading; none where there is no field.
    fn of(field: Field, filter: &ErrorStateFilter) -> Option<Self> {
        let heading_variance = filter.covariance().diagonal(Block::Attitude).z;
        (field.strength > 0.0).then_some(Self { field, heading_variance })
    }
}

impl Stance {
    /// The foot stood, or did not, for `dt` (s).
    fn step(&mut self, stationary: bool, dt: f64) {
        if !stationary {
            self.gone_for += dt;
            return;
        }
        if self.gone_for > GONE {
            *self = Self::default();
        }
        self.gone_for = 0.0;
        self.stood_for += dt;
    }

    fn gather(&mut self, field: &Vector3<f64>) {
        self.sum += field;
        self.readings += 1.0;
    }

    /// The mean field, once.
    fn tell(&mut self) -> Option<Field> {
        if self.told || self.readings == 0.0 || self.stood_for < SETTLED {
            return None;
        }
        self.told = true;
        Some(Field::of(&(self.sum / self.readings)))
    }
}

impl Field {
    fn of(field: &Vector3<f64>) -> Self {
        let dip = (-field.z).atan2(field.x.hypot(field.y));
        Self { strength: field.norm(), dip, azimuth: field.y.atan2(field.x) }
    }

    fn agrees(&self, other: &Self, config: &MagnetometerConfig) -> bool {
        (other.strength / self.strength - 1.0).abs() <= config.strength_tolerance
            && (other.dip - self.dip).abs() <= config.dip_tolerance_deg.to_radians()
    }
}

fn within_half_a_turn(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    use super::*;
    use crate::config::{Config, HealthConfig};
    use crate::ins::alignment::Aligned;
    use crate::math::rotation::about_up;
    use crate::simulation::SimulationSettings;

    const DT: f64 = 0.01;
    const HEADING_STD: f64 = 0.1;

    /// A foot that stands in a field (n), now and then, with a heading that its filter has wrong.
    struct Trial {
        compass: Compass,
        filter: ErrorStateFilter,
        monitor: HealthMonitor,
        truth: UnitQuaternion<f64>,
    }

    impl Trial {
        /// After a rest of half a second in the field.
        fn new(truth: UnitQuaternion<f64>, field: &Vector3<f64>) -> Self {
            let config = MagnetometerConfig { heading: true, ..MagnetometerConfig::default() };
            let aligned = Aligned {
                attitude: truth,
                gyro_bias: Vector3::zeros(),
                at_rest: true,
                rest: 1.0,
                sway: 0.0,
            };
            let strapdown = SimulationSettings::default().strapdown();
            let filter = ErrorStateFilter::new(&Config::default(), &aligned, 0.0, &strapdown);
            let monitor = HealthMonitor::new(HealthConfig::default());
            let mut trial =
                Self { compass: Compass::new(&config).unwrap(), filter, monitor, truth };
            trial.read(field);
            trial.compass.begin(&trial.filter.estimate.nav, true);
            trial.go(40, true, field);
            trial.go(40, false, field);
            trial
        }

        /// The magnetometer reads the field, in a unit in which rounding tells two readings apart.
        fn read(&mut self, field: &Vector3<f64>) {
            let time = self.filter.estimate.nav.time;
            let reading = self.truth.inverse() * field * (1.0 + 1e-9 * time);
            self.compass.push(&MagSample::new(time, reading.into()).unwrap());
        }

        fn go(&mut self, samples: u32, stationary: bool, field: &Vector3<f64>) {
            for _ in 0..samples {
                self.filter.estimate.nav.time += DT;
                self.read(field);
                self.compass.update(&mut self.filter, &mut self.monitor, stationary, &mut ());
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
            (self.monitor.updates.magnetic, self.monitor.updates.magnetic_rejected)
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
        fn a_stance_takes_away_the_share_of_the_error_that_the_variances_say(truth in attitudes(), azimuth in -3.2..3.2, error in -0.3..0.3) {
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
        fn a_bent_field_leaves_the_heading_alone(truth in attitudes(), error in -0.1..0.1, turn in 0.8..5.4, stretch in 0.12..2.0, dip in 0.1..0.3) {
            let tilted = UnitQuaternion::from_euler_angles(dip, 0.0, 0.0);
            for bent in [about_up(turn) * north(), north() * (1.0 + stretch), north() / (1.0 + stretch), tilted * north(), Vector3::zeros()] {
                let mut trial = Trial::new(truth, &north());
                trial.turn_away(error);
                trial.go(40, true, &bent);
                prop_assert_eq!(trial.counts(), (0, 1));
                prop_assert!((trial.error() - error).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn a_stance_counts_once_and_the_next_one_again() {
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
    fn a_foot_that_hardly_stands_tells_nothing() {
        let mut trial = Trial::new(UnitQuaternion::identity(), &north());
        for _ in 0..5 {
            trial.go(8, true, &north());
            trial.go(30, false, &north());
        }
        assert_eq!(trial.counts(), (0, 0));
    }

    #[test]
    fn readings_of_the_swing_and_held_ones_are_not_those_of_the_stance() {
        let mut trial = Trial::new(UnitQuaternion::identity(), &north());
        trial.go(30, false, &Vector3::new(50.0, 0.0, 0.0));
        let held = MagSample::new(trial.filter.estimate.nav.time, [30.0, 0.0, 0.0]).unwrap();
        for stationary in [false, true] {
            for _ in 0..40 {
                trial.filter.estimate.nav.time += DT;
                trial.compass.push(&held);
                trial.compass.update(&mut trial.filter, &mut trial.monitor, stationary, &mut ());
            }
        }
        assert_eq!(trial.counts(), (0, 0));
        trial.go(1, true, &north());
        assert_eq!(trial.counts(), (1, 0));
    }

    #[test]
    fn a_stance_does_not_go_on_over_a_gap() {
        let mut trial = Trial::new(UnitQuaternion::identity(), &north());
        trial.go(30, true, &north());
        trial.filter.estimate.nav.time += 10.0;
        trial.go(30, true, &north());
        assert_eq!(trial.counts(), (2, 0));
    }

    #[test]
    fn a_start_in_motion_takes_the_field_of_the_first_stance() {
        let mut trial = Trial::new(UnitQuaternion::identity(), &north());
        trial.compass =
            Compass::new(&MagnetometerConfig { heading: true, ..MagnetometerConfig::default() })
                .unwrap();
        trial.read(&Vector3::new(99.0, 0.0, 0.0));
        trial.compass.begin(&trial.filter.estimate.nav, false);
        trial.go(30, false, &Vector3::new(99.0, 0.0, 0.0));
        trial.go(30, true, &north());
        trial.go(30, false, &north());
        trial.turn_away(0.05);
        trial.go(30, true, &north());
        assert_eq!(trial.counts(), (1, 0));
        assert!(trial.error() < 0.04, "{}", trial.error());
    }

    #[test]
    fn a_reading_that_is_not_finite_says_what_to_do() {
        let error = MagSample::new(2.5, [1.0, f64::NAN, 3.0]).unwrap_err().to_string();
        assert!(
            error.starts_with(
                "at 2.5 s the magnetic field is [1.0, NaN, 3.0]; expected three finite numbers"
            ),
            "{error}"
        );
    }
}
