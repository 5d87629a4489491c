//! Smoothing: each state estimated from later samples as well.
//!
//! The forward pass keeps, for each sample, its estimate and the steps that led there, and the
//! covariance of one sample in 64.  The backward pass repeats the covariances and gains of such a
//! window from the stored one, and propagates the costate λ and the information Λ of all later
//! samples back over them,
//!
//! ```text
//! over a transition     λ <- Fᵀ λ                        Λ <- Fᵀ Λ F
//! over an observation   λ <- (I - K H)ᵀ λ - Hᵀ S⁻¹ y     Λ <- (I - K H)ᵀ Λ (I - K H) + Hᵀ S⁻¹ H
//! ```
//!
//! and at each sample the smoothed errors are -P λ and their covariance P - P Λ P.  For a linear
//! model this is the solution of Rauch, Tung and Striebel, in the form of Bryson and Frazier, which
//! needs no inverse of a covariance: a covariance of states that are known by definition, as the
//! origin is, has none that is worth computing.
//!
//! A sample that waits takes 168 bytes for its solution, 184 for its transition, 184 for each
//! observation, and 30 for its share of a covariance and the count of its steps: 382 bytes in the
//! swing, 566 in the stance.
//!
//! # References
//! - H. E. Rauch, F. Tung, C. T. Striebel, "Maximum Likelihood Estimates of Linear Dynamic
//!   Systems", AIAA J. 3(8), 1965.
//! - G. J. Bierman, "Fixed Interval Smoothing with Discrete Measurements", Int. J. Control 18(1),
//!   1973: the modified Bryson-Frazier form.
//! - D. S. Colomar, J.-O. Nilsson, P. Händel, "Smoothing for ZUPT-aided INSs", IPIN 2012: smoothing
//!   step by step.

pub(crate) mod backward_state;
pub(crate) mod fixed_interval;
pub(crate) mod fixed_lag;
pub(crate) mod segment;
pub(crate) mod settings;

use crate::filter::covariance::Covariance;
use crate::math::simd::Simd;
use crate::smoother::fixed_interval::FixedInterval;
use crate::smoother::fixed_lag::FixedLag;
use crate::smoother::segment::Segment;
use crate::smoother::settings::{SmootherConfig, SmootherKind};
use crate::types::rate::samples;
use crate::types::solution::Solution;

/// Delays the solutions of the filter and smooths them.
#[derive(Debug)]
pub(crate) enum Smoother {
    FixedLag(FixedLag),
    FixedInterval(FixedInterval),
}

impl Smoother {
    /// None unless the settings ask for one.
    pub(crate) fn new(config: &SmootherConfig, rate: f64) -> Option<Self> {
        match config.kind {
            SmootherKind::None => None,
            SmootherKind::Stepwise => {
                Some(Self::FixedLag(FixedLag::new(samples(config.longest_step * rate))))
            }
            SmootherKind::Rts => Some(Self::FixedInterval(FixedInterval::default())),
        }
    }

    /// Reserves memory for more solutions that wait for the end of the data.
    pub(crate) fn reserve(&mut self, solutions: usize) {
        if let Self::FixedInterval(smoother) = self {
            smoother.reserve(solutions);
        }
    }

    /// Delay of a solution in a stream, in samples.
    pub(crate) fn delay(&self) -> usize {
        match self {
            Self::FixedLag(smoother) => smoother.lag(),
            Self::FixedInterval(_) => 0,
        }
    }

    /// The recorder of the filter's operations.
    pub(crate) fn recorder(&mut self) -> &mut Segment {
        match self {
            Self::FixedLag(smoother) => smoother.recorder(),
            Self::FixedInterval(smoother) => smoother.recorder(),
        }
    }

    /// Takes the filter's newest solution and returns the one that is due.
    #[inline]
    pub(crate) fn push(
        &mut self,
        simd: impl Simd,
        solution: &Solution,
        covariance: Option<&Covariance>,
    ) -> Option<Solution> {
        match self {
            Self::FixedLag(smoother) => smoother.push(simd, solution, covariance),
            Self::FixedInterval(smoother) => {
                smoother.push(solution, covariance);
                None
            }
        }
    }

    /// At the end of the data, smooths about `rows` of the solutions; whether all are smoothed.
    pub(crate) fn smooth_chunk(&mut self, simd: impl Simd, rows: usize) -> bool {
        match self {
            Self::FixedLag(smoother) => {
                smoother.close(simd);
                true
            }
            Self::FixedInterval(smoother) => smoother.smooth_chunk(simd, rows),
        }
    }

    /// The oldest of the solutions that are left at the end of the data.
    pub(crate) fn pop(&mut self) -> Option<Solution> {
        match self {
            Self::FixedLag(smoother) => smoother.pop(),
            Self::FixedInterval(smoother) => smoother.pop(),
        }
    }
}
