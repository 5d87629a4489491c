//! Position fixes: positions that another system measures, such as GNSS, UWB anchors or a surveyed
//! point.
//!
//! # References
//! P. D. Groves, "Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems", 2nd
//! ed., 2013: sec. 14.3.1 (loosely coupled integration).

use std::collections::VecDeque;

use nalgebra::{Matrix3, Vector3};

use crate::aiding::aid::{Aid, Epoch, Outcome};
use crate::error::DataError;
use crate::filter::error_state::Block;
use crate::filter::error_state_filter::ErrorStateFilter;
use crate::filter::recorder::FilterRecorder;
use crate::filter::settings::{FilterConfig, FilterKind};
use crate::math::simd::Simd;
use crate::types::nav_state::NavState;

/// Squared Mahalanobis distance of a fix beyond which it is rejected: one valid fix in a thousand, in
/// three dimensions.
const CHI2_GATE: f64 = 16.27;
/// Greatest age of a fix, s: over this time the foot moves by its velocity times the age, up to some
/// centimetres.
const MAX_AGE: f64 = 0.05;

/// A position of the sensor at a time, with the covariance of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionFix {
    time: f64,
    position: Vector3<f64>,
    covariance: Matrix3<f64>,
}

impl PositionFix {
    /// A fix at `time` (s, of the clock of the samples): position in n (m, from the start of the
    /// walk) and covariance of its error (m²).
    ///
    /// # Errors
    /// [`DataError::InvalidReading`] for numbers that are not finite, and for a covariance that is
    /// not symmetric and positive definite.
    pub fn new(
        time: f64,
        position: [f64; 3],
        covariance: [[f64; 3]; 3],
    ) -> Result<Self, DataError> {
        if !time.is_finite() || position.iter().any(|x| !x.is_finite()) {
            return Err(DataError::InvalidReading {
                time,
                found: format!("the position {position:?}"),
                expected: "a finite time and three finite numbers, m",
            });
        }
        let matrix = Matrix3::from_fn(|row, column| covariance[row][column]);
        let is_finite = matrix.sum().is_finite();
        if !is_finite || matrix != matrix.transpose() || matrix.cholesky().is_none() {
            return Err(DataError::InvalidReading {
                time,
                found: format!("the covariance {covariance:?}"),
                expected: "a symmetric matrix that is positive definite, m²",
            });
        }
        Ok(Self { time, position: position.into(), covariance: matrix })
    }

    /// Stamp, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }
}

/// Updates the filter with position fixes, one at a sample.
#[derive(Clone, Debug)]
pub(crate) struct PositionFixes {
    /// Fixes that wait for their samples, in the order of their arrival.
    pending: VecDeque<PositionFix>,
}

impl PositionFixes {
    /// None without a Kalman filter.
    pub(crate) fn new(config: &FilterConfig) -> Option<Self> {
        (config.kind == FilterKind::Kf).then(|| Self { pending: VecDeque::new() })
    }

    pub(crate) fn push(&mut self, fix: &PositionFix) {
        self.pending.push_back(*fix);
    }

    fn is_due(&self, time: f64) -> bool {
        self.pending.front().is_some_and(|fix| fix.time <= time)
    }

    /// Compares the oldest fix with the position at its time.
    #[inline(never)]
    fn apply<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        let Some(fix) = self.pending.pop_front() else { return Outcome::None };
        let nav = &filter.estimate.nav;
        let age = nav.time - fix.time;
        if age > MAX_AGE {
            return Outcome::Rejected;
        }
        let innovation = fix.position - (nav.position - age * nav.velocity);
        filter.observe(Block::Position, &innovation, &fix.covariance, CHI2_GATE, recorder).into()
    }
}

impl Aid for PositionFixes {
    fn observes(&self) -> Option<Block> {
        Some(Block::Position)
    }

    /// The foot was at rest at the origin at the time of earlier fixes, unless it moved.
    fn begin(&mut self, nav: &NavState, at_rest: bool) {
        if at_rest {
            self.pending.iter_mut().for_each(|fix| fix.time = fix.time.max(nav.time));
        }
    }

    #[inline(always)]
    fn prepare(&mut self, epoch: &Epoch<'_>, _: impl Simd) -> bool {
        self.is_due(epoch.sample.time)
    }

    #[inline(always)]
    fn update<S: Simd>(
        &mut self,
        filter: &mut ErrorStateFilter<S>,
        epoch: &Epoch<'_>,
        recorder: &mut impl FilterRecorder,
    ) -> Outcome {
        if self.is_due(epoch.sample.time) { self.apply(filter, recorder) } else { Outcome::None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn the_error_of_an_invalid_fix_names_the_value_and_the_cure() {
        let error = PositionFix::new(2.5, [1.0, f64::NAN, 3.0], IDENTITY).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the reading at 2.5 s has the position [1.0, NaN, 3.0]; \
             expected a finite time and three finite numbers, m"
        );
        for covariance in [
            [[0.0; 3]; 3],
            [[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [[f64::INFINITY, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        ] {
            let error = PositionFix::new(2.5, [0.0; 3], covariance).unwrap_err().to_string();
            assert!(error.contains("positive definite"), "{error}");
        }
    }
}
