//! Lever-arm estimation for a foot that rolls about a point of the ground throughout stance.

use std::f64::consts::PI;

use footnav::config::AlignmentConfig;
use footnav::detectors::Scripted;
use footnav::ins::strapdown::{Increments, MechanizationKind, Strapdown};
use footnav::types::nav_state::NavState;
use footnav::{Batch, Config, ImuSample, Trajectory};
use nalgebra::{UnitQuaternion, Vector3};

const RATE: f64 = 200.0;
const STRIDES: u32 = 30;
const STRIDE_LENGTH: f64 = 1.2;
/// Duration of the swing, samples.
const SWING: u32 = 140;
/// Half of the duration of the contact, samples.
const HALF_CONTACT: u32 = 40;
/// Minimum angular rate in stance, rad/s.
const MIN_RATE: f64 = 0.2;
/// Growth of the angular rate towards both ends of the contact, rad/s³.
const GROWTH: f64 = 60.0;

/// Pitch (toes down, rad) and its rate `time` s from the middle of a stance.
fn roll(time: f64) -> (f64, f64) {
    (MIN_RATE * time + GROWTH * time.powi(3) / 3.0, MIN_RATE + GROWTH * time.powi(2))
}

fn attitude(pitch: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::y_axis(), pitch)
}

/// Cubic Hermite interpolation between two values with given slopes, and its derivative.
fn hermite(from: (f64, f64), to: (f64, f64), duration: f64, time: f64) -> (f64, f64) {
    let (s, rise) = (time / duration, to.0 - from.0);
    let (a, b) = (from.1 * duration, to.1 * duration);
    let value =
        from.0 + a * s + (3.0 * rise - 2.0 * a - b) * s.powi(2) + (a + b - 2.0 * rise) * s.powi(3);
    let slope = a + 2.0 * (3.0 * rise - 2.0 * a - b) * s + 3.0 * (a + b - 2.0 * rise) * s.powi(2);
    (value, slope / duration)
}

/// Pose of a foot: pitch and position with their derivatives.
#[derive(Clone, Copy)]
struct Pose {
    pitch: (f64, f64),
    position: [(f64, f64); 3],
}

impl Pose {
    /// In contact, `time` s from mid-stance, with the sensor at `lever` (b) from the rotation
    /// centre.
    fn rolling(foothold: f64, lever: &Vector3<f64>, time: f64) -> Self {
        let pitch = roll(time);
        let arm = attitude(pitch.0) * lever;
        let velocity = Vector3::new(0.0, pitch.1, 0.0).cross(&arm);
        let position =
            [0, 1, 2].map(|k| (if k == 0 { foothold } else { 0.0 } + arm[k], velocity[k]));
        Self { pitch, position }
    }

    fn at_rest(foothold: f64, lever: &Vector3<f64>) -> Self {
        Self {
            pitch: (0.0, 0.0),
            position: [(foothold + lever.x, 0.0), (lever.y, 0.0), (lever.z, 0.0)],
        }
    }

    /// `time` s into the swing from this pose to `to`, with a foot clearance of 0.1 m.
    fn swing(&self, to: &Self, time: f64) -> Self {
        let mut position = [0, 1, 2]
            .map(|k: usize| hermite(self.position[k], to.position[k], seconds(SWING), time));
        let phase = PI * time / seconds(SWING);
        position[2].0 += 0.1 * phase.sin().powi(2);
        position[2].1 += 0.1 * PI / seconds(SWING) * (2.0 * phase).sin();
        Self { pitch: hermite(self.pitch, to.pitch, seconds(SWING), time), position }
    }

    fn state(&self, time: f64) -> NavState {
        NavState {
            time,
            position: Vector3::from(self.position.map(|position| position.0)),
            velocity: Vector3::from(self.position.map(|position| position.1)),
            attitude: attitude(self.pitch.0),
        }
    }
}

