//! One stride of the foot, from heel-off to the next heel-off.
//!
//! The foot rotates about the ball until toe-off, swings to the next foothold, strikes with the
//! heel, rotates about the heel to foot flat, and stands.  The rotation centre moves from ball to
//! heel in swing and back in flat stance; every angle and every displacement is a sum of smooth
//! ramps.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::math::rotation;
use crate::simulation::draw;
use crate::simulation::dual::{Dual, Ramp};
use crate::simulation::footing;
use crate::simulation::footing::Foothold;
use crate::simulation::gait::Gait;

/// Position of ball and heel along the foot from the point of the sole below the sensor, m.
const BALL: f64 = 0.08;
const HEEL: f64 = -0.12;
/// Fractions of the contact for loading response (heel strike to foot flat) and for flat stance.
const LOADING_SHARE: f64 = 0.14;
const FLAT_SHARE: f64 = 0.48;
/// Fraction of push-off at which the translation of the sole starts, and fraction of the loading
/// response at which it ends: shoe and heel are compliant.
const TRAVEL_START: f64 = 0.6;
const TRAVEL_END: f64 = 0.5;
/// Fractions of the swing at which the heel stops rising, the toes start to rise, and the toes stop
/// rising.
const HEEL_RISE_END: f64 = 0.22;
const TOE_RISE_START: f64 = 0.08;
const TOE_RISE_END: f64 = 0.97;
/// Skew of push-off and of swing: the heel rises slowly at first; foot speed peaks late in swing.
const PUSH_SKEW: f64 = 0.9;
const SWING_SKEW: f64 = 0.3;
/// Fraction of the angles, the clearance and the impact in a stride of zero length.
const MIN_EFFORT: f64 = 0.35;
/// Additional clearance per height difference of the footholds: the sole clears the edge of the
/// tread.
const LIFT_PER_RISE: f64 = 0.5;
/// Maximum inversion and toe-out angle in swing (rad), and maximum lateral circumduction (m).
const INVERSION: f64 = 0.28;
const TOE_OUT: f64 = 0.2;
const CIRCUMDUCTION: f64 = 0.025;
/// Roll and yaw per heel-rise pitch: push-off is over the big toe.
const ROLL_PER_HEEL_RISE: f64 = 0.25;
const YAW_PER_HEEL_RISE: f64 = -0.2;
/// Additional gain of the tremor in swing.
const TREMOR_GAIN_IN_SWING: f64 = 50.0;
/// Spread of the lateral movements between strides, as a multiple of the gait's variation.
const LATERAL_SPREAD: f64 = 4.0;
/// Residual pitch at foot flat per stance roll angle.
const PITCH_PER_ROLL: f64 = 0.3;
/// Frequencies of the oscillation after heel strike (forward, lateral, up), Hz, and its decay time
/// constant, s.
const RING_FREQUENCY: Vector3<f64> = Vector3::new(27.0, 22.0, 34.0);
const RING_DECAY: f64 = 0.011;
/// Duration until the oscillation has decayed to the level of the tremor, s.
const RING_DURATION: f64 = 7.0 * RING_DECAY;
/// Peak of x² exp(-x), the envelope of the oscillation.
const RING_PEAK: f64 = 0.541;
/// Components of the impact (forward, lateral, up).
const RING_SHARE: Vector3<f64> = Vector3::new(-0.66, 0.29, 0.70);
/// Angular acceleration of yaw, pitch and roll per acceleration of the impact, rad/m.
const RING_ANGULAR_GAIN: f64 = 7.0;

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
    yaw: Dual,
    pitch: Dual,
    roll: Dual,
}

/// Completed fraction of each movement of a stride, and the oscillation after heel strike (forward,
/// lateral, up), m.
#[derive(Clone, Copy, Debug)]
struct PhaseFractions {
    push: Dual,
    recovery: Dual,
    swing: Dual,
    air: Dual,
    loading: Dual,
    rolling: Dual,
    ring: [Dual; 3],
}

/// Start times of the phases of a stride, s.
#[derive(Clone, Copy, Debug)]
struct Phases {
    heel_off: f64,
    toe_off: f64,
    strike: f64,
    flat: f64,
    end: f64,
}

/// Amplitudes of the movements of a stride.
#[derive(Clone, Copy, Debug)]
struct Amplitudes {
    heel_off_pitch: f64,
    heel_strike_pitch: f64,
    lift: f64,
    inversion: f64,
    toe_out: f64,
    circumduction: f64,
    stance_roll: f64,
    impact: Vector3<f64>,
}

