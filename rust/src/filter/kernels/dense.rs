//! The matrices of the filter without blocks, against which the kernels are tested.

use nalgebra::{Matrix3, SMatrix};
use proptest::prelude::*;

use crate::filter::error_state::{Block, STATES};
use crate::math::block_matrix::{BLOCKS, Block3, Upper, at};

pub(crate) type Dense = SMatrix<f64, STATES, STATES>;

pub(crate) const BLOCK: usize = 3;

pub(crate) fn matrices() -> impl Strategy<Value = Matrix3<f64>> {
    prop::collection::vec(-2.0..2.0, BLOCK * BLOCK)
        .prop_map(|values| Matrix3::from_column_slice(&values))
}

/// The identity, and `m` where the states of `target` gain those of `source`.
pub(crate) fn shear(target: Block, source: Block, m: &Matrix3<f64>) -> Dense {
    let mut shear = Dense::identity();
    shear
        .fixed_view_mut::<BLOCK, BLOCK>(BLOCK * target.index(), BLOCK * source.index())
        .copy_from(m);
    shear
}

/// A positive matrix A Aᵀ + I.
pub(crate) fn positive() -> impl Strategy<Value = Dense> {
    prop::collection::vec(-1.0..1.0, STATES * STATES).prop_map(|values| {
        let a = Dense::from_column_slice(&values);
        a * a.transpose() + Dense::identity()
    })
}

pub(crate) fn upper(dense: &Dense) -> Upper {
    let mut upper = Upper::default();
    for i in 0..BLOCKS {
        for j in i..BLOCKS {
            upper[at(i, j)] =
                Block3::from(&dense.fixed_view::<BLOCK, BLOCK>(BLOCK * i, BLOCK * j).into_owned());
        }
    }
    upper
}

/// The largest difference between the upper blocks and a dense matrix.
pub(crate) fn difference(upper: &Upper, dense: &Dense) -> f64 {
    let mut largest = 0.0_f64;
    for i in 0..BLOCKS {
        for j in i..BLOCKS {
            let block = dense.fixed_view::<BLOCK, BLOCK>(BLOCK * i, BLOCK * j);
            largest = largest.max((Matrix3::from(&upper[at(i, j)]) - block).amax());
        }
    }
    largest
}
