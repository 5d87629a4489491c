//! Solutions that wait until enough of what comes later is known.

use std::collections::VecDeque;

use crate::filter::covariance::Covariance;
use crate::smoother::segment::{Segment, WINDOW};
use crate::types::solution::Solution;

/// Holds the filter's solutions back and smooths them.
///
/// Step by step, for a stream: a step closes when the foot leaves the ground again, and what its
/// stance told is carried back over it.  Each solution comes out a fixed number of samples after
/// the filter found it, long enough for a step to close; a step that takes longer is smoothed with
/// what is known when its first sample must leave.
///
/// Or as a fixed_interval: no solution comes out before the end.
#[derive(Debug)]
pub(crate) struct Smoother {
    /// Number of samples by which a solution is held back; none for those that wait for the end.
    delay: Option<usize>,
    /// All that have not come out.
    solutions: VecDeque<Solution>,
    /// How many of them are as they come out; the rest is the open segment's.
    smoothed: usize,
    open: Segment,
    in_stance: bool,
}

impl Smoother {
    /// Step by step, each solution `delay` samples late.
    pub(crate) fn stepwise(delay: usize) -> Self {
        Self {
            delay: Some(delay),
            solutions: VecDeque::with_capacity(delay + 1),
            smoothed: 0,
            open: Segment::with_capacity(delay + 1),
            in_stance: false,
        }
    }

    /// All at the end.
    pub(crate) fn fixed_interval() -> Self {
        Self {
            delay: None,
            solutions: VecDeque::new(),
            smoothed: 0,
            open: Segment::default(),
            in_stance: false,
        }
    }

    /// Makes room for this many more solutions if they have to wait for the end.
    pub(crate) fn reserve(&mut self, solutions: usize) {
        if self.waits_for_end() {
            self.solutions.reserve(solutions);
            self.open.reserve(solutions);
        }
    }

    /// Number of samples by which a solution is held back.
    pub(crate) fn delay(&self) -> usize {
        self.delay.unwrap_or(0)
    }

    /// Whether no solution comes out before the end.
    pub(crate) fn waits_for_end(&self) -> bool {
        self.delay.is_none()
    }

    /// Where the filter takes down its steps.
    pub(crate) fn recorder(&mut self) -> &mut Segment {
        &mut self.open
    }

    /// Takes the filter's newest solution and returns the one that is due.
    ///
    /// There is no covariance while the start is aligned, and nothing that comes later is told of
    /// it.
    #[inline]
    pub(crate) fn push(
        &mut self,
        solution: &Solution,
        covariance: Option<&Covariance>,
    ) -> Option<Solution> {
        self.solutions.push_back(*solution);
        match covariance {
            Some(covariance) => self.open.push(covariance),
            None => self.smoothed += 1,
        }
        let delay = self.delay?;
        let lifted = self.in_stance && !solution.zero_velocity;
        self.in_stance = solution.zero_velocity;
        let due = self.solutions.len() > delay;
        if lifted || (due && self.smoothed == 0) {
            self.close();
        }
        if due { self.pop() } else { None }
    }

    /// Goes back over some of the solutions of the open segment, about as many as `rows`; answers
    /// whether it is all done.
    pub(crate) fn smooth_chunk(&mut self, rows: usize) -> bool {
        for _ in 0..rows.div_ceil(WINDOW) {
            self.open.smooth_chunk(
                self.solutions.range_mut(self.smoothed..self.smoothed + self.open.len()).rev(),
            );
        }
        let done = self.open.len() == 0;
        if done {
            self.smoothed = self.solutions.len();
        }
        done
    }

    /// The next of the solutions that are left at the end of the data.
    pub(crate) fn drain(&mut self) -> Option<Solution> {
        if self.open.len() > 0 {
            self.close();
        }
        self.pop()
    }

    fn close(&mut self) {
        self.smooth_chunk(self.open.len());
    }

    fn pop(&mut self) -> Option<Solution> {
        let solution = self.solutions.pop_front()?;
        self.smoothed -= 1;
        Some(solution)
    }
}
