//! Fixed-interval smoothing of a whole recording.
//!
//! # References
//! H. E. Rauch, F. Tung, C. T. Striebel, "Maximum Likelihood Estimates of Linear Dynamic Systems",
//! AIAA J. 3(8), 1965.

use std::collections::VecDeque;

use crate::filter::covariance::Covariance;
use crate::math::simd::Simd;
use crate::smoother::segment::{Segment, WINDOW};
use crate::types::solution::Solution;

/// Outputs the solutions at the end of the data, each smoothed with all later samples.
#[derive(Debug, Default)]
pub(crate) struct FixedInterval {
    /// Solutions that are not yet output.
    solutions: VecDeque<Solution>,
    /// Number of solutions before those of the segment: of the alignment.
    unsmoothed: usize,
    segment: Segment,
}

impl FixedInterval {
    /// Reserves memory for more solutions.
    pub(crate) fn reserve(&mut self, solutions: usize) {
        self.solutions.reserve(solutions);
        self.segment.reserve(solutions);
    }

    pub(crate) fn recorder(&mut self) -> &mut Segment {
        &mut self.segment
    }

    /// Takes the filter's newest solution; there is no covariance during the alignment.
    #[inline]
    pub(crate) fn push(&mut self, solution: &Solution, covariance: Option<&Covariance>) {
        self.solutions.push_back(*solution);
        match covariance {
            Some(covariance) => self.segment.push(covariance),
            None => self.unsmoothed += 1,
        }
    }

    /// Smooths about `rows` of the solutions, the newest first; whether all are smoothed.
    pub(crate) fn smooth_chunk(&mut self, simd: impl Simd, rows: usize) -> bool {
        let Self { solutions, unsmoothed, segment } = self;
        for _ in 0..rows.div_ceil(WINDOW) {
            if segment.len() == 0 {
                break;
            }
            let rows = *unsmoothed..*unsmoothed + segment.len();
            segment.smooth_window(simd, solutions.range_mut(rows).rev());
        }
        segment.len() == 0
    }

    /// The oldest solution.
    pub(crate) fn pop(&mut self) -> Option<Solution> {
        self.solutions.pop_front()
    }
}
