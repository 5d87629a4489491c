//! Settings of the stance detectors.

use serde::{Deserialize, Serialize};

use crate::error::ConfigError;
use crate::limits::{at_least_zero, positive, within};

/// Which stance detector, and its settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum DetectorConfig {
    /// SHOE with a threshold that follows the stride: no tuning.
    AdaptiveShoe(AdaptiveShoeConfig),
    /// SHOE with a fixed threshold.
    Shoe(ShoeConfig),
    /// Magnitude and sliding variance of the specific force.
    MagnitudeVariance(MagnitudeVarianceConfig),
    /// Energies of specific force and angular rate.
    WindowedEnergies(WindowedEnergiesConfig),
    /// Magnitude of the specific force, without isolated detections and gaps.
    MagnitudeDebounced(MagnitudeDebouncedConfig),
    /// Magnitude, variance and rate, together or any of them.
    ThreeCondition(ThreeConditionConfig),
    /// Energy of the angular rate (ARE).
    AngularRateEnergy(AngularRateEnergyConfig),
    /// Moving variance of the specific force (MV).
    MovingVariance(MovingVarianceConfig),
    /// Magnitude of the specific force (MAG).
    AccelerationMagnitude(AccelerationMagnitudeConfig),
    /// Contrast between the parts of a window (MBGTD).
    GraphTheoretic(GraphTheoreticConfig),
}

impl Default for DetectorConfig {
    fn default() -> Self {
        Self::AdaptiveShoe(AdaptiveShoeConfig::default())
    }
}

/// SHOE whose threshold is a multiple of the statistic's minimum around the sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AdaptiveShoeConfig {
    /// Length of the statistic's window, s.
    pub window: f64,
    /// Standard deviation that the specific force is weighed with, m/s².
    pub accel_std: f64,
    /// Standard deviation that the angular rate is weighed with, rad/s.
    pub gyro_std: f64,
    /// How far back the minimum is sought, s.
    pub look_behind: f64,
    /// How far ahead the minimum is sought, s; the detector's latency is this and half a window.
    pub look_ahead: f64,
    /// Multiple of the minimum up to which a sample is stationary.
    pub min_factor: f64,
    /// Statistic below which a sample is stationary however low the minimum is: at rest the minimum
    /// is mere noise.
    pub noise_floor: f64,
    /// Statistic above which a sample is never stationary: a foot that is shaken all the time has
    /// minima too.
    pub upper_bound: f64,
    /// Part of the maximum around a sample up to which it is stationary: a slow swing has minima
    /// too.
    pub max_fraction: f64,
}

impl Default for AdaptiveShoeConfig {
    fn default() -> Self {
        Self {
            window: 0.05,
            accel_std: 0.02,
            gyro_std: 8.7e-3,
            look_behind: 0.6,
            look_ahead: 0.6,
            min_factor: 1.5,
            noise_floor: 500.0,
            upper_bound: 2.0e5,
            max_fraction: 0.015,
        }
    }
}

impl AdaptiveShoeConfig {
    /// For a stream that must not be late by more than 0.3 s.
    ///
    /// A quarter of a second ahead there may be no more than the end of a swing, so that the swing
    /// which a stance is held against is often only seen behind it; it must be stiller than that by
    /// a little more.
    #[must_use]
    pub fn live() -> Self {
        Self { look_ahead: 0.25, max_fraction: 0.01, ..Self::default() }
    }
}

/// SHOE with a fixed threshold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShoeConfig {
    /// Length of the window, s.
    pub window: f64,
    /// Standard deviation that the specific force is weighed with, m/s².
    pub accel_std: f64,
    /// Standard deviation that the angular rate is weighed with, rad/s.
    pub gyro_std: f64,
    /// Statistic below which a sample is stationary.
    pub threshold: f64,
}

impl Default for ShoeConfig {
    fn default() -> Self {
        Self { window: 0.025, accel_std: 0.02, gyro_std: 8.7e-3, threshold: 3.0e3 }
    }
}

/// Magnitude and sliding variance of the specific force.
///
/// The gates are the paper's 0.06, which it prints without a unit; in m/s² and m²/s⁴ they work on
/// real recordings of an MPU6050, in g they do not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MagnitudeVarianceConfig {
    /// Length of the variance's window, s: 11 samples at 200 Hz in the paper.
    pub window: f64,
    /// Deviation of the magnitude from gravity (`Gate_B`) from which a sample moves, m/s².
    pub magnitude_gate: f64,
    /// Variance of the magnitude (`Gate_V`) from which a sample moves, m²/s⁴.
    pub variance_gate: f64,
}

