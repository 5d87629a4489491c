//! The stance detectors that a configuration can choose from.

use serde::{Deserialize, Serialize};

use crate::detectors::detector::{Detector, DetectorSettings};
use crate::error::ConfigError;
use crate::settings::Section;

/// Registers the detectors: name of each in files, and where its settings are.
macro_rules! detectors {
    ($($name:literal => $variant:ident($file:ident::$settings:ident),)+) => {
        $(pub use crate::detectors::$file::$settings;)+

        /// Which stance detector, and its settings.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "kind")]
        #[non_exhaustive]
        pub enum DetectorConfig {
            $(
                #[doc = concat!("The detector `", $name, "`.")]
                #[serde(rename = $name)]
                $variant($settings),
            )+
        }

        impl DetectorConfig {
            /// All detectors with their default settings.
            #[must_use]
            pub fn all() -> Vec<Self> {
                vec![$(Self::$variant($settings::default())),+]
            }

            /// Name of the detector in files.
            #[must_use]
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => $name,)+
                }
            }

            /// The detector for samples at `rate_hz`, with gravity in m/s².
            #[must_use]
            pub fn build(&self, rate_hz: f64, gravity: f64) -> Box<dyn Detector> {
                match self {
                    $(Self::$variant(settings) => settings.build(rate_hz, gravity),)+
                }
            }

            /// Checks every setting.
            ///
            /// # Errors
            /// [`ConfigError`] with the first setting that makes no sense, its value and what is
            /// allowed.
            pub fn validate(&self) -> Result<(), ConfigError> {
                match self {
                    $(Self::$variant(settings) => settings.validate(),)+
                }
            }

            /// The settings of all detectors with their defaults, units and limits.
            #[must_use]
            pub fn schemas() -> Vec<Section> {
                vec![$(Section { kind: Some($name), ..$settings::schema() }),+]
            }
        }
    };
}

detectors! {
    "adaptive-shoe" => AdaptiveShoe(adaptive_shoe::AdaptiveShoeConfig),
    "shoe" => Shoe(shoe::ShoeConfig),
    "magnitude-variance" => MagnitudeVariance(magnitude_variance::MagnitudeVarianceConfig),
    "windowed-energies" => WindowedEnergies(windowed_energies::WindowedEnergiesConfig),
    "magnitude-debounced" => MagnitudeDebounced(magnitude_debounced::MagnitudeDebouncedConfig),
    "three-condition" => ThreeCondition(three_condition::ThreeConditionConfig),
    "angular-rate-energy" => AngularRateEnergy(angular_rate_energy::AngularRateEnergyConfig),
    "moving-variance" => MovingVariance(moving_variance::MovingVarianceConfig),
    "acceleration-magnitude" => AccelerationMagnitude(acceleration_magnitude::AccelerationMagnitudeConfig),
    "graph-theoretic" => GraphTheoretic(graph_theoretic::GraphTheoreticConfig),
}

impl Default for DetectorConfig {
    fn default() -> Self {
        Self::AdaptiveShoe(AdaptiveShoeConfig::default())
    }
}
