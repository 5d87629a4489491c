//! Strides of a stream: detected at the filter's newest row, computed from the output solutions,
//! which a smoother may delay and change.

use std::collections::VecDeque;

use nalgebra::Vector3;

use crate::filter::covariance::Covariance;
use crate::filter::recorder::FilterRecorder;
use crate::gait::segmenter::Segmenter;
use crate::gait::stride::Stride;
use crate::types::nav_state::NavState;
use crate::types::solution::Solution;

/// Tracks strides from detection in the filter to output.
#[derive(Clone, Debug)]
pub(crate) struct StrideTracker {
    forward: Vector3<f64>,
    segmenter: Segmenter,
    /// Detected strides whose end has not been output.
    pending: VecDeque<Stride>,
    /// Output solutions at which a stride may start or end, with their rows.
    ends: Vec<(usize, NavState)>,
    /// Number of output solutions.
    output_rows: usize,
    /// Completed strides that have not been taken.
    ready: Vec<Stride>,
}

impl StrideTracker {
    /// The heading is that of the axis `forward` of the sensor frame.
    pub(crate) fn new(forward: Vector3<f64>) -> Self {
        Self {
            forward,
            segmenter: Segmenter::new(forward),
            pending: VecDeque::new(),
            ends: Vec::new(),
            output_rows: 0,
            ready: Vec::new(),
        }
    }

    /// Recorder of the filter's steps, for the cloned errors.
    pub(crate) fn recorder(&mut self) -> &mut impl FilterRecorder {
        &mut self.segmenter
    }

    /// The alignment is complete: starts the covariance of the errors.
    pub(crate) fn begin(&mut self, covariance: &Covariance) {
        self.segmenter.begin(covariance);
    }

    /// Processes the filter's newest solution; there is no covariance during alignment.
    pub(crate) fn push(&mut self, solution: &Solution, covariance: Option<&Covariance>) {
        let stride =
            self.segmenter.push(&solution.estimate.nav, solution.zero_velocity, covariance);
        self.add(stride);
    }

    /// Ends the data.
    pub(crate) fn finish(&mut self) {
        let stride = self.segmenter.finish();
        self.add(stride);
        self.complete();
    }

    /// Processes the next output solution.
    pub(crate) fn on_output(&mut self, solution: &Solution) {
        let row = self.output_rows;
        self.output_rows += 1;
        if self.touches(row) {
            self.prune();
            self.ends.push((row, solution.estimate.nav));
        }
        self.complete();
    }

    /// Returns the strides completed since the last call, including shuffles in place.
    pub(crate) fn take(&mut self) -> Vec<Stride> {
        std::mem::take(&mut self.ready)
    }

    /// Adds a detected stride; one without a covariance ends within the alignment and is dropped.
    fn add(&mut self, stride: Option<Stride>) {
        self.pending.extend(stride.filter(|stride| stride.covariance.is_some()));
    }

    /// Completes the strides whose ends have both been output.
    fn complete(&mut self) {
        while self.pending.front().is_some_and(|stride| stride.end_row < self.output_rows) {
            let Some(stride) = self.pending.pop_front() else { return };
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

    /// Whether a stride starts or ends in `row`, or may do so later; the pending strides are
    /// ordered by row.
    fn touches(&self, row: usize) -> bool {
        let mut near = self.pending.iter().take_while(|stride| stride.start_row <= row);
        self.segmenter.touches(row) || near.any(|stride| stride.touches(row))
    }

    /// Removes the rows at which no stride can start or end any more.
    fn prune(&mut self) {
        let mut ends = std::mem::take(&mut self.ends);
        ends.retain(|(row, _)| self.touches(*row));
        self.ends = ends;
    }
}
