//! Symmetric matrices of error states as 3x3 blocks, and the arithmetic of a block in
//! vectors.
//!
//! Each of the 15 blocks on and above the diagonal is three rows of four numbers, the last of which
//! is zero: a row is one vector of a processor with AVX.  All products of blocks are of one kind,
//! `C + A B`: numbers of A, read from memory, times rows of B.
//!
//! What works on loaded blocks is inlined by force into the functions that [`crate::math::simd`]
//! compiles for each instruction set; a call that is not inlined would run on the wrong one.

use std::ops::{Index, IndexMut};

use nalgebra::{Matrix3, Vector3};

use crate::math::simd::{F64x4, Simd};

/// Number of blocks in a row.
pub(crate) const BLOCKS: usize = 5;
/// Number of blocks on and above the diagonal.
const UPPER: usize = BLOCKS * (BLOCKS + 1) / 2;

/// A symmetric matrix of 15x15, by its upper blocks; aligned, so that no row lies across two lines
/// of the cache.
#[derive(Clone, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Upper(pub(crate) [Block3; UPPER]);

impl Index<usize> for Upper {
    type Output = Block3;

    #[inline(always)]
    fn index(&self, index: usize) -> &Block3 {
        &self.0[index]
    }
}

impl IndexMut<usize> for Upper {
    #[inline(always)]
    fn index_mut(&mut self, index: usize) -> &mut Block3 {
        &mut self.0[index]
    }
}

/// Where the block (i, j), i <= j, is kept.
pub(crate) const fn at(i: usize, j: usize) -> usize {
    i * (2 * BLOCKS - 1 - i) / 2 + j
}

/// A 3x3 block: three rows of three numbers and a zero; or a block of four columns, with a number
/// in place of the zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Block3(pub(crate) [[f64; 4]; 3]);

impl From<&Matrix3<f64>> for Block3 {
    #[inline(always)]
    fn from(m: &Matrix3<f64>) -> Self {
        Self([[m.m11, m.m12, m.m13, 0.0], [m.m21, m.m22, m.m23, 0.0], [m.m31, m.m32, m.m33, 0.0]])
    }
}

impl From<&Block3> for Matrix3<f64> {
    #[inline]
    fn from(Block3([a, b, c]): &Block3) -> Self {
        Self::new(a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2])
    }
}

impl Block3 {
    /// The numbers on the diagonal.
    #[inline(always)]
    pub(crate) fn diagonal(&self) -> [f64; 3] {
        [self.0[0][0], self.0[1][1], self.0[2][2]]
    }

    /// The numbers of a column, each broadcast to a vector.
    #[inline(always)]
    pub(crate) fn broadcast_column<S: Simd>(&self, k: usize) -> [S::F64x4; 3] {
        let [a, b, c] = &self.0;
        [S::F64x4::splat(a[k]), S::F64x4::splat(b[k]), S::F64x4::splat(c[k])]
    }

    /// Adds to the diagonal.
    #[inline]
    pub(crate) fn add_diagonal(&mut self, values: [f64; 3]) {
        for (k, value) in values.into_iter().enumerate() {
            self.0[k][k] += value;
        }
    }

    #[inline(always)]
    pub(crate) fn transpose(&self) -> Self {
        let [a, b, c] = &self.0;
        Self([0, 1, 2].map(|k| [a[k], b[k], c[k], 0.0]))
    }
}

/// The numbers of a vector that many rows are multiplied by, each broadcast to a vector.
pub(crate) struct BroadcastVector<S: Simd>([S::F64x4; 3]);

impl<S: Simd> BroadcastVector<S> {
    #[inline(always)]
    pub(crate) fn new(v: &Vector3<f64>) -> Self {
        Self([S::F64x4::splat(v.x), S::F64x4::splat(v.y), S::F64x4::splat(v.z)])
    }

    /// `[v×] right`.
    #[inline(always)]
    pub(crate) fn cross(&self, BlockReg([x, y, z]): BlockReg<S>) -> BlockReg<S> {
        let [u, v, w] = self.0;
        BlockReg([
            v.mul(z).sub_product_of(w, y),
            w.mul(x).sub_product_of(u, z),
            u.mul(y).sub_product_of(v, x),
        ])
    }
}

/// As [`BroadcastVector`], of a matrix.
pub(crate) struct BroadcastMatrix<S: Simd>([[S::F64x4; 3]; 3]);

