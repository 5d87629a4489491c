//! The operations on the covariance, for the benchmarks alone.

use nalgebra::{Matrix3, Vector3};

use crate::filter::covariance::Covariance;
use crate::filter::error_state::Block;
use crate::filter::process_noise::Noise;
use crate::filter::transition::Transition;
use crate::ins::strapdown::StrapdownStep;
use crate::math::simd::{InstructionSet, Simd, WithSimd, detect};

/// A covariance after a step, the transition of the step and its noise.
#[derive(Clone, Debug)]
pub struct Step {
    covariance: Covariance,
    transition: Transition,
    noise: Noise,
}

impl Step {
    /// The standard deviations belong to the blocks in their order, the densities to velocity,
    /// attitude, gyroscope bias and accelerometer bias, as variances per second.
    #[must_use]
    pub fn new(step: &StrapdownStep, stds: [f64; 5], densities: [f64; 4]) -> Self {
        let mut covariance = Covariance::zero();
        for (block, std) in Block::ALL.into_iter().zip(stds) {
            covariance.add_variance(block, std * std);
        }
        let [velocity, attitude, gyro_bias, accel_bias] =
            densities.map(|density| density * step.dt);
        let noise = Noise { velocity, attitude, gyro_bias, accel_bias, ..Noise::default() };
        let transition = Transition::new(step, &Vector3::zeros());
        Self { covariance, transition, noise }
    }

    /// The covariance.
    #[must_use]
    pub fn covariance(&self) -> &Covariance {
        &self.covariance
    }

    /// Propagates the covariance over the step.
    pub fn predict(&mut self) {
        vectorize(Predict(self));
    }

    /// Observes the velocity with a `variance` (m²/s²) on each axis.
    pub fn observe_velocity(&mut self, innovation: &Vector3<f64>, variance: f64) {
        vectorize(Observe { step: self, innovation, variance });
    }
}

fn vectorize<W: WithSimd>(operation: W) -> W::Output {
    match detect() {
        InstructionSet::Baseline(simd) => simd.vectorize(operation),
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx2(simd) => simd.vectorize(operation),
    }
}

struct Predict<'a>(&'a mut Step);

impl WithSimd for Predict<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Step { covariance, transition, noise } = self.0;
        covariance.predict(simd, transition, noise);
    }
}

struct Observe<'a> {
    step: &'a mut Step,
    innovation: &'a Vector3<f64>,
    variance: f64,
}

impl WithSimd for Observe<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (r, mut used) = (Matrix3::from_diagonal_element(self.variance), None);
        let covariance = &mut self.step.covariance;
        covariance.observe(simd, Block::Velocity, self.innovation, &r, f64::INFINITY, &mut used);
    }
}
