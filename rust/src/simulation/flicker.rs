//! Flicker (1/f) noise: the bias instability of data sheets.
//!
//! The sum of first-order Gauss-Markov processes of equal variance s², whose correlation times are
//! a factor r apart, has the spectrum s² / (f ln r) between the shortest and the longest
//! correlation time.  A bias instability B has the one-sided spectrum B² / (π f), so s² = B² ln r /
//! π.  With correlation times in decades from 0.03 s, the Allan deviation is within 1.5 % of sqrt(2
//! ln 2 / π) B = 0.664 B at averaging times from 1 s to 10,000 s, and within 6 % from 0.1 s.
//!
//! # References
//! - IEEE Std 952-1997, annex C.1.1: bias instability.
//! - M. S. Keshner, "1/f noise", Proceedings of the IEEE 70(3), 1982: a sum of relaxation
//!   processes.

use std::f64::consts::{LN_10, PI};

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;

use crate::simulation::draw;

/// Correlation times of the processes, s.
const CORRELATION_TIMES: [f64; 8] = [0.03, 0.3, 3.0, 30.0, 300.0, 3e3, 3e4, 3e5];

/// Flicker noise of three axes.
#[derive(Clone, Debug)]
pub(super) struct Flicker {
    /// Standard deviation of each process, in the unit of the noise.
    std: f64,
    states: [Vector3<f64>; CORRELATION_TIMES.len()],
    random: ChaCha8Rng,
}

impl Flicker {
    /// Stationary noise of the bias instability `instability`.
    pub(super) fn draw(instability: f64, mut random: ChaCha8Rng) -> Self {
        let std = instability * (LN_10 / PI).sqrt();
        Self { std, states: std::array::from_fn(|_| std * draw::normals(&mut random)), random }
    }

    /// Current value of the noise.
    pub(super) fn value(&self) -> Vector3<f64> {
        self.states.iter().sum()
    }

    /// Propagates the noise by `dt` (s).
    pub(super) fn advance(&mut self, dt: f64) {
        if self.std == 0.0 {
            return;
        }
        for (state, time) in self.states.iter_mut().zip(CORRELATION_TIMES) {
            let phi = (-dt / time).exp();
            *state = phi * *state
                + self.std * (1.0 - phi.powi(2)).sqrt() * draw::normals(&mut self.random);
        }
    }
}
