//! A ride in a lift: the foot stands, and the floor under it moves.

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

use crate::simulation::footing::Foothold;
use crate::simulation::gait::Gait;
use crate::simulation::stride::{FootState, Stride};
use crate::simulation::timed::{Ramp, Timed};

/// Speed that a lift in a house travels at, m/s, and its greatest acceleration, m/s².
const SPEED: f64 = 1.0;
const ACCELERATION: f64 = 0.8;
/// Greatest slope of a ramp that rises from 0 to 1 in 1 s, 1/s.
const STEEPEST: f64 = 1.875;
/// Time to stand in the cabin before it starts and after it has stopped, s.
const DOORS: f64 = 3.0;

/// The ride from one floor to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct LiftRide {
    /// The stride that the foot would take after the ride: before it, the foot stands.
    standing: Stride,
    start: f64,
    /// Velocity of the cabin at its fastest, positive upwards, m/s.
    velocity: f64,
    speeding_up: Ramp,
    slowing_down: Ramp,
}

impl LiftRide {
    /// The ride that begins at `start` (s) on the foothold `from` and ends on `to`, straight above
    /// or below it.
    pub(super) fn new(
        gait: &Gait,
        start: f64,
        from: Foothold,
        to: Foothold,
        random: &mut ChaCha8Rng,
    ) -> Self {
        let height = to.position.z - from.position.z;
        let speed = SPEED.min((height.abs() * ACCELERATION / STEEPEST).sqrt());
        let (ramp, departure) = (speed * STEEPEST / ACCELERATION, start + DOORS);
        let brake = departure + height.abs() / speed;
        let slowing_down = Ramp::new(brake, brake + ramp);
        Self {
            standing: Stride::new(gait, slowing_down.end + DOORS, from, from, random),
            start,
            velocity: speed.copysign(height),
            speeding_up: Ramp::new(departure, departure + ramp),
            slowing_down,
        }
    }

    /// When the foot enters the cabin, s.
    pub(super) fn start(&self) -> f64 {
        self.start
    }

    /// When it may leave, s.
    pub(super) fn end(&self) -> f64 {
        self.standing.start()
    }

    /// Whether the floor under the foot is at rest.
    pub(super) fn is_flat(&self, time: f64) -> bool {
        time <= self.speeding_up.start || time >= self.slowing_down.end
    }

    /// The foot at `time` (s), with the tremor of its three angles (rad).
    pub(super) fn at(&self, time: f64, tremor: &[Timed; 3]) -> FootState {
        let standing = self.standing.at(time, tremor);
        let climbed = (integral(&self.speeding_up, time) - integral(&self.slowing_down, time))
            * self.velocity;
        FootState {
            position: standing.position + climbed.value * Vector3::z(),
            velocity: standing.velocity + climbed.rate * Vector3::z(),
            ..standing
        }
    }
}

/// Integral over time of a ramp without skew, s.
fn integral(ramp: &Ramp, time: f64) -> Timed {
    let duration = ramp.end - ramp.start;
    let u = ((time - ramp.start) / duration).clamp(0.0, 1.0);
    let within = duration * u.powi(4) * (2.5 - 3.0 * u + u * u);
    Timed { value: within + (time - ramp.end).max(0.0), rate: ramp.at(time).value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::draw;

    const STILL: [Timed; 3] = [Timed::ZERO; 3];

    fn ride(height: f64) -> LiftRide {
        let from = Foothold { position: Vector3::new(1.0, 2.0, 3.0), yaw: 0.4, by_lift: false };
        let to =
            Foothold { position: from.position + height * Vector3::z(), by_lift: true, ..from };
        LiftRide::new(&Gait::walk(), 5.0, from, to, &mut draw::stream(2, draw::Cause::Gait))
    }

    #[test]
    fn it_ends_where_it_leads_to_and_is_never_too_fast() {
        for height in [-12.0, -0.5, 0.2, 30.0] {
            let ride = ride(height);
            let at = |time: f64| ride.at(time, &STILL);
            assert!(
                (at(ride.end()).position - at(ride.start()).position - height * Vector3::z())
                    .norm()
                    < 1e-12
            );
            assert!(at(ride.end()).velocity.norm() < 1e-12);
            let (step, mut time) = (0.01, ride.start());
            while time < ride.end() {
                let (before, after) = (at(time), at(time + step));
                let difference = (after.position - before.position) / step;
                assert!(
                    (difference - 0.5 * (before.velocity + after.velocity)).norm() < 1e-4,
                    "at {time}"
                );
                assert!((after.velocity - before.velocity).norm() / step < ACCELERATION + 1e-9);
                assert!(after.velocity.norm() < SPEED + 1e-12);
                assert!(!ride.is_flat(time) || before.velocity.norm() < 1e-12);
                time += step;
            }
        }
    }
}
