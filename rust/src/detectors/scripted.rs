//! A detector with given decisions.

use crate::detectors::detector::{Decision, Detector};
use crate::types::sample::ImuSample;

/// Returns the given decisions, one for each sample; samples beyond the last are not stationary.
#[derive(Clone, Debug)]
pub struct Scripted {
    stationary: Vec<bool>,
    next: usize,
}

impl Scripted {
    /// A detector with the decision `stationary[k]` about sample `k`.
    #[must_use]
    pub fn new(stationary: Vec<bool>) -> Self {
        Self { stationary, next: 0 }
    }
}

impl Detector for Scripted {
    fn latency(&self) -> usize {
        0
    }

    fn push(&mut self, _: &ImuSample) -> Option<Decision> {
        let stationary = self.stationary.get(self.next).copied().unwrap_or(false);
        self.next += 1;
        Some(Decision::without_statistic(stationary))
    }

    fn drain(&mut self) -> Option<Decision> {
        None
    }

    fn reset(&mut self) {
        self.next = 0;
    }
}