/// States of a walk with the sensor at `lever` from the rotation centre, and the stance of each.
fn walk(lever: &Vector3<f64>) -> (Vec<NavState>, Vec<bool>) {
    let foothold = |stride: u32| STRIDE_LENGTH * f64::from(stride);
    let on_ground = |stride: u32, time: f64| Pose::rolling(foothold(stride), lever, time);
    let (first, last) = (Pose::at_rest(0.0, lever), Pose::at_rest(foothold(STRIDES + 1), lever));
    let mut walk = Walk::default();
    walk.extend(400, |_| (first, true));
    let mut from = first;
    for stride in 1..=STRIDES {
        let to = on_ground(stride, -seconds(HALF_CONTACT));
        walk.extend(SWING, |time| (from.swing(&to, time), false));
        walk.extend(2 * HALF_CONTACT, |time| {
            let time = time - seconds(HALF_CONTACT);
            (on_ground(stride, time), time.abs() < 0.06)
        });
        from = on_ground(stride, seconds(HALF_CONTACT));
    }
    walk.extend(SWING, |time| (from.swing(&last, time), false));
    walk.extend(200, |_| (last, true));
    (walk.states, walk.stance)
}

#[derive(Default)]
struct Walk {
    samples: u32,
    states: Vec<NavState>,
    stance: Vec<bool>,
}

impl Walk {
    /// Appends `samples` states with pose and stance as functions of the time from now (s).
    fn extend(&mut self, samples: u32, pose: impl Fn(f64) -> (Pose, bool)) {
        for sample in 0..samples {
            let (pose, stance) = pose(seconds(sample));
            self.states.push(pose.state(seconds(self.samples)));
            self.stance.push(stance);
            self.samples += 1;
        }
    }
}

fn seconds(samples: u32) -> f64 {
    f64::from(samples) / RATE
}

/// Readings of an ideal sensor.
fn readings(states: &[NavState], config: &Config) -> Vec<ImuSample> {
    let strapdown = Strapdown {
        kind: MechanizationKind::TwoSample,
        gravity: config.gravity(),
        earth_rate: Vector3::zeros(),
        nominal_interval: 1.0 / RATE,
    };
    let mut before = Increments { dt: 0.0, angle: Vector3::zeros(), velocity: Vector3::zeros() };
    let mut samples = vec![ImuSample {
        time: states[0].time,
        specific_force: config.gravity() * Vector3::z(),
        angular_rate: Vector3::zeros(),
    }];
    for pair in states.windows(2) {
        let now = strapdown.inverse(&before, &pair[0], &pair[1]);
        let (force, rate) = (now.velocity / now.dt, now.angle / now.dt);
        samples.push(ImuSample { time: pair[1].time, specific_force: force, angular_rate: rate });
        before = now;
    }
    samples
}

fn track(states: &[NavState], stance: &[bool], config: &Config) -> Trajectory {
    let mut batch =
        Batch::with_detector(config.clone(), RATE, Box::new(Scripted::new(stance.to_vec())))
            .unwrap();
    batch.push_block(&readings(states, config)).unwrap();
    batch.finish().unwrap().0
}

/// Error of the last position, estimate minus truth, m.
fn end_error(lever: &Vector3<f64>, contact_rate: f64) -> Vector3<f64> {
    let mut config = Config {
        alignment: AlignmentConfig { duration: 1.0, ..AlignmentConfig::default() },
        ..Config::default()
    };
    config.filter.contact_rate = contact_rate;
    let (states, stance) = walk(lever);
    let trajectory = track(&states, &stance, &config);
    let displacement = states[states.len() - 1].position - states[0].position;
    Vector3::from(trajectory.position[trajectory.len() - 1]) - displacement
}

#[test]
fn lever_arm_estimation_removes_the_height_drift_of_a_rolling_foot() {
    for forward in [-0.08, 0.08] {
        let lever = Vector3::new(forward, 0.0, 0.07);
        let (uncorrected, estimated) = (end_error(&lever, 0.0), end_error(&lever, 2.0));
        // The vertical velocity of the sensor in stance is the angular rate times the lever arm;
        // the zero-velocity update neglects it over each stride.
        let drift = MIN_RATE * forward * seconds(SWING + 2 * HALF_CONTACT) * f64::from(STRIDES);
        assert!(uncorrected.z / drift > 1.0, "{uncorrected} against {drift}");
        assert!(estimated.norm() < 0.2 * uncorrected.norm(), "{estimated} against {uncorrected}");
    }
}