impl<S: Simd> BroadcastMatrix<S> {
    #[inline(always)]
    pub(crate) fn new(m: &Matrix3<f64>) -> Self {
        Self([
            [S::F64x4::splat(m.m11), S::F64x4::splat(m.m12), S::F64x4::splat(m.m13)],
            [S::F64x4::splat(m.m21), S::F64x4::splat(m.m22), S::F64x4::splat(m.m23)],
            [S::F64x4::splat(m.m31), S::F64x4::splat(m.m32), S::F64x4::splat(m.m33)],
        ])
    }

    /// The rows of mᵀ.
    #[inline(always)]
    pub(crate) fn transposed(&self) -> BlockReg<S> {
        let [a, b, c] = self.0;
        BlockReg([
            S::F64x4::diagonal(a[0], b[0], c[0]),
            S::F64x4::diagonal(a[1], b[1], c[1]),
            S::F64x4::diagonal(a[2], b[2], c[2]),
        ])
    }

    /// `m right`.
    #[inline(always)]
    pub(crate) fn mul(&self, BlockReg([x, y, z]): BlockReg<S>) -> BlockReg<S> {
        let [a, b, c] = self.0;
        BlockReg([
            a[0].mul(x).add_product_of(a[1], y).add_product_of(a[2], z),
            b[0].mul(x).add_product_of(b[1], y).add_product_of(b[2], z),
            c[0].mul(x).add_product_of(c[1], y).add_product_of(c[2], z),
        ])
    }
}

/// A 3x3 block that is being worked on.
#[derive(Clone, Copy)]
pub(crate) struct BlockReg<S: Simd>(pub(crate) [S::F64x4; 3]);

