//! The stance detectors that a configuration can choose from.

use crate::config::DetectorConfig;
use crate::detectors::acceleration_magnitude::AccelerationMagnitude;
use crate::detectors::adaptive_shoe::AdaptiveShoe;
use crate::detectors::angular_rate_energy::AngularRateEnergy;
use crate::detectors::detector::Detector;
use crate::detectors::graph_theoretic::GraphTheoretic;
use crate::detectors::magnitude_debounced::MagnitudeDebounced;
use crate::detectors::magnitude_variance::MagnitudeVariance;
use crate::detectors::moving_variance::MovingVariance;
use crate::detectors::shoe::Shoe;
use crate::detectors::three_condition::ThreeCondition;
use crate::detectors::window_test::WindowedDetector;
use crate::detectors::windowed_energies::WindowedEnergies;

impl DetectorConfig {
    /// The detector for samples at `rate_hz`, with gravity in m/s².
    #[must_use]
    pub fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector> {
        match self {
            Self::AdaptiveShoe(config) => Box::new(AdaptiveShoe::new(config, rate_hz, gravity)),
            Self::Shoe(config) => Box::new(Shoe::new(config, rate_hz, gravity)),
            Self::MagnitudeVariance(config) => Box::new(WindowedDetector::new(
                config.window,
                rate_hz,
                MagnitudeVariance::new(config, gravity),
            )),
            Self::WindowedEnergies(config) => Box::new(WindowedDetector::new(
                config.window,
                rate_hz,
                WindowedEnergies::new(config, gravity),
            )),
            Self::MagnitudeDebounced(config) => {
                Box::new(MagnitudeDebounced::new(config, rate_hz, gravity))
            }
            Self::ThreeCondition(config) => Box::new(WindowedDetector::new(
                config.window,
                rate_hz,
                ThreeCondition::new(config, gravity),
            )),
            Self::AngularRateEnergy(config) => Box::new(WindowedDetector::new(
                config.window,
                rate_hz,
                AngularRateEnergy::new(config),
            )),
            Self::MovingVariance(config) => {
                Box::new(WindowedDetector::new(config.window, rate_hz, MovingVariance::new(config)))
            }
            Self::GraphTheoretic(config) => Box::new(GraphTheoretic::new(config, rate_hz)),
            Self::AccelerationMagnitude(config) => Box::new(WindowedDetector::new(
                config.window,
                rate_hz,
                AccelerationMagnitude::new(config, gravity),
            )),
        }
    }
}
