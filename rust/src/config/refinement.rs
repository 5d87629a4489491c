//! Settings of what post_processes a track after the filter: corrections of gait cycles, and
//! smoothers.

use serde::{Deserialize, Serialize};

use crate::config::filter::{FilterConfig, FilterKind};
use crate::error::ConfigError;
use crate::limits::within;

/// How the velocity that a stance finds wrong is taken off the swing before it (Abdulrahim et al.).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CorrectionKind {
    /// Not at all.
    #[default]
    None,
    /// Linearly weighted interpolation: the mean velocity of the stance.
    Lwi,
    /// Residual velocity: that at the first sample of the stance.
    Rv,
}

/// Correction of whole gait cycles; the position is integrated again from the corrected velocity.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CorrectionConfig {
    /// Which velocity is taken off.
    pub kind: CorrectionKind,
}

/// Which later samples a state is estimated from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SmootherKind {
    /// None.
    #[default]
    None,
    /// Those of its step: works in a stream, with a delay.
    Stepwise,
    /// All (Rauch, Tung, Striebel): needs the whole recording.
    Rts,
}

/// Estimates from what came later.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SmootherConfig {
    /// Which later samples are used.
    pub kind: SmootherKind,
    /// Longest step that is smoothed as a whole by the step-wise smoother, s: its delay.
    pub longest_step: f64,
}

impl Default for SmootherConfig {
    fn default() -> Self {
        Self { kind: SmootherKind::default(), longest_step: 2.0 }
    }
}

impl SmootherConfig {
    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        within("smoother.longest_step", self.longest_step, 0.1..=60.0, "between 0.1 and 60 s")
    }
}

/// Checks that the stages fit together.
pub(super) fn validate(
    filter: &FilterConfig,
    correction: &CorrectionConfig,
    smoother: &SmootherConfig,
) -> Result<(), ConfigError> {
    let corrects = correction.kind != CorrectionKind::None;
    let smooths = smoother.kind != SmootherKind::None;
    let contradiction = if corrects && smooths {
        "correction.kind and smoother.kind both charge the steps with what the stances tell: keep one of them"
    } else if corrects && filter.kind == FilterKind::Ins {
        "correction.kind needs stances, which filter.kind = \"ins\" does not use: choose \"kf\" or \"dr\""
    } else if smooths && filter.kind != FilterKind::Kf {
        "smoother.kind goes back over the steps of a Kalman filter: set filter.kind = \"kf\""
    } else {
        return Ok(());
    };
    Err(ConfigError::Inconsistent(contradiction.into()))
}

/// Checks that nothing has to wait for the end of the data.
pub(crate) fn validate_for_streaming(
    correction: &CorrectionConfig,
    smoother: &SmootherConfig,
) -> Result<(), ConfigError> {
    let needs_all = if smoother.kind == SmootherKind::Rts {
        "smoother.kind = \"rts\" needs the whole recording: use track(), or smoother.kind = \"stepwise\" in a stream"
    } else if correction.kind != CorrectionKind::None {
        "correction.kind = \"lwi\" or \"rv\" needs the whole recording: use track(), or smoother.kind = \"stepwise\" in a stream"
    } else {
        return Ok(());
    };
    Err(ConfigError::Inconsistent(needs_all.into()))
}