/// One stride from a foothold to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stride {
    from: Foothold,
    to: Foothold,
    phases: Phases,
    amplitudes: Amplitudes,
    sensor: Vector3<f64>,
}

impl Stride {
    /// The stride from `from` with heel-off at `start` (s).
    pub(super) fn new(
        gait: &Gait,
        start: f64,
        from: Foothold,
        to: Foothold,
        random: &mut ChaCha8Rng,
    ) -> Self {
        let duration = gait.stride_duration * draw::factor(random, gait.variation);
        let amplitudes = Amplitudes::draw(gait, &(to.position - from.position), random);
        Self {
            from,
            to,
            phases: Phases::new(gait, start, duration),
            amplitudes,
            sensor: gait.sensor_position,
        }
    }

    /// Time of heel-off, s.
    pub(super) fn start(&self) -> f64 {
        self.phases.heel_off
    }

    /// Time of the next heel-off, s.
    pub(super) fn end(&self) -> f64 {
        self.phases.end
    }

    /// Whether the foot is flat and the impact oscillation has decayed.
    pub(super) fn is_flat(&self, time: f64) -> bool {
        time <= self.phases.heel_off
            || time >= self.phases.flat.max(self.phases.strike + RING_DURATION)
    }

    /// The foot at `time` (s) with the tremor of its three angles (rad); before and after the
    /// stride it stands on its footholds.
    pub(super) fn at(&self, time: f64, tremor: &[Dual; 3]) -> FootState {
        let fractions = self.fractions(time);
        let (attitude, rate) = attitude_and_rate(&self.angles(&fractions, tremor));
        let pivot = Dual::constant(BALL) + (fractions.swing - fractions.rolling) * (HEEL - BALL);
        let (base, base_rate) = self.pivot_motion(&fractions, pivot);
        let toes = attitude * Vector3::x();
        let arm = attitude * self.sensor - pivot.value * toes;
        FootState {
            position: base + arm,
            velocity: base_rate + rate.cross(&arm) - pivot.rate * toes,
            attitude,
        }
    }

    fn fractions(&self, time: f64) -> PhaseFractions {
        let phases = &self.phases;
        let rolling = phases.rolling().at(time);
        PhaseFractions {
            push: phases.push().at(time),
            recovery: phases.recovery().at(time),
            swing: phases.swing().at(time),
            air: phases.rise().at(time) - phases.fall().at(time),
            loading: phases.loading().at(time),
            rolling,
            ring: self.ring(time - phases.strike, Dual::constant(1.0) - rolling),
        }
    }

    fn angles(&self, fractions: &PhaseFractions, tremor: &[Dual; 3]) -> Angles {
        let amplitudes = &self.amplitudes;
        let PhaseFractions { air, recovery, loading, .. } = *fractions;
        let heel_rise = (fractions.push - recovery) * amplitudes.heel_off_pitch;
        let inward = (loading - fractions.rolling) * amplitudes.stance_roll;
        let tremor_gain = Dual::constant(1.0) + air * TREMOR_GAIN_IN_SWING;
        let oscillation =
            |axis: usize| tremor[axis] * tremor_gain + fractions.ring[axis] * RING_ANGULAR_GAIN;
        let turn = footing::wrap(self.to.yaw - self.from.yaw);
        Angles {
            yaw: Dual::constant(self.from.yaw)
                + fractions.swing * turn
                + air * amplitudes.toe_out
                + heel_rise * YAW_PER_HEEL_RISE
                + oscillation(1),
            pitch: heel_rise
                + (recovery - loading) * amplitudes.heel_strike_pitch
                + inward * PITCH_PER_ROLL
                + oscillation(2),
            roll: air * amplitudes.inversion
                + heel_rise * ROLL_PER_HEEL_RISE
                + inward
                + oscillation(0),
        }
    }

    /// Position (m) and velocity (m/s) of the rotation centre, `pivot` (m) along the foot.
    fn pivot_motion(
        &self,
        fractions: &PhaseFractions,
        pivot: Dual,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (old, new) = (toes(&self.from), toes(&self.to));
        let left = Vector3::z().cross(&new);
        let terms = [
            (self.from.position, Dual::constant(1.0)),
            (old, pivot),
            (self.to.position - self.from.position, fractions.swing),
            (new - old, fractions.swing * pivot),
            (
                self.amplitudes.lift * Vector3::z() + self.amplitudes.circumduction * left,
                fractions.air,
            ),
            (new, fractions.ring[0]),
            (left, fractions.ring[1]),
            (Vector3::z(), fractions.ring[2]),
        ];
        let position = terms.iter().map(|(direction, share)| direction * share.value).sum();
        (position, terms.iter().map(|(direction, share)| direction * share.rate).sum())
    }

