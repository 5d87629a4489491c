//! Interface of the stance detectors.

use crate::types::sample::ImuSample;

/// Decision of a detector about one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Test statistic; NaN where the window is not full or the detector has no statistic.
    pub statistic: f64,
    /// Threshold below which the statistic indicates stance; NaN where the statistic is.
    pub threshold: f64,
    /// Whether the foot is detected at rest on the ground.
    pub stationary: bool,
}

impl Decision {
    /// Undecided: the window is not full.
    pub(crate) const UNKNOWN: Self =
        Self { statistic: f64::NAN, threshold: f64::NAN, stationary: false };

    /// Stationary up to the threshold; undecided for a NaN statistic.
    pub(crate) fn threshold_at(threshold: f64, statistic: f64) -> Self {
        if statistic.is_nan() {
            return Self::UNKNOWN;
        }
        Self { statistic, threshold, stationary: statistic <= threshold }
    }

    /// Stationary if every quantity is below its threshold; `ratios` are the quantities in units of
    /// their thresholds.
    pub(crate) fn all_below<const N: usize>(ratios: [f64; N]) -> Self {
        let statistic = ratios.into_iter().fold(0.0, max_nan);
        if statistic.is_nan() {
            return Self::UNKNOWN;
        }
        Self { statistic, threshold: 1.0, stationary: statistic < 1.0 }
    }

    /// A decision without a statistic.
    pub(crate) fn without_statistic(stationary: bool) -> Self {
        Self { stationary, ..Self::UNKNOWN }
    }
}

/// The larger of two values; NaN if either is NaN, unlike `f64::max`.
pub(crate) fn max_nan(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

/// |f| - g, m/s².
pub(crate) fn magnitude_excess(sample: &ImuSample, gravity: f64) -> f64 {
    sample.specific_force.norm() - gravity
}

/// Settings of a stance detector.
pub(crate) trait DetectorSettings {
    /// The detector for samples at `rate_hz`, with gravity in m/s².
    fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector>;
}

/// A stance detector that processes calibrated samples one by one.
///
/// Every sample has exactly one decision, in order.  [`Detector::push`] returns it after `latency`
/// further samples; [`Detector::drain`] returns those of the last `latency` samples of the data.
pub trait Detector: Send + Sync {
    /// Latency of the decisions, samples.
    fn latency(&self) -> usize;

    /// Processes the next sample; returns the decision about the sample `latency` samples earlier,
    /// if it exists.
    fn push(&mut self, sample: &ImuSample) -> Option<Decision>;

    /// Returns the next pending decision, after the last sample.
    fn drain(&mut self) -> Option<Decision>;

    /// Discards all samples.
    fn reset(&mut self);
}
