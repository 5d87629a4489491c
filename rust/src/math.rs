//! Rotations, block matrices, and vectors on the instructions of the processor.

#[expect(clippy::many_single_char_names, reason = "rows of blocks")]
pub(crate) mod block_matrix;
pub mod rotation;
#[expect(clippy::many_single_char_names, reason = "quaternions")]
pub(crate) mod rotation_kernels;
pub(crate) mod simd;
