//! One stride of the foot, from heel-off to the next heel-off.
//!
//! The sole rolls about the ball until toe-off, swings to the next foothold, strikes with the heel,
//! rolls flat about it, and stands.  The point about which it turns travels from ball to heel in
//! the swing and back while the foot stands flat; every angle and every way is a sum of smooth
//! ramps.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::math::rotation;
use crate::simulation::draw;
use crate::simulation::footing;
use crate::simulation::footing::Foothold;
use crate::simulation::gait::Gait;
use crate::simulation::timed::{Ramp, Timed};

/// Ball and heel from the point of the sole below the sensor, along the foot, m.
const BALL: f64 = 0.08;
const HEEL: f64 = -0.12;
/// Share of the contact in which the foot rolls from the heel onto the sole, and in which it then
/// stands flat.
const LOADING_SHARE: f64 = 0.14;
const FLAT_SHARE: f64 = 0.48;
/// Share of the push after which the sole begins to travel, and share of the loading by which it
/// has arrived: shoe and heel give way.
const TRAVEL_START: f64 = 0.6;
const TRAVEL_END: f64 = 0.5;
/// Share of the swing in which the heel still rises after toe-off, after which the toes begin to
/// rise, and by which they are up.
const HEEL_STILL_RISES: f64 = 0.22;
const TOES_RISE: f64 = 0.08;
const TOES_UP: f64 = 0.97;
/// The heel leaves the ground hesitantly; the foot is fastest late in the swing.
const PUSH_SKEW: f64 = 0.9;
const SWING_SKEW: f64 = 0.3;
/// Part of the angles, the lift and the impact that remains in a stride of no length.
const EFFORT_ON_THE_SPOT: f64 = 0.35;
/// Lift per height difference of the two footholds: the sole must pass the edge of the tread.
const LIFT_PER_RISE: f64 = 0.5;
/// Most that the sole turns inwards and the toes turn out in the swing (rad), and how far the foot
/// swings outwards (m).
const INVERSION: f64 = 0.28;
const TOE_OUT: f64 = 0.2;
const CIRCUMDUCTION: f64 = 0.025;
/// Roll and yaw of the foot per pitch of the raised heel: the push goes over the big toe.
const ROLL_PER_HEEL_RISE: f64 = 0.25;
const YAW_PER_HEEL_RISE: f64 = -0.2;
/// How much more the foot wavers in the air than on the ground.
const WAVER_IN_SWING: f64 = 50.0;
/// Spread of the movements to the side between strides, as a multiple of the gait's variation: no
/// two swings look alike from the side.
const SIDE_SPREAD: f64 = 4.0;
/// Pitch that is left when the foot has rolled flat, per angle of the stance roll.
const PITCH_PER_ROLL: f64 = 0.3;
/// Frequencies of the oscillation after heel strike forwards, sideways and up, Hz, and the time in
/// which it dies down, s.
const RING_FREQUENCY: Vector3<f64> = Vector3::new(27.0, 22.0, 34.0);
const RING_DECAY: f64 = 0.011;
/// Time in which no more is left of it than of a tremor, s.
const RING_OVER: f64 = 7.0 * RING_DECAY;
/// Peak of x² exp(-x), the envelope of the oscillation.
const RING_PEAK: f64 = 0.541;
/// Shares of the impact forwards, sideways and up.
const RING_SHARE: Vector3<f64> = Vector3::new(-0.66, 0.29, 0.70);
/// Angular acceleration of yaw, pitch and roll per acceleration of the impact, rad/m.
const RING_TURN: f64 = 7.0;

/// The foot with its sensor at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FootState {
    /// Position of the sensor in n, m.
    pub(super) position: Vector3<f64>,
    /// Velocity of the sensor in n, m/s.
    pub(super) velocity: Vector3<f64>,
    /// Rotation from the foot frame to n.
    pub(super) attitude: UnitQuaternion<f64>,
}

/// Yaw, pitch (toes up) and roll of the foot, rad.
#[derive(Clone, Copy, Debug)]
struct Angles {
    yaw: Timed,
    pitch: Timed,
    roll: Timed,
}

/// How far the movements of a stride have come, from 0 to 1, and the oscillation after heel strike
/// forwards, sideways and up, m.
#[derive(Clone, Copy, Debug)]
struct Progress {
    push: Timed,
    recovery: Timed,
    swing: Timed,
    air: Timed,
    loading: Timed,
    rolling: Timed,
    ring: [Timed; 3],
}

