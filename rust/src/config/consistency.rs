//! Consistency checks between the settings of different stages.

use crate::aiding::magnetometer_settings::MagnetometerConfig;
use crate::error::ConfigError;
use crate::filter::settings::{FilterConfig, FilterKind};
use crate::gait::correction::{CorrectionConfig, CorrectionKind};
use crate::ins::alignment::AlignmentConfig;
use crate::ins::mechanization::MechanizationConfig;
use crate::ins::strapdown::MechanizationKind;
use crate::smoother::settings::{SmootherConfig, SmootherKind};

/// Heading updates need the Kalman filter.
pub(super) fn heading_is_filtered(
    magnetometer: &MagnetometerConfig,
    filter: &FilterConfig,
) -> Result<(), ConfigError> {
    error_if(
        magnetometer.heading && filter.kind != FilterKind::Kf,
        "magnetometer.heading corrects the states of a Kalman filter: \
         set filter.kind = \"kf\" or leave it out",
    )
}

/// At most one stage after the filter uses the stances.
pub(super) fn stances_are_used_once(
    filter: &FilterConfig,
    correction: &CorrectionConfig,
    smoother: &SmootherConfig,
) -> Result<(), ConfigError> {
    let corrects = correction.kind != CorrectionKind::None;
    let smooths = smoother.kind != SmootherKind::None;
    error_if(
        corrects && smooths,
        "correction.kind and smoother.kind both correct the steps by the stances: keep one of them",
    )?;
    error_if(
        corrects && filter.kind == FilterKind::Ins,
        "correction.kind needs stances, which filter.kind = \"ins\" does not use: \
         choose \"kf\" or \"dr\"",
    )?;
    error_if(
        smooths && filter.kind != FilterKind::Kf,
        "smoother.kind smooths the estimates of a Kalman filter: set filter.kind = \"kf\"",
    )
}

/// Earth rate needs the direction of north, and a mechanization that includes it.
pub(super) fn earth_rate_is_known(
    mechanization: &MechanizationConfig,
    alignment: &AlignmentConfig,
) -> Result<(), ConfigError> {
    let heading_known = alignment.heading_deg.is_some() || alignment.magnetic_field.is_some();
    error_if(
        mechanization.earth_rate && mechanization.kind == MechanizationKind::FirstOrder,
        "mechanization.kind = \"first-order\" does not model Earth rotation: \
         choose another kind or leave earth_rate out",
    )?;
    error_if(
        mechanization.earth_rate && !heading_known,
        "mechanization.earth_rate needs the direction of north: \
         set alignment.heading_deg or alignment.magnetic_field",
    )
}

/// Streaming excludes the stages that need the whole recording.
pub(super) fn streamable(
    correction: &CorrectionConfig,
    smoother: &SmootherConfig,
) -> Result<(), ConfigError> {
    error_if(
        smoother.kind == SmootherKind::Rts,
        "smoother.kind = \"rts\" needs the whole recording: \
         use track(), or smoother.kind = \"stepwise\" in a stream",
    )?;
    error_if(
        correction.kind != CorrectionKind::None,
        "correction.kind = \"lwi\" or \"rv\" needs the whole recording: \
         use track(), or smoother.kind = \"stepwise\" in a stream",
    )
}

fn error_if(inconsistent: bool, message: &str) -> Result<(), ConfigError> {
    if inconsistent { Err(ConfigError::Inconsistent(message.into())) } else { Ok(()) }
}
