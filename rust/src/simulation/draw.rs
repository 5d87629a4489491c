//! Random numbers: one stream for each cause, so that a change of one leaves the others as they
//! were.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Largest draw that the variation of a gait uses, in standard deviations.
const WIDEST: f64 = 2.5;

/// What random numbers are drawn for; each has its stream.
#[derive(Clone, Copy, Debug)]
pub(super) enum Cause {
    Gait = 1,
    Sensor = 2,
    Clock = 3,
    AccelInstability = 4,
    GyroInstability = 5,
}

/// The generator of one cause.
pub(super) fn stream(seed: u64, cause: Cause) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(cause as u64);
    random
}

/// The generator of another cause with the seed of `random`, from its start.
pub(super) fn beside(random: &ChaCha8Rng, cause: Cause) -> ChaCha8Rng {
    let mut other = ChaCha8Rng::from_seed(random.get_seed());
    other.set_stream(cause as u64);
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

/// Standard normal held within 2.5 standard deviations: a foot has no tails.
pub(super) fn clamped_normal(random: &mut ChaCha8Rng) -> f64 {
    normal(random).clamp(-WIDEST, WIDEST)
}

/// A factor about 1 with the relative standard deviation `variation`.
pub(super) fn factor(random: &mut ChaCha8Rng, variation: f64) -> f64 {
    1.0 + variation * clamped_normal(random)
}
