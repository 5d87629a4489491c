//! The motion of the sensor through a whole walk.

use rand_chacha::ChaCha8Rng;

use super::footing;
use super::gait::Gait;
use super::route::Route;
use super::stride::{FootState, Stride};
use super::tremor::Tremor;

/// Where the foot is at any time of a walk.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    strides: Vec<Stride>,
    tremor: [Tremor; 3],
    duration: f64,
}

impl Motion {
    /// The motion along a valid route with a valid gait.
    pub(super) fn plan(route: &Route, gait: &Gait, random: &mut ChaCha8Rng) -> Self {
        let footholds = footing::plan(route, gait, random);
        let mut end = gait.rest_before;
        let mut strides = Vec::with_capacity(footholds.len());
        for pair in footholds.windows(2) {
            let stride = Stride::new(gait, end, pair[0], pair[1], random);
            end = stride.end();
            strides.push(stride);
        }
        let tremor = std::array::from_fn(|_| Tremor::draw(gait.tremor, random));
        Self { strides, tremor, duration: end + gait.rest_after }
    }

    /// From the first rest to the last, s.
    pub(super) fn duration(&self) -> f64 {
        self.duration
    }

    /// The foot at `time` (s); before the first stride and after the last it rests.
    pub(super) fn at(&self, time: f64) -> FootState {
        self.stride(time).at(time, &self.tremor.map(|tremor| tremor.at(time)))
    }

    /// Whether the foot stands flat on the ground.
    pub(super) fn is_flat(&self, time: f64) -> bool {
        self.stride(time).is_flat(time)
    }

    fn stride(&self, time: f64) -> &Stride {
        let begun = self.strides.partition_point(|stride| stride.start() <= time);
        &self.strides[begun.saturating_sub(1)]
    }
}
