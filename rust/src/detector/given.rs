//! Decisions that were made elsewhere.

use crate::detector::{Decision, Detector};
use crate::sample::ImuSample;

/// Hands out the decisions that it was given, one for each sample; stationary no more when they run out.
#[derive(Clone, Debug)]
pub struct Given {
    stationary: Vec<bool>,
    next: usize,
}

impl Given {
    /// A detector that takes `stationary[k]` for the decision about sample `k`.
    #[must_use]
    pub fn new(stationary: Vec<bool>) -> Self {
        Self { stationary, next: 0 }
    }
}

impl Detector for Given {
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
