//! What every stance detector answers, and how it is asked.

use crate::types::sample::ImuSample;

/// What a detector found about one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The test statistic; NaN where the window was not full, or where no statistic stands behind
    /// the decision.
    pub statistic: f64,
    /// The value below which the statistic means stance; NaN where the statistic is.
    pub threshold: f64,
    /// Whether the foot is taken to be at rest on the ground.
    pub stationary: bool,
}

impl Decision {
    /// No answer: a window that is not full.
    pub(crate) const UNKNOWN: Self =
        Self { statistic: f64::NAN, threshold: f64::NAN, stationary: false };

    /// Stationary up to the threshold; no answer for a statistic that is NaN.
    pub(crate) fn threshold_at(threshold: f64, statistic: f64) -> Self {
        if statistic.is_nan() {
            return Self::UNKNOWN;
        }
        Self { statistic, threshold, stationary: statistic <= threshold }
    }

    /// Stationary while each of several quantities stays below its threshold: `ratios` are the
    /// quantities in units of their thresholds.
    pub(crate) fn all_below<const N: usize>(ratios: [f64; N]) -> Self {
        let statistic = ratios.into_iter().fold(0.0, max_nan);
        if statistic.is_nan() {
            return Self::UNKNOWN;
        }
        Self { statistic, threshold: 1.0, stationary: statistic < 1.0 }
    }

    /// A decision that no statistic stands behind.
    pub(crate) fn without_statistic(stationary: bool) -> Self {
        Self { stationary, ..Self::UNKNOWN }
    }
}

/// The larger of two; NaN if either is, where `f64::max` would take the other.
pub(crate) fn max_nan(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

/// By how much |f| exceeds gravity, m/s².
pub(crate) fn magnitude_excess(sample: &ImuSample, gravity: f64) -> f64 {
    sample.specific_force.norm() - gravity
}

/// Settings that a stance detector is made from.
pub(crate) trait DetectorSettings {
    /// The detector for samples at `rate_hz`, with gravity in m/s².
    fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector>;
}

/// A stance detector that takes one calibrated sample after the other.
///
/// Every sample gets exactly one decision, in order: from [`Detector::push`] once `latency` further
/// samples have come in, and for the last `latency` samples of the data from [`Detector::drain`].
pub trait Detector: Send + Sync {
    /// Number of samples by which a decision comes late.
    fn latency(&self) -> usize;

    /// Takes the next sample and returns the decision about the one `latency` samples before it,
    /// once there is such a one.
    fn push(&mut self, sample: &ImuSample) -> Option<Decision>;

    /// After the last sample: the next of the decisions still owed.
    fn drain(&mut self) -> Option<Decision>;

    /// Forgets all samples.
    fn reset(&mut self);
}
