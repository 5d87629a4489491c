//! The smoother that the settings ask for.

use crate::config::{SmootherConfig, SmootherKind};
use crate::filter::covariance::Covariance;
use crate::math::simd::Simd;
use crate::smoother::fixed_interval::FixedInterval;
use crate::smoother::fixed_lag::FixedLag;
use crate::smoother::segment::Segment;
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