impl<S: Simd> BlockReg<S> {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self::from(&Block3::default())
    }

    #[inline(always)]
    pub(crate) fn from(Block3([a, b, c]): &Block3) -> Self {
        Self([S::F64x4::load(a), S::F64x4::load(b), S::F64x4::load(c)])
    }

    #[inline(always)]
    pub(crate) fn store(self, rows: &mut Block3) {
        let Block3([a, b, c]) = rows;
        self.0[0].store(a);
        self.0[1].store(b);
        self.0[2].store(c);
    }

    #[inline(always)]
    pub(crate) fn to_block(self) -> Block3 {
        let mut rows = Block3::default();
        self.store(&mut rows);
        rows
    }

    #[inline(always)]
    pub(crate) fn transpose(self) -> Self {
        Self(S::F64x4::transpose(self.0))
    }

    /// `self + factor * other`.
    #[inline(always)]
    pub(crate) fn add_scaled(self, factor: f64, other: Self) -> Self {
        self.add_broadcast_scaled(S::F64x4::splat(factor), other)
    }

    #[inline(always)]
    pub(crate) fn half(self) -> Block3 {
        Self::zero().add_scaled(0.5, self).to_block()
    }

    /// `selfᵀ y`.
    #[inline(always)]
    pub(crate) fn transposed_mul(self, y: &Vector3<f64>) -> S::F64x4 {
        let [a, b, c] = self.0;
        a.scale(y.x).add_scaled(y.y, b).add_scaled(y.z, c)
    }

    /// `self + value I`.
    #[inline(always)]
    pub(crate) fn add_to_diagonal(self, value: f64) -> Self {
        let [a, b, c] = self.0;
        let unit = |x, y, z| S::F64x4::from_array([x, y, z]);
        Self([
            a.add_scaled(value, unit(1.0, 0.0, 0.0)),
            b.add_scaled(value, unit(0.0, 1.0, 0.0)),
            c.add_scaled(value, unit(0.0, 0.0, 1.0)),
        ])
    }

    /// `self + (half + halfᵀ)`, in this order, which keeps a symmetric block symmetric to the bit.
    #[inline(always)]
    pub(crate) fn add_symmetrized(self, half: Self) -> Self {
        self.add_scaled(1.0, half.add_transpose())
    }

    /// `self + selfᵀ`, symmetric to the bit.
    #[inline(always)]
    pub(crate) fn add_transpose(self) -> Self {
        self.add_scaled(1.0, self.transpose())
    }

    /// `self + left right`.
    #[inline(always)]
    pub(crate) fn add_product(self, Block3(left): &Block3, Self([x, y, z]): Self) -> Self {
        let [a, b, c] = self.0;
        let [i, j, k] = left;
        Self([
            a.add_scaled(i[0], x).add_scaled(i[1], y).add_scaled(i[2], z),
            b.add_scaled(j[0], x).add_scaled(j[1], y).add_scaled(j[2], z),
            c.add_scaled(k[0], x).add_scaled(k[1], y).add_scaled(k[2], z),
        ])
    }

    /// `left self`, where all above the diagonal of `left` is zero.
    #[inline(always)]
    pub(crate) fn lower_mul(self, Block3(left): &Block3) -> Self {
        let ([x, y, z], [i, j, k]) = (self.0, left);
        Self([
            x.scale(i[0]),
            x.scale(j[0]).add_scaled(j[1], y),
            x.scale(k[0]).add_scaled(k[1], y).add_scaled(k[2], z),
        ])
    }

    /// `self + [v×] right`.
    #[inline(always)]
    pub(crate) fn add_cross(
        self,
        BroadcastVector([u, v, w]): &BroadcastVector<S>,
        Self([x, y, z]): Self,
    ) -> Self {
        let [a, b, c] = self.0;
        Self([
            a.add_product_of(*v, z).sub_product_of(*w, y),
            b.add_product_of(*w, x).sub_product_of(*u, z),
            c.add_product_of(*u, y).sub_product_of(*v, x),
        ])
    }

    /// `self + left right`.
    #[inline(always)]
    pub(crate) fn add_broadcast_product(
        self,
        BroadcastMatrix([i, j, k]): &BroadcastMatrix<S>,
        Self([x, y, z]): Self,
    ) -> Self {
        let [a, b, c] = self.0;
        Self([
            a.add_product_of(i[0], x).add_product_of(i[1], y).add_product_of(i[2], z),
            b.add_product_of(j[0], x).add_product_of(j[1], y).add_product_of(j[2], z),
            c.add_product_of(k[0], x).add_product_of(k[1], y).add_product_of(k[2], z),
        ])
    }

    /// `self + factor * other`.
    #[inline(always)]
    pub(crate) fn add_broadcast_scaled(self, factor: S::F64x4, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([
            a.add_product_of(factor, x),
            b.add_product_of(factor, y),
            c.add_product_of(factor, z),
        ])
    }

    /// `self - factor * other`.
    #[inline(always)]
    pub(crate) fn sub_broadcast_scaled(self, factor: S::F64x4, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([
            a.sub_product_of(factor, x),
            b.sub_product_of(factor, y),
            c.sub_product_of(factor, z),
        ])
    }

    /// `self + leftᵀ right`.
    #[inline(always)]
    pub(crate) fn add_transposed_product(
        self,
        Block3([i, j, k]): &Block3,
        Self([x, y, z]): Self,
    ) -> Self {
        let [a, b, c] = self.0;
        Self([
            a.add_scaled(i[0], x).add_scaled(j[0], y).add_scaled(k[0], z),
            b.add_scaled(i[1], x).add_scaled(j[1], y).add_scaled(k[1], z),
            c.add_scaled(i[2], x).add_scaled(j[2], y).add_scaled(k[2], z),
        ])
    }

    /// `row + leftᵀ self`, where `left` is a column.
    #[inline(always)]
    pub(crate) fn add_row_product(self, row: S::F64x4, left: &Vector3<f64>) -> S::F64x4 {
        let [a, b, c] = self.0;
        row.add_scaled(left.x, a).add_scaled(left.y, b).add_scaled(left.z, c)
    }

    /// `row` plus the sum of the rows of `self` times those of `other`, number by number: the
    /// diagonal of `selfᵀ other`.
    #[inline(always)]
    pub(crate) fn add_inner_products(self, row: S::F64x4, other: Self) -> S::F64x4 {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        row.add_product_of(a, x).add_product_of(b, y).add_product_of(c, z)
    }

    /// `self` plus the rows of `other` times `row`, number by number: what adds up to `other rowᵀ`.
    #[inline(always)]
    pub(crate) fn add_outer_products(self, Block3([i, j, k]): &Block3, row: S::F64x4) -> Self {
        let [a, b, c] = self.0;
        Self([
            a.add_product_of(S::F64x4::load(i), row),
            b.add_product_of(S::F64x4::load(j), row),
            c.add_product_of(S::F64x4::load(k), row),
        ])
    }

    /// The sum of the numbers of each row.
    #[inline(always)]
    pub(crate) fn sums(self) -> S::F64x4 {
        let [a, b, c] = self.transpose().0;
        a.add_scaled(1.0, b).add_scaled(1.0, c)
    }
}

#[inline(always)]
pub(crate) fn load<S: Simd>(rows: &Block3) -> BlockReg<S> {
    BlockReg::from(rows)
}

/// The block (i, j), above or below the diagonal.
#[inline(always)]
pub(crate) fn load_at<S: Simd>(p: &Upper, i: usize, j: usize) -> BlockReg<S> {
    if i <= j { load(&p[at(i, j)]) } else { load(&p[at(j, i)]).transpose() }
}
