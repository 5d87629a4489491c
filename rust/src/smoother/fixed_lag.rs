//! Fixed-lag smoothing, step by step: for a stream.
//!
//! # References
//! D. S. Colomar, J.-O. Nilsson, P. Händel, "Smoothing for ZUPT-aided INSs", IPIN 2012.

use std::collections::VecDeque;

use crate::filter::covariance::Covariance;
use crate::math::simd::Simd;
use crate::smoother::segment::Segment;
use crate::types::solution::Solution;

/// Outputs each solution a fixed number of samples after the filter found it, smoothed.
///
/// A step closes when the foot leaves the ground again, and the measurements of its stance are
/// propagated back over it.  A step that is longer than the lag is smoothed with the measurements up
/// to the sample at which its first solution is due.
#[derive(Debug)]
pub(crate) struct FixedLag {
    /// Delay of a solution in samples.
    lag: usize,
    /// Solutions that are not yet output.
    solutions: VecDeque<Solution>,
    /// Number of them that are smoothed; the others belong to the open segment.
    smoothed: usize,
    open: Segment,
    in_stance: bool,
}

impl FixedLag {
    /// Each solution is `lag` samples late.
    pub(crate) fn new(lag: usize) -> Self {
        Self {
            lag,
            solutions: VecDeque::with_capacity(lag + 1),
            smoothed: 0,
            open: Segment::with_capacity(lag + 1),
            in_stance: false,
        }
    }

    pub(crate) fn lag(&self) -> usize {
        self.lag
    }

    pub(crate) fn recorder(&mut self) -> &mut Segment {
        &mut self.open
    }

    /// Takes the filter's newest solution and returns the one that is due.
    ///
    /// There is no covariance during the alignment, which later samples do not change.
    #[inline]
    pub(crate) fn push(
        &mut self,
        simd: impl Simd,
        solution: &Solution,
        covariance: Option<&Covariance>,
    ) -> Option<Solution> {
        self.solutions.push_back(*solution);
        match covariance {
            Some(covariance) => self.open.push(covariance),
            None => self.smoothed += 1,
        }
        let lifted = self.in_stance && !solution.zero_velocity;
        self.in_stance = solution.zero_velocity;
        let due = self.solutions.len() > self.lag;
        if lifted || (due && self.smoothed == 0) {
            self.close(simd);
        }
        if due { self.pop() } else { None }
    }

    /// Smooths the open segment.
    pub(crate) fn close(&mut self, simd: impl Simd) {
        let Self { solutions, smoothed, open, .. } = self;
        while open.len() > 0 {
            open.smooth_window(simd, solutions.range_mut(*smoothed..*smoothed + open.len()).rev());
        }
        *smoothed = solutions.len();
    }

    /// The oldest solution.
    pub(crate) fn pop(&mut self) -> Option<Solution> {
        let solution = self.solutions.pop_front()?;
        self.smoothed -= 1;
        Some(solution)
    }
}
