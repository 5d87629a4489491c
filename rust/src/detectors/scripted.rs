//! Decisions that were made elsewhere.

use crate::detectors::detector::{Decision, Detector};
use crate::types::sample::ImuSample;

/// Hands out the decisions that it was given, one for each sample; stationary no more when they run
/// out.
#[derive(Clone, Debug)]
pub struct Scripted {
    stationary: Vec<bool>,
    next: usize,
}

impl Scripted {
    /// A detector that takes `stationary[k]` for the decision about sample `k`.
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
