//! Solutions that wait until enough of what comes later is known.

use std::collections::VecDeque;

use super::Segment;
use crate::filter::covariance::Covariance;
use crate::navigator::Solution;

/// Holds the filter's solutions back and smooths them.
///
/// Step by step, for a stream: a step closes when the foot leaves the ground again, and what its stance told is carried back over it.  Each solution comes out a fixed number of samples after the
/// filter found it, long enough for a step to close; a step that takes longer is smoothed with what is known when its first sample must leave.
///
/// Or as a whole: no solution comes out before the end.
#[derive(Debug)]
pub(crate) struct Smoother {
    /// Number of samples by which a solution is held back; none for those that wait for the end.
    delay: Option<usize>,
    open: Segment,
    smoothed: VecDeque<Solution>,
    in_stance: bool,
}

impl Smoother {
    /// Step by step, each solution `delay` samples late.
    pub(crate) fn stepwise(delay: usize) -> Self {
        Self {
            delay: Some(delay),
            open: Segment::with_capacity(delay + 1),
            smoothed: VecDeque::with_capacity(delay + 1),
            in_stance: false,
        }
    }

    /// All at the end.
    pub(crate) fn whole() -> Self {
        Self { delay: None, open: Segment::default(), smoothed: VecDeque::new(), in_stance: false }
    }

    /// Number of samples by which a solution is held back.
    pub(crate) fn delay(&self) -> usize {
        self.delay.unwrap_or(0)
    }

    /// Where the filter takes down its steps.
    pub(crate) fn journal(&mut self) -> &mut Segment {
        &mut self.open
    }

    /// Takes the filter's newest solution and returns the one that is due.
    pub(crate) fn push(&mut self, solution: &Solution, covariance: &Covariance) -> Option<Solution> {
        self.open.push(solution, covariance);
        let delay = self.delay?;
        let lifted = self.in_stance && !solution.zero_velocity;
        self.in_stance = solution.zero_velocity;
        let due = self.smoothed.len() + self.open.len() > delay;
        if lifted || (due && self.smoothed.is_empty()) {
            self.close();
        }
        if due { self.smoothed.pop_front() } else { None }
    }

    /// The next of the solutions that are left at the end of the data.
    pub(crate) fn drain(&mut self) -> Option<Solution> {
        self.close();
        self.smoothed.pop_front()
    }

    fn close(&mut self) {
        self.smoothed.extend(self.open.smooth());
    }
}