    /// Oscillation (forward, lateral, up) at the time `since` heel strike (s), m; its acceleration
    /// is continuous, and it fades out as the foot rolls.
    fn ring(&self, since: f64, fading: Dual) -> [Dual; 3] {
        if since <= 0.0 || fading == Dual::ZERO {
            return [Dual::ZERO; 3];
        }
        let x = Dual { value: since, rate: 1.0 } * (1.0 / RING_DECAY);
        let envelope = x * x * (x * -1.0).exp() * fading;
        std::array::from_fn(|axis| {
            let frequency = TAU * RING_FREQUENCY[axis];
            let amplitude = self.amplitudes.impact[axis] / (RING_PEAK * frequency * frequency);
            envelope * Dual { value: frequency * since, rate: frequency }.sin() * amplitude
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
        Ramp::new(self.heel_off, self.in_swing(HEEL_RISE_END)).skewed(PUSH_SKEW)
    }

    fn recovery(&self) -> Ramp {
        Ramp::new(self.in_swing(TOE_RISE_START), self.in_swing(TOE_RISE_END))
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

impl Amplitudes {
    fn draw(gait: &Gait, displacement: &Vector3<f64>, random: &mut ChaCha8Rng) -> Self {
        let reach = (displacement.norm() / gait.stride_length).min(1.0);
        let effort = MIN_EFFORT + (1.0 - MIN_EFFORT) * reach;
        let mut vary = |spread: f64| effort * draw::factor(random, spread * gait.variation);
        Self {
            heel_off_pitch: gait.heel_off_pitch * vary(1.0),
            heel_strike_pitch: gait.heel_strike_pitch * vary(1.0),
            lift: gait.swing_clearance * vary(1.0) + LIFT_PER_RISE * displacement.z.abs(),
            inversion: INVERSION * vary(LATERAL_SPREAD),
            toe_out: TOE_OUT * vary(LATERAL_SPREAD),
            circumduction: CIRCUMDUCTION * vary(LATERAL_SPREAD),
            stance_roll: gait.stance_roll * vary(LATERAL_SPREAD),
            impact: gait.impact * RING_SHARE.map(|share| share * vary(LATERAL_SPREAD)),
        }
    }
}

/// Horizontal direction of the toes.
fn toes(foothold: &Foothold) -> Vector3<f64> {
    Vector3::new(foothold.yaw.cos(), foothold.yaw.sin(), 0.0)
}

/// Rotation from the foot frame to n and angular rate in n (rad/s), from yaw, pitch (toes up) and
/// roll in this order.
fn attitude_and_rate(angles: &Angles) -> (UnitQuaternion<f64>, Vector3<f64>) {
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

    const STILL: [Dual; 3] = [Dual::ZERO; 3];

    fn stride(gait: &Gait) -> Stride {
        let from = Foothold { position: Vector3::zeros(), yaw: 0.3, by_lift: false };
        let to = Foothold { position: Vector3::new(1.2, 0.5, 0.34), yaw: 0.9, by_lift: false };
        Stride::new(gait, 1.0, from, to, &mut draw::stream(2, draw::Stream::Gait))
    }

    fn instants(stride: &Stride) -> impl Iterator<Item = f64> {
        let (start, length) = (stride.start(), stride.end() - stride.start());
        (-20..=220).map(move |k| start + length * f64::from(k) / 200.0)
    }

    #[test]
    fn velocity_is_the_derivative_of_position() {
        let step = 1e-6;
        let tremor = |time: f64| [Dual { value: 0.02 * time, rate: 0.02 }; 3];
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
    fn pose_and_velocity_are_continuous_at_phase_changes() {
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
    fn stride_starts_and_ends_at_rest_on_its_footholds() {
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
    fn sole_stays_above_level_ground() {
        for gait in [Gait::walk(), Gait::slow(), Gait::run()] {
            let gait = Gait { variation: 0.0, impact: 0.0, stance_roll: 0.0, ..gait };
            let ahead =
                Foothold { position: gait.stride_length * Vector3::x(), yaw: 0.0, by_lift: false };
            let origin = Foothold { position: Vector3::zeros(), yaw: 0.0, by_lift: false };
            let stride =
                Stride::new(&gait, 0.0, origin, ahead, &mut draw::stream(2, draw::Stream::Gait));
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
