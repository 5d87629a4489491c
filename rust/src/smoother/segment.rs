//! A segment of the data: recorded by the forward pass, smoothed by the backward pass.

use nalgebra::{Matrix3, Vector3};

use crate::filter::covariance::Covariance;
use crate::filter::error_state::{Block, LinearMap};
use crate::filter::observation::{Measurement, Observation};
use crate::filter::process_noise::Noise;
use crate::filter::recorder::FilterRecorder;
use crate::filter::transition::Transition;
use crate::math::simd::{Simd, WithSimd};
use crate::smoother::backward_state::BackwardState;
use crate::types::solution::Solution;

/// Number of solutions from one covariance that is kept to the next; those between are found again
/// from the steps.
pub(crate) const WINDOW: usize = 64;

/// The operations of the filter between the solutions of a segment.
#[derive(Debug, Default)]
pub(crate) struct Segment {
    steps: Vec<Step>,
    /// Number of operations before each solution.
    rows: Vec<usize>,
    /// Covariance of the errors of the first solution of each window.
    checkpoints: Vec<Covariance>,
    window: Window,
    later: BackwardState,
}

/// One operation of the filter.
#[derive(Debug)]
enum Step {
    Transition(Transition, Noise),
    Inflate(Block, f64),
    Couple(Matrix3<f64>),
    Observation(Measurement),
    ResetBlock(Block, Vector3<f64>),
}

/// The forward pass over one window, repeated.
#[derive(Debug, Default)]
struct Window {
    /// Of the errors of each solution.
    covariances: Vec<Covariance>,
    observations: Vec<Observation>,
}

impl FilterRecorder for Segment {
    #[inline]
    fn transition(&mut self, _: impl Simd, transition: &Transition, noise: &Noise) {
        self.steps.push(Step::Transition(*transition, *noise));
    }

    #[inline]
    fn inflate(&mut self, block: Block, variance: f64) {
        self.steps.push(Step::Inflate(block, variance));
    }

    #[inline]
    fn couple(&mut self, _: impl Simd, m: &Matrix3<f64>) {
        self.steps.push(Step::Couple(*m));
    }

    #[inline]
    fn observation(&mut self, _: impl Simd, observation: &Observation) {
        self.steps.push(Step::Observation(observation.measurement()));
    }

    #[inline]
    fn reset_block(&mut self, block: Block, variances: &Vector3<f64>) {
        self.steps.push(Step::ResetBlock(block, *variances));
    }
}

impl Segment {
    /// With memory for the operations of this many solutions.
    pub(crate) fn with_capacity(solutions: usize) -> Self {
        let mut segment = Self::default();
        segment.reserve(solutions);
        segment.window.covariances.reserve(WINDOW);
        segment.window.observations.reserve(2 * WINDOW);
        segment
    }

    /// Makes room for the steps of this many more solutions: each has a transition, and a few have
    /// more than two observations.
    pub(crate) fn reserve(&mut self, solutions: usize) {
        self.steps.reserve(3 * solutions);
        self.rows.reserve(solutions);
        self.checkpoints.reserve(solutions.div_ceil(WINDOW));
    }

    /// Ends the operations of a solution, whose errors have this covariance.
    #[inline]
    pub(crate) fn push(&mut self, covariance: &Covariance) {
        if self.rows.is_empty() {
            self.steps.clear();
        }
        if self.rows.len().is_multiple_of(WINDOW) {
            self.checkpoints.push(covariance.clone());
        }
        self.rows.push(self.steps.len());
    }

    /// Number of solutions that are not smoothed yet.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Smooths the solutions of the last window, which are given from the newest to the oldest.
    ///
    /// The segment keeps its memory.
    pub(crate) fn smooth_window<'a>(
        &mut self,
        simd: impl Simd,
        solutions: impl Iterator<Item = &'a mut Solution>,
    ) {
        let Some(covariance) = self.checkpoints.pop() else { return };
        let first = WINDOW * self.checkpoints.len();
        let (window, rows, steps) = (&mut self.window, &self.rows[first..], &self.steps);
        simd.vectorize(Replay { window, covariance, rows, steps });
        let mut observations = self.window.observations.iter().rev();
        for (solution, covariance) in solutions.zip(self.window.covariances.iter().rev()) {
            let Some(start) = self.rows.pop() else { return };
            for step in self.steps[start..].iter().rev() {
                match step {
                    Step::Transition(transition, _) => self.later.transition(simd, transition),
                    Step::Inflate(..) => {}
                    Step::Couple(m) => self.later.couple(simd, m),
                    Step::Observation(_) => {
                        if let Some(observation) = observations.next() {
                            self.later.observation(simd, observation);
                        }
                    }
                    Step::ResetBlock(block, _) => self.later.reset_block(*block),
                }
            }
            self.steps.truncate(start);
            self.later.smooth(simd, solution, covariance);
        }
        if self.rows.is_empty() {
            self.later = BackwardState::default();
        }
    }
}

/// Repeats the filter's operations from the covariance of the first row of a window on.
struct Replay<'a> {
    window: &'a mut Window,
    covariance: Covariance,
    rows: &'a [usize],
    steps: &'a [Step],
}

impl WithSimd for Replay<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { window, covariance: mut p, rows, steps } = self;
        window.covariances.clear();
        window.observations.clear();
        for (row, &start) in rows.iter().enumerate() {
            let end = if row + 1 < rows.len() { rows[row + 1] } else { steps.len() };
            window.covariances.push(p.clone());
            for step in &steps[start..end] {
                match step {
                    Step::Transition(transition, noise) => p.predict(simd, transition, noise),
                    Step::Inflate(block, variance) => p.add_variance(*block, *variance),
                    Step::Couple(m) => {
                        p.add_transformed(simd, Block::Attitude, Block::AccelBias, m);
                    }
                    Step::Observation(measurement) => {
                        window.observations.push(Observation::replay(measurement));
                        if let Some(observation) = window.observations.last_mut() {
                            p.replay(simd, observation);
                        }
                    }
                    Step::ResetBlock(block, variances) => p.reset_block(*block, variances),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
