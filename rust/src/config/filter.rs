//! Settings of the error-state filter.

use serde::{Deserialize, Serialize};

use crate::error::ConfigError;
use crate::limits::{at_least_zero, positive, within};

/// What a zero velocity corrects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FilterKind {
    /// All states that the velocity depends on: the Kalman filter.
    #[default]
    Kf,
    /// The velocity alone: dead reckoning (Abdulrahim et al., approach 1).
    Dr,
    /// Nothing: the strapdown alone, for comparison.
    Ins,
}

/// What the accelerometer tells of the attitude in stance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AttitudeUpdate {
    /// Nothing beyond what the zero velocities tell.
    #[default]
    None,
    /// Roll and pitch.
    Gravity,
    /// Roll, pitch and the heading of Wang et al. 2019, eq. 17, as published: an accelerometer
    /// carries no heading, see docs/papers.md.
    Iaa,
}

/// The error-state filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FilterConfig {
    /// What a zero velocity corrects.
    pub kind: FilterKind,
    /// Noise density of the specific force beyond the sensor's own, m/s²/√Hz: shock, bandwidth,
    /// scale and timing of a foot in motion.
    pub specific_force_noise: f64,
    /// Noise density of the angular rate beyond the sensor's own, rad/s/√Hz.
    pub angular_rate_noise: f64,
    /// Factor by which both grow at a sample that clips.
    pub clipped_noise_factor: f64,
    /// Standard deviation of a foot's velocity in stance, m/s.
    pub zero_velocity_std: f64,
    /// How far what the foot rolls about wanders, m: the velocity of a foot in stance is uncertain
    /// by this times its angular rate.
    pub zupt_lever_std: f64,
    /// Part of both that all zero velocities of a stance have in common.  The foot takes it along
    /// to the next stance, so it widens the uncertainty of the position; the track is the same.
    pub zupt_correlation: f64,
    /// Angular rate up to which a foot that stands in between rolls on the ground, rad/s: from
    /// these contacts it is learned what it rolls about, and with which velocity in stance.  Zero:
    /// a foot in stance has none.
    pub contact_rate: f64,
    /// Squared Mahalanobis distance of a zero velocity, zero angular rate or attitude from the
    /// prediction beyond which it is rejected.
    pub chi2_gate: f64,
    /// Time in stance, over one or several of them, with nothing but rejections after which a zero
    /// velocity is believed all the same, s: the foot stands and the filter is wrong.
    pub rejection_limit: f64,
    /// What the accelerometer tells of the attitude in stance.
    pub attitude_update: AttitudeUpdate,
    /// Difference of the specific force from gravity below which it does, m/s²: from the sensor's
    /// noise.
    pub attitude_threshold: Option<f64>,
    /// Standard deviation of the attitude that it tells, rad.
    pub attitude_std: f64,
    /// Whether rest corrects the gyroscope's bias.
    pub zero_angular_rate: bool,
    /// Standard deviation of a foot's angular rate at rest, rad/s.
    pub zero_angular_rate_std: f64,
    /// Angular rate below which the foot may be at rest, rad/s.
    pub rest_rate: f64,
    /// How long the angular rate must have stayed below that, s.
    pub rest_duration: f64,
    /// While the foot swings the covariance is carried over as many samples at once as take about
    /// this time, s; zero: over one after the other, as with a smoother.
    pub covariance_interval: f64,
}

impl Default for FilterConfig {
    fn default() -> Self {
        Self {
            kind: FilterKind::default(),
            specific_force_noise: 0.1,
            angular_rate_noise: 1.0e-3,
            clipped_noise_factor: 30.0,
            zero_velocity_std: 0.01,
            zupt_lever_std: 0.03,
            zupt_correlation: 1.0,
            contact_rate: 2.0,
            chi2_gate: 1.0e3,
            rejection_limit: 0.1,
            attitude_update: AttitudeUpdate::default(),
            attitude_threshold: None,
            attitude_std: 0.01,
            zero_angular_rate: true,
            zero_angular_rate_std: 0.02,
            rest_rate: 0.05,
            rest_duration: 0.5,
            covariance_interval: 0.02,
        }
    }
}

impl FilterConfig {
    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        at_least_zero("filter.specific_force_noise", self.specific_force_noise)?;
        at_least_zero("filter.angular_rate_noise", self.angular_rate_noise)?;
        within(
            "filter.clipped_noise_factor",
            self.clipped_noise_factor,
            1.0..=f64::MAX,
            "at least 1",
        )?;
        positive("filter.zero_velocity_std", self.zero_velocity_std)?;
        at_least_zero("filter.zupt_lever_std", self.zupt_lever_std)?;
        within("filter.zupt_correlation", self.zupt_correlation, 0.0..=1.0, "between 0 and 1")?;
        at_least_zero("filter.contact_rate", self.contact_rate)?;
        positive("filter.chi2_gate", self.chi2_gate)?;
        at_least_zero("filter.rejection_limit", self.rejection_limit)?;
        self.attitude_threshold
            .map_or(Ok(()), |threshold| positive("filter.attitude_threshold", threshold))?;
        positive("filter.attitude_std", self.attitude_std)?;
        positive("filter.zero_angular_rate_std", self.zero_angular_rate_std)?;
        positive("filter.rest_rate", self.rest_rate)?;
        positive("filter.rest_duration", self.rest_duration)?;
        within(
            "filter.covariance_interval",
            self.covariance_interval,
            0.0..=0.1,
            "between 0 and 0.1",
        )?;
        self.validate_attitude_update()
    }

    fn validate_attitude_update(&self) -> Result<(), ConfigError> {
        if self.attitude_update == AttitudeUpdate::None {
            return Ok(());
        }
        if self.attitude_threshold.is_none() {
            return Err(ConfigError::Inconsistent(
                "filter.attitude_update needs filter.attitude_threshold: the difference of the specific force from gravity (m/s^2) up to which \
                 it is noise, such as three standard deviations of the accelerometer at rest"
                    .into(),
            ));
        }
        if self.kind != FilterKind::Kf {
            return Err(ConfigError::Inconsistent(
                "filter.attitude_update corrects the states of a Kalman filter: set filter.kind = \"kf\" or leave it out".into(),
            ));
        }
        Ok(())
    }
}
