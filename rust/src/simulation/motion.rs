//! The motion of the foot over a whole walk.

use rand_chacha::ChaCha8Rng;

use crate::simulation::footing;
use crate::simulation::footing::Foothold;
use crate::simulation::gait::Gait;
use crate::simulation::lift::LiftRide;
use crate::simulation::route::Route;
use crate::simulation::stride::{FootState, Stride};
use crate::simulation::tremor::Tremor;

/// The motion of the foot as a function of time.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    movements: Vec<Movement>,
    tremor: [Tremor; 3],
    duration: f64,
}

/// A movement of the foot from one foothold to the next.
#[derive(Clone, Debug)]
enum Movement {
    Stride(Stride),
    LiftRide(LiftRide),
}

impl Motion {
    /// The motion along a valid route with a valid gait.
    pub(super) fn plan(route: &Route, gait: &Gait, random: &mut ChaCha8Rng) -> Self {
        let footholds = footing::plan(route, gait, random);
        let mut end = gait.rest_before;
        let mut movements = Vec::with_capacity(footholds.len());
        for pair in footholds.windows(2) {
            let movement = Movement::new(gait, end, pair[0], pair[1], random);
            end = movement.end();
            movements.push(movement);
        }
        let tremor = std::array::from_fn(|_| Tremor::draw(gait.tremor, random));
        Self { movements, tremor, duration: end + gait.rest_after }
    }

    /// Duration including the rests at both ends, s.
    pub(super) fn duration(&self) -> f64 {
        self.duration
    }

    /// The foot at `time` (s); it is at rest before the first movement and after the last.
    pub(super) fn at(&self, time: f64) -> FootState {
        let tremor = self.tremor.map(|tremor| tremor.at(time));
        match self.movement(time) {
            Movement::Stride(stride) => stride.at(time, &tremor),
            Movement::LiftRide(ride) => ride.at(time, &tremor),
        }
    }

    /// Whether the foot is flat on static ground.
    pub(super) fn is_flat(&self, time: f64) -> bool {
        match self.movement(time) {
            Movement::Stride(stride) => stride.is_flat(time),
            Movement::LiftRide(ride) => ride.is_flat(time),
        }
    }

    fn movement(&self, time: f64) -> &Movement {
        let started = self.movements.partition_point(|movement| movement.start() <= time);
        &self.movements[started.saturating_sub(1)]
    }
}

impl Movement {
    fn new(gait: &Gait, start: f64, from: Foothold, to: Foothold, random: &mut ChaCha8Rng) -> Self {
        if to.by_lift {
            Self::LiftRide(LiftRide::new(gait, start, from, to, random))
        } else {
            Self::Stride(Stride::new(gait, start, from, to, random))
        }
    }

    fn start(&self) -> f64 {
        match self {
            Self::Stride(stride) => stride.start(),
            Self::LiftRide(ride) => ride.start(),
        }
    }

    fn end(&self) -> f64 {
        match self {
            Self::Stride(stride) => stride.end(),
            Self::LiftRide(ride) => ride.end(),
        }
    }
}
