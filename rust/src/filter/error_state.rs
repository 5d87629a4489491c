//! The error states: five blocks of three, and the linear maps on them.

use nalgebra::{Matrix3, Vector3};

use crate::math::block_matrix;
use crate::math::simd::Simd;

/// Number of blocks of error states.
pub(crate) const BLOCKS: usize = block_matrix::BLOCKS;
/// Number of error states.
pub const STATES: usize = 3 * BLOCKS;

/// A block of three error states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block {
    /// Position error in n, m.
    Position,
    /// Velocity error in n, m/s.
    Velocity,
    /// Attitude error in n, rad.
    Attitude,
    /// Gyroscope bias error, rad/s.
    GyroBias,
    /// Accelerometer bias error, m/s².
    AccelBias,
}

impl Block {
    /// All blocks in the order of the state vector.
    pub const ALL: [Self; BLOCKS] =
        [Self::Position, Self::Velocity, Self::Attitude, Self::GyroBias, Self::AccelBias];

    pub(crate) const fn index(self) -> usize {
        self as usize
    }

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Attitude => "attitude",
            Self::GyroBias => "gyroscope bias",
            Self::AccelBias => "accelerometer bias",
        }
    }
}

/// What a linear map of the error states acts on: the states themselves, or their covariance.
pub(crate) trait LinearMap {
    /// Adds `m` times the states of `source` to those of `target`, another block.
    fn add_transformed(&mut self, simd: impl Simd, target: Block, source: Block, m: &Matrix3<f64>);

    /// Adds `scale` times the states of `source` to those of `target`, another block.
    fn add_scaled(&mut self, simd: impl Simd, target: Block, source: Block, scale: f64);

    /// Replaces the states of `block` by `m` times themselves.
    fn transform(&mut self, block: Block, m: &Matrix3<f64>);

    /// Applies the transposed factors of a transition without Earth rate, in the reverse order: see
    /// [`crate::filter::transition::Transition::apply`].
    #[inline]
    fn apply_transposed_factors(
        &mut self,
        simd: impl Simd,
        half: f64,
        tilt: &Matrix3<f64>,
        bias: &Matrix3<f64>,
    ) {
        self.add_transformed(simd, Block::GyroBias, Block::Attitude, &bias.transpose());
        self.add_scaled(simd, Block::Velocity, Block::Position, half);
        self.add_transformed(simd, Block::AccelBias, Block::Velocity, &bias.transpose());
        self.add_transformed(simd, Block::Attitude, Block::Velocity, &tilt.transpose());
        self.add_scaled(simd, Block::Velocity, Block::Position, half);
    }
}

/// Error states, or what is conjugate to them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ErrorStates(pub(crate) [Vector3<f64>; BLOCKS]);

impl ErrorStates {
    /// The states of a block.
    pub(crate) fn block(&self, block: Block) -> &Vector3<f64> {
        &self.0[block.index()]
    }

    pub(crate) fn block_mut(&mut self, block: Block) -> &mut Vector3<f64> {
        &mut self.0[block.index()]
    }
}

impl std::ops::AddAssign for ErrorStates {
    fn add_assign(&mut self, other: Self) {
        for (own, other) in self.0.iter_mut().zip(&other.0) {
            *own += other;
        }
    }
}

impl LinearMap for ErrorStates {
    #[inline]
    fn add_transformed(&mut self, _: impl Simd, target: Block, source: Block, m: &Matrix3<f64>) {
        let gain = m * self.block(source);
        *self.block_mut(target) += gain;
    }

    #[inline]
    fn add_scaled(&mut self, _: impl Simd, target: Block, source: Block, scale: f64) {
        let gain = scale * self.block(source);
        *self.block_mut(target) += gain;
    }

    #[inline]
    fn transform(&mut self, block: Block, m: &Matrix3<f64>) {
        *self.block_mut(block) = m * self.block(block);
    }
}
