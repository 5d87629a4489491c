//! What detectors share that decide by one full window.

use crate::detector::window::{Centred, Window};
use crate::detector::{Decision, Detector};
use crate::sample::ImuSample;

/// How a full window decides about the sample at its centre.
pub(super) trait Rule<const N: usize>: Send + Sync {
    /// What the window sums of each sample.
    fn row(&self, sample: &ImuSample) -> [f64; N];

    /// The decision, from the sums over `size` samples and the row at their centre.
    fn decide(&self, size: f64, sums: &[f64; N], centre: &[f64; N]) -> Decision;
}

/// A rule and the window that it looks through.
#[derive(Clone, Debug)]
pub(super) struct Windowed<R, const N: usize> {
    window: Window<N>,
    rule: R,
}

impl<R: Rule<N>, const N: usize> Windowed<R, N> {
    pub(super) fn new(seconds: f64, rate_hz: f64, rule: R) -> Self {
        Self { window: Window::new(seconds, rate_hz), rule }
    }
}

impl<R: Rule<N>, const N: usize> Detector for Windowed<R, N> {
    fn latency(&self) -> usize {
        self.window.half()
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        let size = self.window.size();
        match self.window.push(self.rule.row(sample))? {
            Centred::Filling => Some(Decision::UNKNOWN),
            Centred::Full { sums, centre } => Some(self.rule.decide(size, sums, centre)),
        }
    }

    fn drain(&mut self) -> Option<Decision> {
        self.window.drain().then_some(Decision::UNKNOWN)
    }

    fn reset(&mut self) {
        self.window.reset();
    }
}
