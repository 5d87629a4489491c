//! A lift ride: the foot stands on a floor that moves vertically.

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

use crate::simulation::dual::{Dual, Ramp};
use crate::simulation::footing::Foothold;
use crate::simulation::gait::Gait;
use crate::simulation::stride::{FootState, Stride};

/// Speed of a residential lift, m/s, and its maximum acceleration, m/s².
const SPEED: f64 = 1.0;
const ACCELERATION: f64 = 0.8;
/// Maximum slope of a ramp that rises from 0 to 1 in 1 s, 1/s.
const MAX_RAMP_SLOPE: f64 = 1.875;
/// Standing time in the cabin before departure and after arrival, s.
const DOOR_TIME: f64 = 3.0;

/// The ride from one floor to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct LiftRide {
    /// A stride that starts at the end of the ride; before its start the foot stands.
    standing: Stride,
    start: f64,
    /// Cruise velocity of the cabin, positive upwards, m/s.
    velocity: f64,
    acceleration: Ramp,
    deceleration: Ramp,
}

impl LiftRide {
    /// The ride that starts at `start` (s) on the foothold `from` and ends on `to`, vertically
    /// above or below it.
    pub(super) fn new(
        gait: &Gait,
        start: f64,
        from: Foothold,
        to: Foothold,
        random: &mut ChaCha8Rng,
    ) -> Self {
        let height = to.position.z - from.position.z;
        let speed = SPEED.min((height.abs() * ACCELERATION / MAX_RAMP_SLOPE).sqrt());
        let (ramp, departure) = (speed * MAX_RAMP_SLOPE / ACCELERATION, start + DOOR_TIME);
        let brake = departure + height.abs() / speed;
        let deceleration = Ramp::new(brake, brake + ramp);
        Self {
            standing: Stride::new(gait, deceleration.end + DOOR_TIME, from, from, random),
            start,
            velocity: speed.copysign(height),
            acceleration: Ramp::new(departure, departure + ramp),
            deceleration,
        }
    }

    /// Time at which the foot enters the cabin, s.
    pub(super) fn start(&self) -> f64 {
        self.start
    }

    /// Time at which the foot leaves the cabin, s.
    pub(super) fn end(&self) -> f64 {
        self.standing.start()
    }

    /// Whether the floor under the foot is at rest.
    pub(super) fn is_flat(&self, time: f64) -> bool {
        time <= self.acceleration.start || time >= self.deceleration.end
    }

    /// The foot at `time` (s), with the tremor of its three angles (rad).
    pub(super) fn at(&self, time: f64, tremor: &[Dual; 3]) -> FootState {
        let standing = self.standing.at(time, tremor);
        let rise = (integral(&self.acceleration, time) - integral(&self.deceleration, time))
            * self.velocity;
        FootState {
            position: standing.position + rise.value * Vector3::z(),
            velocity: standing.velocity + rise.rate * Vector3::z(),
            ..standing
        }
    }
}

/// Integral over time of a ramp without skew, s.
fn integral(ramp: &Ramp, time: f64) -> Dual {
    let duration = ramp.end - ramp.start;
    let u = ((time - ramp.start) / duration).clamp(0.0, 1.0);
    let within = duration * u.powi(4) * (2.5 - 3.0 * u + u * u);
    Dual { value: within + (time - ramp.end).max(0.0), rate: ramp.at(time).value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::draw;

    const STILL: [Dual; 3] = [Dual::ZERO; 3];

    fn ride(height: f64) -> LiftRide {
        let from = Foothold { position: Vector3::new(1.0, 2.0, 3.0), yaw: 0.4, by_lift: false };
        let to =
            Foothold { position: from.position + height * Vector3::z(), by_lift: true, ..from };
        LiftRide::new(&Gait::walk(), 5.0, from, to, &mut draw::stream(2, draw::Stream::Gait))
    }

    #[test]
    fn lift_ride_reaches_its_floor_within_speed_and_acceleration_limits() {
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
