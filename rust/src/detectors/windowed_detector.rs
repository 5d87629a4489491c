//! Detectors that decide by sums over one window.

use crate::detectors::detector::{Decision, Detector};
use crate::detectors::latency_counter::LatencyCounter;
use crate::detectors::sliding_window::Window;
use crate::types::sample::ImuSample;

/// A test of a window for the sample at its centre.
pub(crate) trait WindowTest<const N: usize>: Send + Sync {
    /// Features of a sample that the window sums.
    fn row(&self, sample: &ImuSample) -> [f64; N];

    /// The decision from the sums over `size` samples and the row at the centre; the sums are NaN
    /// while the window is not full.
    fn decide(&self, size: f64, sums: &[f64; N], centre: &[f64; N]) -> Decision;
}

/// A detector made of a window and a test.
#[derive(Clone, Debug)]
pub(crate) struct WindowedDetector<T, const N: usize> {
    window: Window<N>,
    latency_counter: LatencyCounter,
    test: T,
}

impl<T: WindowTest<N>, const N: usize> WindowedDetector<T, N> {
    pub(crate) fn new(seconds: f64, rate_hz: f64, test: T) -> Self {
        let window = Window::new(seconds, rate_hz);
        Self { latency_counter: LatencyCounter::new(window.half()), window, test }
    }
}

impl<T: WindowTest<N>, const N: usize> Detector for WindowedDetector<T, N> {
    fn latency(&self) -> usize {
        self.latency_counter.latency()
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        let sums = *self.window.push(self.test.row(sample));
        self.latency_counter
            .push()
            .then(|| self.test.decide(self.window.size(), &sums, self.window.centre()))
    }

    fn drain(&mut self) -> Option<Decision> {
        self.latency_counter.drain().map(|_| Decision::UNKNOWN)
    }

    fn reset(&mut self) {
        self.window.reset();
        self.latency_counter.reset();
    }
}
