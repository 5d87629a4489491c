//! Sampling, mechanization and Earth model of a simulation.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::error::ConfigError;
use crate::ins::strapdown::{MechanizationKind, Strapdown};
use crate::limits;

/// Sample rate, timing jitter, seed, mechanization and Earth model of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SimulationSettings {
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Maximum deviation of a stamp from its nominal time, in sample intervals, uniformly
    /// distributed; the samples are those of the jittered stamps.
    pub jitter: f64,
    /// Seed of the random streams; the same seed gives the same walk.
    pub seed: u64,
    /// Form of the strapdown that reproduces the truth from the samples.
    pub kind: MechanizationKind,
    /// Magnitude of gravity, m/s²; the default is WGS-84 normal gravity at sea level and 45 degrees
    /// of latitude.
    pub gravity: f64,
    /// Rotation rate of the Earth in n, rad/s; zero, the default, neglects it.
    pub earth_rate: Vector3<f64>,
}

impl Default for SimulationSettings {
    fn default() -> Self {
        Self {
            rate_hz: 100.0,
            jitter: 0.0,
            seed: 0,
            kind: MechanizationKind::default(),
            gravity: Config::default().gravity(),
            earth_rate: Vector3::zeros(),
        }
    }
}

impl SimulationSettings {
    /// The strapdown that reproduces the truth from the samples.
    #[must_use]
    pub fn strapdown(&self) -> Strapdown {
        Strapdown {
            kind: self.kind,
            gravity: self.gravity,
            earth_rate: self.earth_rate,
            nominal_interval: 1.0 / self.rate_hz,
        }
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`ConfigError::OutOfRange`] with the first invalid setting.  The limit of the jitter keeps
    /// every interval shorter than a gap.
    pub fn validate(&self) -> Result<(), ConfigError> {
        limits::within("simulation.rate_hz", self.rate_hz, 20.0..=10_000.0, "20 to 10000 Hz")?;
        limits::within("simulation.jitter", self.jitter, 0.0..=0.24, "0 to 0.24 sample intervals")?;
        limits::within("simulation.gravity", self.gravity, 0.0..=30.0, "0 to 30 m/s^2")?;
        limits::within(
            "simulation.earth_rate",
            self.earth_rate.norm(),
            0.0..=0.01,
            "at most 0.01 rad/s",
        )
    }

    /// Stamps from 0 to `duration` (s); the first is not jittered.
    pub(super) fn stamps(&self, duration: f64, random: &mut ChaCha8Rng) -> Vec<f64> {
        let nominal =
            (0_u32..).map(|k| f64::from(k) / self.rate_hz).take_while(|&time| time <= duration);
        let mut stamps: Vec<f64> = nominal.collect();
        for stamp in stamps.iter_mut().skip(1) {
            *stamp += self.jitter * random.random_range(-1.0..=1.0) / self.rate_hz;
        }
        stamps
    }
}
