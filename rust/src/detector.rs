//! Stance detection: is the foot on the ground and still?
//!
//! A detector looks at a window centred on the sample that it judges, so it answers `latency` samples late.  Where a window is not full it never says
//! "stationary".
//!
//! # References
//! I. Skog, P. Händel, J.-O. Nilsson, J. Rantakokko, "Zero-velocity detection - an algorithm evaluation", IEEE Trans. Biomed. Eng. 57(11), 2010.

use crate::calibration::Calibrator;
use crate::config::{Config, DetectorConfig};
use crate::error::ConfigError;
use crate::navigator::whole_hertz;
use crate::sample::ImuSample;
use crate::watch::{STRETCH, unwatched};

mod acceleration_magnitude;
mod adaptive_shoe;
mod angular_rate_energy;
mod backlog;
mod debounce;
mod delay;
mod extremes;
mod given;
mod graph_theoretic;
mod magnitude_debounced;
mod magnitude_variance;
mod moving_variance;
mod shoe;
mod three_condition;
pub(crate) mod window;
mod windowed;
mod windowed_energies;

use acceleration_magnitude::AccelerationMagnitude;
pub use adaptive_shoe::AdaptiveShoe;
use angular_rate_energy::AngularRateEnergy;
pub use given::Given;
use graph_theoretic::GraphTheoretic;
use magnitude_debounced::MagnitudeDebounced;
use magnitude_variance::MagnitudeVariance;
use moving_variance::MovingVariance;
pub use shoe::Shoe;
use three_condition::ThreeCondition;
use windowed::Windowed;
use windowed_energies::WindowedEnergies;

/// What a detector found about one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The test statistic; NaN where the window was not full, or where no statistic stands behind the decision.
    pub statistic: f64,
    /// The value below which the statistic means stance; NaN where the statistic is.
    pub threshold: f64,
    /// Whether the foot is taken to be at rest on the ground.
    pub stationary: bool,
}

impl Decision {
    /// No answer: a window that is not full.
    pub(crate) const UNKNOWN: Self = Self { statistic: f64::NAN, threshold: f64::NAN, stationary: false };

    /// Stationary up to the threshold; no answer for a statistic that is NaN.
    fn up_to(threshold: f64, statistic: f64) -> Self {
        if statistic.is_nan() {
            return Self::UNKNOWN;
        }
        Self { statistic, threshold, stationary: statistic <= threshold }
    }

    /// Stationary while each of several quantities stays below its threshold: `ratios` are the quantities in units of their thresholds.
    fn all_below<const N: usize>(ratios: [f64; N]) -> Self {
        let statistic = ratios.into_iter().fold(0.0, larger);
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
fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

/// By how much |f| exceeds gravity, m/s².
fn magnitude_excess(sample: &ImuSample, gravity: f64) -> f64 {
    sample.specific_force.norm() - gravity
}

/// A stance detector that takes one calibrated sample after the other.
///
/// Every sample gets exactly one decision, in order: from [`Detector::push`] once `latency` further samples have come in, and for the last `latency` samples of
/// the data from [`Detector::drain`].
pub trait Detector: Send + Sync {
    /// Number of samples by which a decision comes late.
    fn latency(&self) -> usize;

    /// Takes the next sample and returns the decision about the one `latency` samples before it, once there is such a one.
    fn push(&mut self, sample: &ImuSample) -> Option<Decision>;

    /// After the last sample: the next of the decisions still owed.
    fn drain(&mut self) -> Option<Decision>;

    /// Forgets all samples.
    fn reset(&mut self);
}

impl DetectorConfig {
    /// The detector for samples at `rate_hz`, with gravity in m/s².
    #[must_use]
    pub fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector> {
        match self {
            Self::AdaptiveShoe(config) => Box::new(AdaptiveShoe::new(config, rate_hz, gravity)),
            Self::Shoe(config) => Box::new(Shoe::new(config, rate_hz, gravity)),
            Self::MagnitudeVariance(config) => {
                Box::new(Windowed::new(config.window, rate_hz, MagnitudeVariance::new(config, gravity)))
            }
            Self::WindowedEnergies(config) => {
                Box::new(Windowed::new(config.window, rate_hz, WindowedEnergies::new(config, gravity)))
            }
            Self::MagnitudeDebounced(config) => Box::new(MagnitudeDebounced::new(config, rate_hz, gravity)),
            Self::ThreeCondition(config) => {
                Box::new(Windowed::new(config.window, rate_hz, ThreeCondition::new(config, gravity)))
            }
            Self::AngularRateEnergy(config) => {
                Box::new(Windowed::new(config.window, rate_hz, AngularRateEnergy::new(config)))
            }
            Self::MovingVariance(config) => {
                Box::new(Windowed::new(config.window, rate_hz, MovingVariance::new(config)))
            }
            Self::GraphTheoretic(config) => Box::new(GraphTheoretic::new(config, rate_hz)),
            Self::AccelerationMagnitude(config) => {
                Box::new(Windowed::new(config.window, rate_hz, AccelerationMagnitude::new(config, gravity)))
            }
        }
    }
}

/// The decisions of the configured detector about raw samples at about `rate_hz`, one per sample: those that a navigator would follow.
///
/// # Errors
/// [`ConfigError`] for a setting or a rate out of range.
pub fn decide_all(config: &Config, rate_hz: f64, samples: &[ImuSample]) -> Result<Vec<Decision>, ConfigError> {
    decide_all_with(configured(config, rate_hz)?, config, samples, unwatched)
}

/// The configured detector for samples at about `rate_hz`.
pub(crate) fn configured(config: &Config, rate_hz: f64) -> Result<Box<dyn Detector>, ConfigError> {
    config.validate()?;
    Ok(config.detector.build(whole_hertz(rate_hz)?, config.gravity()))
}

/// The same of a detector of one's own; `config.detector` is not used.  `watch` is asked every 10,000 samples and can end the work.
///
/// # Errors
/// That of `watch`, and [`ConfigError`] for a setting out of range.
pub fn decide_all_with<E: From<ConfigError>>(
    mut detector: Box<dyn Detector>,
    config: &Config,
    samples: &[ImuSample],
    mut watch: impl FnMut() -> Result<(), E>,
) -> Result<Vec<Decision>, E> {
    config.validate()?;
    let calibrator = Calibrator::new(&config.calibration);
    let mut decisions = Vec::with_capacity(samples.len());
    for stretch in samples.chunks(STRETCH) {
        watch()?;
        decisions.extend(stretch.iter().filter_map(|raw| match &calibrator {
            None => detector.push(raw),
            Some(calibrator) => detector.push(&calibrator.apply(raw)),
        }));
    }
    decisions.extend(std::iter::from_fn(|| detector.drain()));
    Ok(decisions)
}