/// When the parts of a stride begin, s.
#[derive(Clone, Copy, Debug)]
struct Phases {
    heel_off: f64,
    toe_off: f64,
    strike: f64,
    flat: f64,
    end: f64,
}

/// How large the movements of a stride are.
#[derive(Clone, Copy, Debug)]
struct Extent {
    heel_off_pitch: f64,
    heel_strike_pitch: f64,
    lift: f64,
    inversion: f64,
    toe_out: f64,
    circumduction: f64,
    stance_roll: f64,
    impact: Vector3<f64>,
}

/// One stride from a foothold to the next one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stride {
    from: Foothold,
    to: Foothold,
    phases: Phases,
    extent: Extent,
    sensor: Vector3<f64>,
}

impl Stride {
    /// The stride that leaves `from` at `start` (s).
    pub(super) fn new(
        gait: &Gait,
        start: f64,
        from: Foothold,
        to: Foothold,
        random: &mut ChaCha8Rng,
    ) -> Self {
        let duration = gait.stride_duration * draw::factor(random, gait.variation);
        let extent = Extent::draw(gait, &(to.position - from.position), random);
        Self {
            from,
            to,
            phases: Phases::new(gait, start, duration),
            extent,
            sensor: gait.sensor_position,
        }
    }

    /// Heel-off, s.
    pub(super) fn start(&self) -> f64 {
        self.phases.heel_off
    }

    /// The next heel-off, s.
    pub(super) fn end(&self) -> f64 {
        self.phases.end
    }

    /// Whether the foot stands flat and no longer shakes from the impact.
    pub(super) fn is_flat(&self, time: f64) -> bool {
        time <= self.phases.heel_off || time >= self.phases.flat.max(self.phases.strike + RING_OVER)
    }

    /// The foot at `time` (s), with the tremor of its three angles (rad) on top; before and after
    /// the stride it stands on its footholds.
    pub(super) fn at(&self, time: f64, tremor: &[Timed; 3]) -> FootState {
        let progress = self.progress(time);
        let (attitude, rate) = orient(&self.angles(&progress, tremor));
        let pivot = Timed::constant(BALL) + (progress.swing - progress.rolling) * (HEEL - BALL);
        let (base, base_rate) = self.pivot_in_space(&progress, pivot);
        let toes = attitude * Vector3::x();
        let arm = attitude * self.sensor - pivot.value * toes;
        FootState {
            position: base + arm,
            velocity: base_rate + rate.cross(&arm) - pivot.rate * toes,
            attitude,
        }
    }

    fn progress(&self, time: f64) -> Progress {
        let phases = &self.phases;
        let rolling = phases.rolling().at(time);
        Progress {
            push: phases.push().at(time),
            recovery: phases.recovery().at(time),
            swing: phases.swing().at(time),
            air: phases.rise().at(time) - phases.fall().at(time),
            loading: phases.loading().at(time),
            rolling,
            ring: self.ring(time - phases.strike, Timed::constant(1.0) - rolling),
        }
    }

    fn angles(&self, progress: &Progress, tremor: &[Timed; 3]) -> Angles {
        let extent = &self.extent;
        let Progress { air, recovery, loading, .. } = *progress;
        let heel_rise = (progress.push - recovery) * extent.heel_off_pitch;
        let inward = (loading - progress.rolling) * extent.stance_roll;
        let wavering = Timed::constant(1.0) + air * WAVER_IN_SWING;
        let shaking = |axis: usize| tremor[axis] * wavering + progress.ring[axis] * RING_TURN;
        let turn = footing::wrap(self.to.yaw - self.from.yaw);
        Angles {
            yaw: Timed::constant(self.from.yaw)
                + progress.swing * turn
                + air * extent.toe_out
                + heel_rise * YAW_PER_HEEL_RISE
                + shaking(1),
            pitch: heel_rise
                + (recovery - loading) * extent.heel_strike_pitch
                + inward * PITCH_PER_ROLL
                + shaking(2),
            roll: air * extent.inversion + heel_rise * ROLL_PER_HEEL_RISE + inward + shaking(0),
        }
    }

