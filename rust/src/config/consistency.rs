//! Checks of the settings of different stages against each other.

use crate::aiding::magnetometer_settings::MagnetometerConfig;
use crate::error::ConfigError;
use crate::filter::settings::{FilterConfig, FilterKind};
use crate::ins::alignment::AlignmentConfig;
use crate::ins::mechanization::MechanizationConfig;
use crate::ins::strapdown::MechanizationKind;
use crate::pipeline::gait_correction::{CorrectionConfig, CorrectionKind};
use crate::smoother::settings::{SmootherConfig, SmootherKind};

/// A heading update needs the Kalman filter.
pub(super) fn heading_is_filtered(
    magnetometer: &MagnetometerConfig,
    filter: &FilterConfig,
) -> Result<(), ConfigError> {
    refuse_if(
        magnetometer.heading && filter.kind != FilterKind::Kf,
        "magnetometer.heading corrects the states of a Kalman filter: set filter.kind = \"kf\" or leave it out",
    )
}

/// The information of the stances is used by one stage after the filter at most.
pub(super) fn stances_are_used_once(
    filter: &FilterConfig,
    correction: &CorrectionConfig,
    smoother: &SmootherConfig,
) -> Result<(), ConfigError> {
    let corrects = correction.kind != CorrectionKind::None;
    let smooths = smoother.kind != SmootherKind::None;
    refuse_if(
        corrects && smooths,
        "correction.kind and smoother.kind both correct the steps by the stances: keep one of them",
    )?;
    refuse_if(
        corrects && filter.kind == FilterKind::Ins,
        "correction.kind needs stances, which filter.kind = \"ins\" does not use: choose \"kf\" or \"dr\"",
    )?;
    refuse_if(
        smooths && filter.kind != FilterKind::Kf,
        "smoother.kind goes back over the steps of a Kalman filter: set filter.kind = \"kf\"",
    )
}

/// Earth rate needs the direction of north, and a mechanization that includes it.
pub(super) fn earth_rate_is_known(
    mechanization: &MechanizationConfig,
    alignment: &AlignmentConfig,
) -> Result<(), ConfigError> {
    let heading_known = alignment.heading_deg.is_some() || alignment.magnetic_field.is_some();
    refuse_if(
        mechanization.earth_rate && mechanization.kind == MechanizationKind::FirstOrder,
        "mechanization.kind = \"first-order\" knows no rotation of the Earth: choose another kind or leave earth_rate out",
    )?;
    refuse_if(
        mechanization.earth_rate && !heading_known,
        "mechanization.earth_rate needs to know where north is: set alignment.heading_deg or alignment.magnetic_field",
    )
}

/// No stage needs the end of the data.
pub(super) fn streamable(
    correction: &CorrectionConfig,
    smoother: &SmootherConfig,
) -> Result<(), ConfigError> {
    refuse_if(
        smoother.kind == SmootherKind::Rts,
        "smoother.kind = \"rts\" needs the whole recording: use track(), or smoother.kind = \"stepwise\" in a stream",
    )?;
    refuse_if(
        correction.kind != CorrectionKind::None,
        "correction.kind = \"lwi\" or \"rv\" needs the whole recording: use track(), or smoother.kind = \"stepwise\" in a stream",
    )
}

fn refuse_if(contradicts: bool, message: &str) -> Result<(), ConfigError> {
    if contradicts { Err(ConfigError::Inconsistent(message.into())) } else { Ok(()) }
}
