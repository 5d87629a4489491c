//! Strides of a finished track.

use crate::gait::segmenter::Segmenter;
use crate::gait::stride::{SENSOR_X, Stride};
use crate::types::nav_state::NavState;

/// Strides of a finished track, from the state and the detection of each row.
///
/// The heading is that of the sensor's x axis.  The strides have no covariance.
pub fn strides(rows: impl IntoIterator<Item = (NavState, bool)>) -> Vec<Stride> {
    let mut segmenter = Segmenter::new(SENSOR_X);
    let mut found: Vec<Stride> =
        rows.into_iter().filter_map(|(state, rests)| segmenter.push(&state, rests, None)).collect();
    found.extend(segmenter.finish());
    found.retain(Stride::is_displaced);
    found
}