    /// Position (m) and velocity (m/s) of the point about which the foot turns, which is `pivot`
    /// (m) along the foot: on the old foothold, in the air, on the new one.
    fn pivot_in_space(&self, progress: &Progress, pivot: Timed) -> (Vector3<f64>, Vector3<f64>) {
        let (old, new) = (toes(&self.from), toes(&self.to));
        let left = Vector3::z().cross(&new);
        let ways = [
            (self.from.position, Timed::constant(1.0)),
            (old, pivot),
            (self.to.position - self.from.position, progress.swing),
            (new - old, progress.swing * pivot),
            (self.extent.lift * Vector3::z() + self.extent.circumduction * left, progress.air),
            (new, progress.ring[0]),
            (left, progress.ring[1]),
            (Vector3::z(), progress.ring[2]),
        ];
        let position = ways.iter().map(|(way, share)| way * share.value).sum();
        (position, ways.iter().map(|(way, share)| way * share.rate).sum())
    }

    /// The oscillation `since` heel strike (s) forwards, sideways and up, m; it sets in without a
    /// jump of the acceleration and fades as the foot rolls.
    fn ring(&self, since: f64, fading: Timed) -> [Timed; 3] {
        if since <= 0.0 || fading == Timed::ZERO {
            return [Timed::ZERO; 3];
        }
        let x = Timed { value: since, rate: 1.0 } * (1.0 / RING_DECAY);
        let envelope = x * x * (x * -1.0).exp() * fading;
        std::array::from_fn(|axis| {
            let frequency = TAU * RING_FREQUENCY[axis];
            let amplitude = self.extent.impact[axis] / (RING_PEAK * frequency * frequency);
            envelope * Timed { value: frequency * since, rate: frequency }.sin() * amplitude
        })
    }
}

impl Phases {
    fn new(gait: &Gait, start: f64, duration: f64) -> Self {
        let contact = gait.stance_share * duration;
        let push = (1.0 - LOADING_SHARE - FLAT_SHARE) * contact;
        let strike = start + push + duration - contact;
        Self {
            heel_off: start,
            toe_off: start + push,
            strike,
            flat: strike + LOADING_SHARE * contact,
            end: start + duration,
        }
    }

    fn in_swing(&self, share: f64) -> f64 {
        self.toe_off + share * (self.strike - self.toe_off)
    }

    fn travel_start(&self) -> f64 {
        self.heel_off + TRAVEL_START * (self.toe_off - self.heel_off)
    }

    fn push(&self) -> Ramp {
        Ramp::new(self.heel_off, self.in_swing(HEEL_STILL_RISES)).skewed(PUSH_SKEW)
    }

    fn recovery(&self) -> Ramp {
        Ramp::new(self.in_swing(TOES_RISE), self.in_swing(TOES_UP))
    }

    fn swing(&self) -> Ramp {
        let end = self.strike + TRAVEL_END * (self.flat - self.strike);
        Ramp::new(self.travel_start(), end).skewed(SWING_SKEW)
    }

    fn rise(&self) -> Ramp {
        Ramp::new(self.travel_start(), self.in_swing(0.5))
    }

    fn fall(&self) -> Ramp {
        Ramp::new(self.in_swing(0.5), self.strike)
    }

    fn loading(&self) -> Ramp {
        Ramp::new(self.strike, self.flat)
    }

    fn rolling(&self) -> Ramp {
        Ramp::new(self.flat, self.end)
    }
}

impl Extent {
    fn draw(gait: &Gait, way: &Vector3<f64>, random: &mut ChaCha8Rng) -> Self {
        let reach = (way.norm() / gait.stride_length).min(1.0);
        let effort = EFFORT_ON_THE_SPOT + (1.0 - EFFORT_ON_THE_SPOT) * reach;
        let mut vary = |spread: f64| effort * draw::factor(random, spread * gait.variation);
        Self {
            heel_off_pitch: gait.heel_off_pitch * vary(1.0),
            heel_strike_pitch: gait.heel_strike_pitch * vary(1.0),
            lift: gait.swing_clearance * vary(1.0) + LIFT_PER_RISE * way.z.abs(),
            inversion: INVERSION * vary(SIDE_SPREAD),
            toe_out: TOE_OUT * vary(SIDE_SPREAD),
            circumduction: CIRCUMDUCTION * vary(SIDE_SPREAD),
            stance_roll: gait.stance_roll * vary(SIDE_SPREAD),
            impact: gait.impact * RING_SHARE.map(|share| share * vary(SIDE_SPREAD)),
        }
    }
}