impl Default for MagnitudeVarianceConfig {
    fn default() -> Self {
        Self { window: 0.055, magnitude_gate: 0.06, variance_gate: 0.06 }
    }
}

/// Energies of specific force and angular rate.
///
/// The window is the paper's, the rest was chosen on real walks with a VN-100, an MPU6050, an NGIMU
/// and OpenShoe's IMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WindowedEnergiesConfig {
    /// Length of the window, s: 15 samples at 100 Hz in the paper.
    pub window: f64,
    /// Standard deviation that the specific force is weighed with, m/s².
    pub accel_std: f64,
    /// Standard deviation that the angular rate is weighed with, rad/s.
    pub gyro_std: f64,
    /// Energy of the specific force (`T_a`) from which a sample moves.
    pub accel_threshold: f64,
    /// Energy of the angular rate (`T_w`) from which a sample moves.
    pub gyro_threshold: f64,
}

impl Default for WindowedEnergiesConfig {
    fn default() -> Self {
        Self {
            window: 0.15,
            accel_std: 0.02,
            gyro_std: 8.7e-3,
            accel_threshold: 3.0e3,
            gyro_threshold: 6.0e3,
        }
    }
}

/// Magnitude of the specific force, without isolated detections and gaps.
///
/// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU;
/// the paper prints none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MagnitudeDebouncedConfig {
    /// Deviation of the magnitude from gravity from which a sample moves, m/s².
    pub magnitude_gate: f64,
    /// Gap between detections up to which it is not believed, s.
    pub longest_gap: f64,
    /// Detection below which it is not believed, s; the detector's latency is this and the longest
    /// gap.
    pub shortest_stance: f64,
}

impl Default for MagnitudeDebouncedConfig {
    fn default() -> Self {
        Self { magnitude_gate: 0.3, longest_gap: 0.02, shortest_stance: 0.15 }
    }
}

/// A condition of the three-condition detector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Condition {
    /// C1: |f| within a band around gravity.
    Magnitude,
    /// C2: variance of |f| below a threshold.
    Variance,
    /// C3: |ω| below a threshold.
    Rate,
}

/// Magnitude, variance and rate, together or any of them.
///
/// The defaults were chosen for all three together on real walks with a VN-100, an MPU6050, an
/// NGIMU and OpenShoe's IMU; the paper prints none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ThreeConditionConfig {
    /// The conditions that must hold: one or more, each once.
    pub conditions: Vec<Condition>,
    /// Length of the variance's window, s; the other conditions look at its centre.
    pub window: f64,
    /// Deviation of the magnitude from gravity from which a sample moves, m/s².
    pub magnitude_band: f64,
    /// Variance of the magnitude from which a sample moves, m²/s⁴.
    pub variance_threshold: f64,
    /// Angular rate from which a sample moves, rad/s.
    pub rate_threshold: f64,
}

impl Default for ThreeConditionConfig {
    fn default() -> Self {
        Self {
            conditions: vec![Condition::Magnitude, Condition::Variance, Condition::Rate],
            window: 0.15,
            magnitude_band: 0.3,
            variance_threshold: 0.5,
            rate_threshold: 0.5,
        }
    }
}

/// Energy of the angular rate (ARE).
///
/// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AngularRateEnergyConfig {
    /// Length of the window, s.
    pub window: f64,
    /// Mean square of the angular rate up to which a sample is stationary, rad²/s².
    pub threshold: f64,
}

impl Default for AngularRateEnergyConfig {
    fn default() -> Self {
        Self { window: 0.1, threshold: 0.8 }
    }
}

/// Moving variance of the specific force (MV).
///
/// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MovingVarianceConfig {
    /// Length of the window, s.
    pub window: f64,
    /// Variance of the specific force, summed over the axes, up to which a sample is stationary,
    /// m²/s⁴.
    pub threshold: f64,
}

impl Default for MovingVarianceConfig {
    fn default() -> Self {
        Self { window: 0.15, threshold: 0.2 }
    }
}

/// Magnitude of the specific force (MAG).
///
/// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AccelerationMagnitudeConfig {
    /// Length of the window, s.
    pub window: f64,
    /// Mean square of |f| - g up to which a sample is stationary, m²/s⁴.
    pub threshold: f64,
}

