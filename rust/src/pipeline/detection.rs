//! A stance detector by itself: its decision about each sample of a recording.

use crate::calibration::Calibrator;
use crate::config::Config;
use crate::detectors::detector::{Decision, Detector};
use crate::error::ConfigError;
use crate::progress::{CHUNK, no_progress};
use crate::types::rate::whole_hertz;
use crate::types::sample::ImuSample;

/// The decisions of the configured detector about raw samples at about `rate_hz`, one per sample: as
/// in a navigator.
///
/// # Errors
/// [`ConfigError`] for a setting or a rate out of range.
pub fn decide_all(
    config: &Config,
    rate_hz: f64,
    samples: &[ImuSample],
) -> Result<Vec<Decision>, ConfigError> {
    decide_all_with(configured(config, rate_hz)?, config, samples, no_progress)
}

/// The configured detector for samples at about `rate_hz`.
pub(crate) fn configured(config: &Config, rate_hz: f64) -> Result<Box<dyn Detector>, ConfigError> {
    config.validate()?;
    Ok(config.detector.build(whole_hertz(rate_hz)?, config.gravity()))
}

/// As [`decide_all`], with a detector of the caller's; `config.detector` is not used.  `progress`
/// is called every 10,000 samples, and its error cancels the work.
///
/// # Errors
/// That of `progress`, and [`ConfigError`] for a setting out of range.
pub fn decide_all_with<E: From<ConfigError>>(
    mut detector: Box<dyn Detector>,
    config: &Config,
    samples: &[ImuSample],
    mut progress: impl FnMut() -> Result<(), E>,
) -> Result<Vec<Decision>, E> {
    config.validate()?;
    let calibrator = Calibrator::new(&config.calibration);
    let mut decisions = Vec::with_capacity(samples.len());
    for stretch in samples.chunks(CHUNK) {
        progress()?;
        decisions.extend(stretch.iter().filter_map(|raw| match &calibrator {
            None => detector.push(raw),
            Some(calibrator) => detector.push(&calibrator.apply(raw)),
        }));
    }
    decisions.extend(std::iter::from_fn(|| detector.drain()));
    Ok(decisions)
}
