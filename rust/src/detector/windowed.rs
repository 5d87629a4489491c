//! What detectors share that decide by one full window.

use crate::detector::backlog::Backlog;
use crate::detector::window::Window;
use crate::detector::{Decision, Detector};
use crate::sample::ImuSample;

/// How a window decides about the sample at its centre.
pub(super) trait Rule<const N: usize>: Send + Sync {
    /// What the window sums of each sample.
    fn row(&self, sample: &ImuSample) -> [f64; N];

    /// The decision, from the sums over `size` samples and the row at their centre; the sums are NaN while the window is not full.
    fn decide(&self, size: f64, sums: &[f64; N], centre: &[f64; N]) -> Decision;
}

/// A rule and the window that it looks through.
#[derive(Clone, Debug)]
pub(super) struct Windowed<R, const N: usize> {
    window: Window<N>,
    backlog: Backlog,
    rule: R,
}

impl<R: Rule<N>, const N: usize> Windowed<R, N> {
    pub(super) fn new(seconds: f64, rate_hz: f64, rule: R) -> Self {
        let window = Window::new(seconds, rate_hz);
        Self { backlog: Backlog::new(window.half()), window, rule }
    }
}

impl<R: Rule<N>, const N: usize> Detector for Windowed<R, N> {
    fn latency(&self) -> usize {
        self.backlog.latency()
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        let sums = *self.window.push(self.rule.row(sample));
        self.backlog.push().then(|| self.rule.decide(self.window.size(), &sums, self.window.centre()))
    }

    fn drain(&mut self) -> Option<Decision> {
        self.backlog.drain().map(|_| Decision::UNKNOWN)
    }

    fn reset(&mut self) {
        self.window.reset();
        self.backlog.reset();
    }
}
