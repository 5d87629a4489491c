//! Settings of the error-state filter.

use crate::error::ConfigError;
use crate::limits::Limits;
use crate::settings::{choices, settings};

choices! {
    /// States that a zero velocity corrects.
    pub enum FilterKind {
        /// All states that are correlated with the velocity, by a Kalman filter.
        Kf = "kf",
        /// The velocity alone: dead reckoning (Abdulrahim et al., approach 1).
        Dr = "dr",
        /// None: free-inertial, for comparison.
        Ins = "ins",
    }
}

choices! {
    /// Attitude update from the accelerometer in stance.
    pub enum AttitudeUpdate {
        /// None beyond the zero-velocity updates.
        None = "none",
        /// Roll and pitch.
        Gravity = "gravity",
        /// Roll, pitch and heading as published (Wang et al. 2019, eq. 17).  An accelerometer does
        /// not observe the heading, see `docs/papers.md`.
        Iaa = "iaa",
    }
}

settings! {
    /// The error-state filter.
    pub struct FilterConfig: "filter", also can_update_attitude {
        /// States that a zero velocity corrects.
        kind: FilterKind = FilterKind::Kf;
        /// Noise density of the specific force in addition to the sensor's: shock, bandwidth, scale
        /// and timing errors in motion.
        specific_force_noise: f64 = 0.1, "m/s²/√Hz", Limits::NonNegative;
        /// Noise density of the angular rate in addition to the sensor's.
        angular_rate_noise: f64 = 1.0e-3, "rad/s/√Hz", Limits::NonNegative;
        /// Factor on both noise densities at a clipped sample.
        clipped_noise_factor: f64 = 30.0, "", Limits::AtLeast(1.0);
        /// Standard deviation of the foot's velocity in stance.
        zero_velocity_std: f64 = 0.01, "m/s", Limits::Positive;
        /// Standard deviation of the lever arm from the rotation centre in stance; times the
        /// angular rate it adds to the standard deviation of the velocity.
        zupt_lever_std: f64 = 0.03, "m", Limits::NonNegative;
        /// Fraction of the velocity's standard deviation that all zero velocities of a stance have
        /// in common.  It widens the uncertainty of the position and leaves the track unchanged.
        zupt_correlation: f64 = 1.0, "", Limits::Between(0.0, 1.0);
        /// Largest angular rate of a foot that rolls on the ground, from whose motion the lever arm
        /// and the velocity in stance are estimated.  Zero: both are taken as zero.
        contact_rate: f64 = 2.0, "rad/s", Limits::NonNegative;
        /// Squared Mahalanobis distance beyond which a zero-velocity, zero-angular-rate or attitude
        /// update is rejected.
        chi2_gate: f64 = 1.0e3, "", Limits::Positive;
        /// Time in stance, over one or several stances, with rejected updates only, after which a
        /// zero velocity is accepted unconditionally.
        rejection_limit: f64 = 0.1, "s", Limits::NonNegative;
        /// Attitude update from the accelerometer in stance.
        attitude_update: AttitudeUpdate = AttitudeUpdate::None;
        /// Largest difference of the specific force from gravity for an attitude update, such as
        /// three standard deviations of the accelerometer at rest; needed for one.
        attitude_threshold: Option<f64> = None, "m/s²", Limits::Positive;
        /// Standard deviation of the attitude of an attitude update.
        attitude_std: f64 = 0.01, "rad", Limits::Positive;
        /// Whether rest corrects the gyroscope's bias.
        zero_angular_rate: bool = true;
        /// Standard deviation of the foot's angular rate at rest.
        zero_angular_rate_std: f64 = 0.02, "rad/s", Limits::Positive;
        /// Largest angular rate at rest.
        rest_rate: f64 = 0.05, "rad/s", Limits::Positive;
        /// Time for which the angular rate stays below `rest_rate` before rest is declared.
        rest_duration: f64 = 0.5, "s", Limits::Positive;
        /// Interval of the covariance propagation in swing; in between, `position_std` is right to
        /// a thousandth of its value.  Zero, and with a smoother: at every sample.
        covariance_interval: f64 = 0.02, "s", Limits::Between(0.0, 0.1);
    }
}

impl FilterConfig {
    fn can_update_attitude(&self) -> Result<(), ConfigError> {
        if self.attitude_update == AttitudeUpdate::None {
            return Ok(());
        }
        if self.attitude_threshold.is_none() {
            return Err(ConfigError::Inconsistent(
                "filter.attitude_update needs filter.attitude_threshold: the difference of \
                 the specific force from gravity (m/s^2) up to which \
                 it is noise, such as three standard deviations of the accelerometer at rest"
                    .into(),
            ));
        }
        if self.kind != FilterKind::Kf {
            return Err(ConfigError::Inconsistent(
                "filter.attitude_update corrects the states of a Kalman filter: \
                 set filter.kind = \"kf\" or leave it out"
                    .into(),
            ));
        }
        Ok(())
    }
}
