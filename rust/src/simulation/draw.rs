//! Random numbers: one stream for each source, so a change of one leaves the others unchanged.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Bound of the draws for the variation of a gait, in standard deviations.
const MAX_DEVIATION: f64 = 2.5;

/// Independent random streams of one seed.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stream {
    Gait = 1,
    Sensor = 2,
    Clock = 3,
    AccelInstability = 4,
    GyroInstability = 5,
}

/// The generator of a stream.
pub(super) fn stream(seed: u64, stream: Stream) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream as u64);
    random
}

/// The generator of another stream with the seed of `random`, from its start.
pub(super) fn sibling(random: &ChaCha8Rng, stream: Stream) -> ChaCha8Rng {
    let mut other = ChaCha8Rng::from_seed(random.get_seed());
    other.set_stream(stream as u64);
    other
}

/// Standard normal.
pub(super) fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// Three independent standard normals.
pub(super) fn normals(random: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(random))
}

/// Standard normal, clamped to 2.5 standard deviations: the variation of a gait is bounded.
pub(super) fn clamped_normal(random: &mut ChaCha8Rng) -> f64 {
    normal(random).clamp(-MAX_DEVIATION, MAX_DEVIATION)
}

/// A factor with mean 1 and the relative standard deviation `variation`.
pub(super) fn factor(random: &mut ChaCha8Rng, variation: f64) -> f64 {
    1.0 + variation * clamped_normal(random)
}
