//! What the filter takes from the settings.

use crate::filter::settings::FilterConfig;
use crate::ins::alignment::AlignmentConfig;
use crate::ins::strapdown::Strapdown;
use crate::types::sensor::SensorConfig;

/// The settings of the filter and of what its initial covariance depends on.
pub(crate) struct FilterSetup<'a> {
    pub(crate) sensor: &'a SensorConfig,
    pub(crate) alignment: &'a AlignmentConfig,
    pub(crate) filter: &'a FilterConfig,
    pub(crate) strapdown: &'a Strapdown,
    /// Whether intervals in swing may be batched; a smoother goes back over each of them.
    pub(crate) batches: bool,
}
