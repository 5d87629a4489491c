//! Magnitude of the specific force, without isolated detections and gaps.
//!
//! # References
//! Abdulrahim, Moore, Hide, Hill, "Understanding the Performance of Zero Velocity Updates in
//! MEMS-based Pedestrian Navigation": the magnitude of the total acceleration against a threshold;
//! detections are believed only with others shortly before and after them.

use std::collections::VecDeque;
use std::iter;

use crate::detectors::debounce::Debounce;
use crate::detectors::detector::{Decision, Detector, DetectorSettings, magnitude_excess};
use crate::limits::Limits;
use crate::settings::settings;
use crate::types::rate::samples;
use crate::types::sample::ImuSample;

settings! {
    /// Magnitude of the specific force, debounced (Abdulrahim et al.).
    ///
    /// The statistic and its threshold are those of each sample alone; the decision also depends on
    /// the samples around it.
    ///
    /// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's
    /// IMU; the paper prints none.
    pub struct MagnitudeDebouncedConfig: "detector" {
        /// Deviation of the magnitude from gravity from which a sample moves.
        magnitude_gate: f64 = 0.3, "m/s²", Limits::Positive;
        /// Longest gap between two detections that is filled.
        longest_gap: f64 = 0.02, "s", Limits::Between(0.0, 10.0);
        /// Shortest stance, gaps filled, that is kept.  The latency is this and `longest_gap`, less
        /// one sample.
        shortest_stance: f64 = 0.15, "s", Limits::Between(0.0, 10.0);
    }
}

impl DetectorSettings for MagnitudeDebouncedConfig {
    fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector> {
        Box::new(MagnitudeDebounced::new(self, rate_hz, gravity))
    }
}

/// Stationary where |f| stays near gravity for long enough, short excursions apart.
///
/// The statistic is ||f| - g| of the sample alone; what is decided of it depends on its neighbours.
#[derive(Clone, Debug)]
pub(crate) struct MagnitudeDebounced {
    debounce: Debounce,
    /// Statistics of the samples that are not decided on yet.
    waiting: VecDeque<f64>,
    gravity: f64,
    gate: f64,
}

impl MagnitudeDebounced {
    pub(crate) fn new(config: &MagnitudeDebouncedConfig, rate_hz: f64, gravity: f64) -> Self {
        let debounce = Debounce::new(
            samples(config.longest_gap * rate_hz),
            samples(config.shortest_stance * rate_hz),
        );
        let waiting = VecDeque::with_capacity(debounce.latency() + 1);
        Self { debounce, waiting, gravity, gate: config.magnitude_gate }
    }

    fn decide(&mut self, stationary: bool) -> Option<Decision> {
        let statistic = self.waiting.pop_front()?;
        Some(Decision { statistic, threshold: self.gate, stationary })
    }
}

impl Detector for MagnitudeDebounced {
    fn latency(&self) -> usize {
        self.debounce.latency()
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        let statistic = magnitude_excess(sample, self.gravity).abs();
        self.waiting.push_back(statistic);
        let stationary = self.debounce.push(statistic < self.gate)?;
        self.decide(stationary)
    }

    fn drain(&mut self) -> Option<Decision> {
        self.waiting.front()?;
        let stationary = iter::repeat_with(|| self.debounce.push(false)).flatten().next()?;
        self.decide(stationary)
    }

    fn reset(&mut self) {
        self.debounce.reset();
        self.waiting.clear();
    }
}
