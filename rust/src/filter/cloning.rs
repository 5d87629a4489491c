//! Stochastic cloning: the cross-covariance of the present errors with those at an earlier instant.
//!
//! At that instant the errors of the pose, δp and φ about the up axis of n, are copied.  The copy is
//! constant, and its cross-covariance X with the present errors is propagated as the covariance P, from
//! one side:
//!
//! ```text
//! over a transition     P <- F P Fᵀ + Q          X <- F X
//! over an observation   P <- (I - K H) P         X <- (I - K H) X
//! ```
//!
//! This is the filter of the 19 states with the copy, in which no observation corrects the copy: the
//! solution of that instant is output and does not change.
//!
//! # References
//! S. I. Roumeliotis, J. W. Burdick, "Stochastic Cloning: A Generalized Framework for Processing
//! Relative State Measurements", ICRA 2002.

use nalgebra::{Matrix3, Matrix3x4, Matrix4, Vector3};

use crate::filter::covariance::Covariance;
use crate::filter::error_state::{Block, LinearMap};
use crate::filter::kernels::forward::{Columns, move_columns, reduce_columns};
use crate::filter::observation::Observation;
use crate::filter::process_noise::Noise;
use crate::filter::recorder::FilterRecorder;
use crate::filter::transition::Transition;
use crate::math::block_matrix::Block3;
use crate::math::simd::{Simd, WithSimd};

/// Pose errors at an earlier instant, and their cross-covariance with the present errors.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClonedErrors {
    own: Matrix4<f64>,
    /// X, a column for each of the cloned errors.
    cross: Columns,
}

impl ClonedErrors {
    /// Clones the present errors.
    pub(crate) fn of(p: &Covariance) -> Self {
        let cross =
            Block::ALL.map(|block| {
                let position = p.block(block, Block::Position);
                let attitude = p.block(block, Block::Attitude);
                Block3([0, 1, 2].map(|k| {
                    [position[(k, 0)], position[(k, 1)], position[(k, 2)], attitude[(k, 2)]]
                }))
            });
        Self { own: pose_rows(&cross), cross }
    }

    /// Covariance of the cloned pose errors, in the order of [`pose_covariance`].
    pub(crate) fn own(&self) -> &Matrix4<f64> {
        &self.own
    }

    /// Cross-covariance of the present pose errors, along the rows, with the cloned ones.
    pub(crate) fn with_now(&self) -> Matrix4<f64> {
        pose_rows(&self.cross)
    }

    fn block(&self, block: Block) -> Matrix3x4<f64> {
        Matrix3x4::from_row_slice(self.cross[block.index()].0.as_flattened())
    }

    fn replace(&mut self, block: Block, columns: &Matrix3x4<f64>) {
        self.cross[block.index()] = Block3([0, 1, 2].map(|k| columns.row(k).transpose().into()));
    }
}

/// Covariance of the errors of position (m) and heading (rad, about the up axis), in n.
pub(crate) fn pose_covariance(p: &Covariance) -> Matrix4<f64> {
    *ClonedErrors::of(p).own()
}

fn pose_rows(columns: &Columns) -> Matrix4<f64> {
    let [x, y, z] = columns[Block::Position.index()].0;
    let heading = columns[Block::Attitude.index()].0[2];
    Matrix4::from_row_slice([x, y, z, heading].as_flattened())
}

impl LinearMap for ClonedErrors {
    #[inline]
    fn add_transformed(&mut self, _: impl Simd, target: Block, source: Block, m: &Matrix3<f64>) {
        self.replace(target, &(self.block(target) + m * self.block(source)));
    }

    #[inline]
    fn add_scaled(&mut self, _: impl Simd, target: Block, source: Block, scale: f64) {
        self.replace(target, &(self.block(target) + scale * self.block(source)));
    }

    #[inline]
    fn transform(&mut self, block: Block, m: &Matrix3<f64>) {
        self.replace(block, &(m * self.block(block)));
    }
}

impl FilterRecorder for ClonedErrors {
    #[inline]
    fn transition(&mut self, simd: impl Simd, transition: &Transition, _: &Noise) {
        simd.vectorize(Propagate { cross: &mut self.cross, transition });
        transition.apply_earth_rate(self);
    }

    #[inline]
    fn inflate(&mut self, _: Block, _: f64) {}

    #[inline]
    fn couple(&mut self, simd: impl Simd, m: &Matrix3<f64>) {
        self.add_transformed(simd, Block::Attitude, Block::AccelBias, m);
    }

    #[inline]
    fn observation(&mut self, simd: impl Simd, observation: &Observation) {
        simd.vectorize(Reduce { cross: &mut self.cross, observation });
    }

    #[inline]
    fn reset_block(&mut self, block: Block, _: &Vector3<f64>) {
        self.cross[block.index()] = Block3::default();
    }
}

/// X becomes F X, without Earth rate.
struct Propagate<'a> {
    cross: &'a mut Columns,
    transition: &'a Transition,
}

impl WithSimd for Propagate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (half, tilt, bias) = self.transition.factors();
        move_columns(simd, self.cross, half, &tilt, &bias);
    }
}

/// X becomes (I - K H) X.
struct Reduce<'a> {
    cross: &'a mut Columns,
    observation: &'a Observation,
}

impl WithSimd for Reduce<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Observation { block, whitener, whitened_gain, .. } = self.observation;
        reduce_columns(simd, self.cross, block.index(), whitener, whitened_gain);
    }
}

#[cfg(test)]
mod tests;
