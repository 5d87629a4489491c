//! The motion of the sensor through a whole walk.

use rand_chacha::ChaCha8Rng;

use crate::simulation::footing;
use crate::simulation::footing::Foothold;
use crate::simulation::gait::Gait;
use crate::simulation::lift::LiftRide;
use crate::simulation::route::Route;
use crate::simulation::stride::{FootState, Stride};
use crate::simulation::tremor::Tremor;

/// Where the foot is at any time of a walk.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    movements: Vec<Movement>,
    tremor: [Tremor; 3],
    duration: f64,
}

/// What takes the foot from one foothold to the next.
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

    /// From the first rest to the last, s.
    pub(super) fn duration(&self) -> f64 {
        self.duration
    }

    /// The foot at `time` (s); before the first movement and after the last it rests.
    pub(super) fn at(&self, time: f64) -> FootState {
        let tremor = self.tremor.map(|tremor| tremor.at(time));
        match self.movement(time) {
            Movement::Stride(stride) => stride.at(time, &tremor),
            Movement::LiftRide(ride) => ride.at(time, &tremor),
        }
    }

    /// Whether the foot stands flat on ground that is at rest.
    pub(super) fn is_flat(&self, time: f64) -> bool {
        match self.movement(time) {
            Movement::Stride(stride) => stride.is_flat(time),
            Movement::LiftRide(ride) => ride.is_flat(time),
        }
    }

    fn movement(&self, time: f64) -> &Movement {
        let begun = self.movements.partition_point(|movement| movement.start() <= time);
        &self.movements[begun.saturating_sub(1)]
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
