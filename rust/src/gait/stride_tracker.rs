//! Strides of a stream: found where the filter is, measured between the solutions that come out,
//! which a smoother may hold back and improve.

use std::collections::VecDeque;

use nalgebra::Vector3;

use crate::filter::covariance::Covariance;
use crate::filter::recorder::FilterRecorder;
use crate::gait::segmenter::Segmenter;
use crate::gait::stride::Stride;
use crate::types::nav_state::NavState;
use crate::types::solution::Solution;

/// The strides, from the filter's pass to the user.
#[derive(Clone, Debug)]
pub(crate) struct StrideTracker {
    forward: Vector3<f64>,
    segmenter: Segmenter,
    /// Found, but a solution that they end at has not come out.
    found: VecDeque<Stride>,
    /// Solutions that came out and at which a stride may start or end, with their rows.
    ends: Vec<(usize, NavState)>,
    /// Number of solutions that came out.
    out: usize,
    /// Measured strides that are not yet output.
    ready: Vec<Stride>,
}

impl StrideTracker {
    /// Headings are those of the axis `forward` of the sensor frame.
    pub(crate) fn new(forward: Vector3<f64>) -> Self {
        Self {
            forward,
            segmenter: Segmenter::new(forward),
            found: VecDeque::new(),
            ends: Vec::new(),
            out: 0,
            ready: Vec::new(),
        }
    }

    /// Where the filter takes down its steps.
    pub(crate) fn recorder(&mut self) -> &mut impl FilterRecorder {
        &mut self.segmenter
    }

    /// The start was aligned: the filter's errors are known.
    pub(crate) fn begin(&mut self, covariance: &Covariance) {
        self.segmenter.begin(covariance);
    }

    /// Takes the filter's newest solution; there is no covariance while the start is aligned.
    pub(crate) fn push(&mut self, solution: &Solution, covariance: Option<&Covariance>) {
        let stride =
            self.segmenter.push(&solution.estimate.nav, solution.zero_velocity, covariance);
        self.find(stride);
    }

    /// The data are over.
    pub(crate) fn finish(&mut self) {
        let stride = self.segmenter.finish();
        self.find(stride);
        self.measure();
    }

    /// Takes the next of the solutions that come out.
    pub(crate) fn on_output(&mut self, solution: &Solution) {
        let row = self.out;
        self.out += 1;
        if self.touches(row) {
            self.prune();
            self.ends.push((row, solution.estimate.nav));
        }
        self.measure();
    }

    /// Hands out the strides that were measured since the last time, shuffles on the spot among
    /// them.
    pub(crate) fn take(&mut self) -> Vec<Stride> {
        std::mem::take(&mut self.ready)
    }

    /// Keeps a stride; one without a covariance would end where the start is still being aligned.
    fn find(&mut self, stride: Option<Stride>) {
        self.found.extend(stride.filter(|stride| stride.covariance.is_some()));
    }

    /// Measures the strides both of whose ends came out.
    fn measure(&mut self) {
        while self.found.front().is_some_and(|stride| stride.end_row < self.out) {
            let Some(stride) = self.found.pop_front() else { return };
            if let (Some(start), Some(end)) = (self.end(stride.start_row), self.end(stride.end_row))
            {
                let stride = stride.measured_again(start, end, &self.forward);
                self.ready.push(stride);
            }
        }
    }

    fn end(&self, row: usize) -> Option<&NavState> {
        self.ends.iter().find(|(kept, _)| *kept == row).map(|(_, state)| state)
    }

    /// Whether a stride starts or ends in `row`, or still may; the strides that were found are in
    /// the order of their rows.
    fn touches(&self, row: usize) -> bool {
        let mut near = self.found.iter().take_while(|stride| stride.start_row <= row);
        self.segmenter.touches(row) || near.any(|stride| stride.touches(row))
    }

    /// Forgets the rows at which no stride can start or end any more.
    fn prune(&mut self) {
        let mut ends = std::mem::take(&mut self.ends);
        ends.retain(|(row, _)| self.touches(*row));
        self.ends = ends;
    }
}