/// Direction of the toes on the ground.
fn toes(foothold: &Foothold) -> Vector3<f64> {
    Vector3::new(foothold.yaw.cos(), foothold.yaw.sin(), 0.0)
}

/// Rotation from the foot frame to n, and angular rate in n (rad/s): yaw, then pitch with the toes
/// up, then roll.
fn orient(angles: &Angles) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let yawed = rotation::about_up(angles.yaw.value);
    let pitched = yawed * rotation::exp(&(-angles.pitch.value * Vector3::y()));
    let rolled = pitched * rotation::exp(&(angles.roll.value * Vector3::x()));
    let rate = angles.yaw.rate * Vector3::z() - angles.pitch.rate * (yawed * Vector3::y())
        + angles.roll.rate * (pitched * Vector3::x());
    (rolled, rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STILL: [Timed; 3] = [Timed::ZERO; 3];

    fn stride(gait: &Gait) -> Stride {
        let from = Foothold { position: Vector3::zeros(), yaw: 0.3, by_lift: false };
        let to = Foothold { position: Vector3::new(1.2, 0.5, 0.34), yaw: 0.9, by_lift: false };
        Stride::new(gait, 1.0, from, to, &mut draw::stream(2, draw::Cause::Gait))
    }

    fn instants(stride: &Stride) -> impl Iterator<Item = f64> {
        let (start, length) = (stride.start(), stride.end() - stride.start());
        (-20..=220).map(move |k| start + length * f64::from(k) / 200.0)
    }

    #[test]
    fn the_velocity_is_the_derivative_of_the_position() {
        let step = 1e-6;
        let tremor = |time: f64| [Timed { value: 0.02 * time, rate: 0.02 }; 3];
        for gait in [Gait::walk(), Gait::slow(), Gait::run()] {
            let stride = stride(&gait);
            for time in instants(&stride) {
                let position = |time: f64| stride.at(time, &tremor(time)).position;
                let difference = (position(time + step) - position(time - step)) / (2.0 * step);
                let velocity = stride.at(time, &tremor(time)).velocity;
                assert!(
                    (difference - velocity).norm() < 1e-6,
                    "at {time}: {difference} {velocity}"
                );
            }
        }
    }

    #[test]
    fn nothing_jumps() {
        let step = 1e-5;
        let stride = stride(&Gait::run());
        for time in [
            stride.phases.heel_off,
            stride.phases.toe_off,
            stride.phases.strike,
            stride.phases.flat,
            stride.end(),
        ] {
            let (before, after) = (stride.at(time - step, &STILL), stride.at(time + step, &STILL));
            assert!((before.position - after.position).norm() < 1e-4);
            assert!((before.velocity - after.velocity).norm() < 3e-3);
            assert!(before.attitude.angle_to(&after.attitude) < 1e-3);
        }
    }

    #[test]
    fn a_stride_begins_and_ends_at_rest_on_its_footholds() {
        let gait = Gait::walk();
        let stride = stride(&gait);
        for (time, foothold) in [(stride.start(), stride.from), (stride.end(), stride.to)] {
            let state = stride.at(time, &STILL);
            assert!((state.position - foothold.position - gait.sensor_position).norm() < 1e-12);
            assert!(state.velocity.norm() < 1e-12);
            assert!(state.attitude.angle_to(&rotation::about_up(foothold.yaw)) < 1e-7);
        }
    }

    #[test]
    fn the_sole_stays_above_the_ground_on_level_ground() {
        for gait in [Gait::walk(), Gait::slow(), Gait::run()] {
            let gait = Gait { variation: 0.0, impact: 0.0, stance_roll: 0.0, ..gait };
            let ahead =
                Foothold { position: gait.stride_length * Vector3::x(), yaw: 0.0, by_lift: false };
            let origin = Foothold { position: Vector3::zeros(), yaw: 0.0, by_lift: false };
            let stride =
                Stride::new(&gait, 0.0, origin, ahead, &mut draw::stream(2, draw::Cause::Gait));
            for time in instants(&stride) {
                let state = stride.at(time, &STILL);
                for end in [BALL, HEEL] {
                    let sole = state.position
                        + state.attitude * (end * Vector3::x() - gait.sensor_position);
                    assert!(sole.z > -0.004, "{sole} at {time}");
                }
            }
        }
    }
}