impl Default for AccelerationMagnitudeConfig {
    fn default() -> Self {
        Self { window: 0.1, threshold: 0.1 }
    }
}

/// Contrast between the parts of a window (MBGTD).
///
/// The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GraphTheoreticConfig {
    /// Length of the window, s.
    pub window: f64,
    /// Contrast up to which a sample is stationary, m/s².
    pub threshold: f64,
}

impl Default for GraphTheoreticConfig {
    fn default() -> Self {
        Self { window: 0.15, threshold: 0.3 }
    }
}

impl DetectorConfig {
    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        match self {
            Self::AdaptiveShoe(shoe) => shoe.validate(),
            Self::Shoe(shoe) => shoe.validate(),
            Self::MagnitudeVariance(settings) => settings.validate(),
            Self::WindowedEnergies(settings) => settings.validate(),
            Self::MagnitudeDebounced(settings) => settings.validate(),
            Self::ThreeCondition(settings) => settings.validate(),
            Self::AngularRateEnergy(settings) => settings.validate(),
            Self::MovingVariance(settings) => settings.validate(),
            Self::AccelerationMagnitude(settings) => settings.validate(),
            Self::GraphTheoretic(settings) => settings.validate(),
        }
    }
}

impl AdaptiveShoeConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.accel_std", self.accel_std)?;
        positive("detector.gyro_std", self.gyro_std)?;
        within("detector.look_behind", self.look_behind, 0.0..=10.0, "between 0 and 10 s")?;
        within("detector.look_ahead", self.look_ahead, 0.0..=10.0, "between 0 and 10 s")?;
        within("detector.min_factor", self.min_factor, 1.0..=f64::MAX, "at least 1")?;
        at_least_zero("detector.noise_floor", self.noise_floor)?;
        within(
            "detector.upper_bound",
            self.upper_bound,
            self.noise_floor..=f64::MAX,
            "at least detector.noise_floor",
        )?;
        within("detector.max_fraction", self.max_fraction, 0.0..=1.0, "between 0 and 1")
    }
}

impl ShoeConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.accel_std", self.accel_std)?;
        positive("detector.gyro_std", self.gyro_std)?;
        positive("detector.threshold", self.threshold)
    }
}

impl MagnitudeVarianceConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.magnitude_gate", self.magnitude_gate)?;
        positive("detector.variance_gate", self.variance_gate)
    }
}

impl WindowedEnergiesConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.accel_std", self.accel_std)?;
        positive("detector.gyro_std", self.gyro_std)?;
        positive("detector.accel_threshold", self.accel_threshold)?;
        positive("detector.gyro_threshold", self.gyro_threshold)
    }
}

impl MagnitudeDebouncedConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        positive("detector.magnitude_gate", self.magnitude_gate)?;
        within("detector.longest_gap", self.longest_gap, 0.0..=10.0, "between 0 and 10 s")?;
        within("detector.shortest_stance", self.shortest_stance, 0.0..=10.0, "between 0 and 10 s")
    }
}

impl ThreeConditionConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        let all = [Condition::Magnitude, Condition::Variance, Condition::Rate];
        let used = all.iter().filter(|condition| self.conditions.contains(condition)).count();
        if used == 0 || used != self.conditions.len() {
            let value = format!("{:?}", self.conditions).to_lowercase();
            let expected = "one or more of magnitude, variance and rate, each once";
            return Err(ConfigError::OutOfRange { key: "detector.conditions", value, expected });
        }
        window("detector.window", self.window)?;
        positive("detector.magnitude_band", self.magnitude_band)?;
        positive("detector.variance_threshold", self.variance_threshold)?;
        positive("detector.rate_threshold", self.rate_threshold)
    }
}

impl AngularRateEnergyConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.threshold", self.threshold)
    }
}

impl MovingVarianceConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.threshold", self.threshold)
    }
}

impl AccelerationMagnitudeConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.threshold", self.threshold)
    }
}

impl GraphTheoreticConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        window("detector.window", self.window)?;
        positive("detector.threshold", self.threshold)
    }
}

fn window(key: &'static str, value: f64) -> Result<(), ConfigError> {
    within(key, value, 1.0e-4..=10.0, "between 0.0001 and 10 s")
}
