//! Symmetric matrices of error states as 3x3 blocks, and the arithmetic of a block on the
//! processor's lanes.
//!
//! Each of the 15 blocks on and above the diagonal is three rows of four numbers, the last of which
//! is zero: a row is one vector of a processor with AVX.  All products of blocks are of one kind,
//! `C + A B`: numbers of A, read from memory, times rows of B.
//!
//! What works on loaded blocks is inlined by force into the functions that [`crate::lanes`]
//! compiles for each kind of lanes; a call that is left over would run on the wrong instructions.

use std::ops::{Index, IndexMut};

use nalgebra::{Matrix3, Vector3};

use crate::math::simd::Lanes;

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

    /// The numbers of a column, each in all places of the lanes.
    #[inline(always)]
    pub(crate) fn spread_column<L: Lanes>(&self, k: usize) -> [L; 3] {
        let [a, b, c] = &self.0;
        [L::splat(a[k]), L::splat(b[k]), L::splat(c[k])]
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

/// The numbers of a vector that many rows are multiplied by, each in all places of the lanes.
pub(crate) struct BroadcastVector<L>([L; 3]);

impl<L: Lanes> BroadcastVector<L> {
    #[inline(always)]
    pub(crate) fn new(v: &Vector3<f64>) -> Self {
        Self([L::splat(v.x), L::splat(v.y), L::splat(v.z)])
    }

    /// `[v×] right`.
    #[inline(always)]
    pub(crate) fn cross(&self, BlockReg([x, y, z]): BlockReg<L>) -> BlockReg<L> {
        let [u, v, w] = self.0;
        BlockReg([
            v.times(z).minus_times(w, y),
            w.times(x).minus_times(u, z),
            u.times(y).minus_times(v, x),
        ])
    }
}

/// As [`BroadcastVector`], of a matrix.
pub(crate) struct BroadcastMatrix<L>([[L; 3]; 3]);

impl<L: Lanes> BroadcastMatrix<L> {
    #[inline(always)]
    pub(crate) fn new(m: &Matrix3<f64>) -> Self {
        Self([
            [L::splat(m.m11), L::splat(m.m12), L::splat(m.m13)],
            [L::splat(m.m21), L::splat(m.m22), L::splat(m.m23)],
            [L::splat(m.m31), L::splat(m.m32), L::splat(m.m33)],
        ])
    }

    /// The rows of mᵀ.
    #[inline(always)]
    pub(crate) fn transposed(&self) -> BlockReg<L> {
        let [a, b, c] = self.0;
        BlockReg([
            L::diagonal(a[0], b[0], c[0]),
            L::diagonal(a[1], b[1], c[1]),
            L::diagonal(a[2], b[2], c[2]),
        ])
    }

    /// `m right`.
    #[inline(always)]
    pub(crate) fn times(&self, BlockReg([x, y, z]): BlockReg<L>) -> BlockReg<L> {
        let [a, b, c] = self.0;
        BlockReg([
            a[0].times(x).plus_times(a[1], y).plus_times(a[2], z),
            b[0].times(x).plus_times(b[1], y).plus_times(b[2], z),
            c[0].times(x).plus_times(c[1], y).plus_times(c[2], z),
        ])
    }
}

/// A 3x3 block that is being worked on.
#[derive(Clone, Copy)]
pub(crate) struct BlockReg<L>(pub(crate) [L; 3]);

impl<L: Lanes> BlockReg<L> {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self::from(&Block3::default())
    }

    #[inline(always)]
    pub(crate) fn from(Block3([a, b, c]): &Block3) -> Self {
        Self([L::load(a), L::load(b), L::load(c)])
    }

    #[inline(always)]
    pub(crate) fn store(self, rows: &mut Block3) {
        let Block3([a, b, c]) = rows;
        self.0[0].store(a);
        self.0[1].store(b);
        self.0[2].store(c);
    }

    #[inline(always)]
    pub(crate) fn stored(self) -> Block3 {
        let mut rows = Block3::default();
        self.store(&mut rows);
        rows
    }

    #[inline(always)]
    pub(crate) fn transpose(self) -> Self {
        Self(L::transpose(self.0))
    }

    /// `self + factor * other`.
    #[inline(always)]
    pub(crate) fn plus(self, factor: f64, other: Self) -> Self {
        self.plus_scaled(L::splat(factor), other)
    }

    #[inline(always)]
    pub(crate) fn halved(self) -> Block3 {
        Self::zero().plus(0.5, self).stored()
    }

    /// `selfᵀ y`.
    #[inline(always)]
    pub(crate) fn combined(self, y: &Vector3<f64>) -> L {
        let [a, b, c] = self.0;
        a.scaled(y.x).plus(y.y, b).plus(y.z, c)
    }

    /// `self + value I`.
    #[inline(always)]
    pub(crate) fn plus_diagonal(self, value: f64) -> Self {
        let [a, b, c] = self.0;
        let of = |x, y, z| L::of([x, y, z]);
        Self([
            a.plus(value, of(1.0, 0.0, 0.0)),
            b.plus(value, of(0.0, 1.0, 0.0)),
            c.plus(value, of(0.0, 0.0, 1.0)),
        ])
    }

    /// `self + (half + halfᵀ)`, in this order, which keeps a symmetric block symmetric to the bit.
    #[inline(always)]
    pub(crate) fn add_symmetrized(self, half: Self) -> Self {
        self.plus(1.0, half.plus_transpose())
    }

    /// `self + selfᵀ`, symmetric to the bit.
    #[inline(always)]
    pub(crate) fn plus_transpose(self) -> Self {
        self.plus(1.0, self.transpose())
    }

    /// `self + left right`.
    #[inline(always)]
    pub(crate) fn plus_product(self, Block3(left): &Block3, Self([x, y, z]): Self) -> Self {
        let [a, b, c] = self.0;
        let [i, j, k] = left;
        Self([
            a.plus(i[0], x).plus(i[1], y).plus(i[2], z),
            b.plus(j[0], x).plus(j[1], y).plus(j[2], z),
            c.plus(k[0], x).plus(k[1], y).plus(k[2], z),
        ])
    }

    /// `left self`, where all above the diagonal of `left` is zero.
    #[inline(always)]
    pub(crate) fn times_lower(self, Block3(left): &Block3) -> Self {
        let ([x, y, z], [i, j, k]) = (self.0, left);
        Self([
            x.scaled(i[0]),
            x.scaled(j[0]).plus(j[1], y),
            x.scaled(k[0]).plus(k[1], y).plus(k[2], z),
        ])
    }

    /// `self + [v×] right`.
    #[inline(always)]
    pub(crate) fn plus_cross(
        self,
        BroadcastVector([u, v, w]): &BroadcastVector<L>,
        Self([x, y, z]): Self,
    ) -> Self {
        let [a, b, c] = self.0;
        Self([
            a.plus_times(*v, z).minus_times(*w, y),
            b.plus_times(*w, x).minus_times(*u, z),
            c.plus_times(*u, y).minus_times(*v, x),
        ])
    }

    /// `self + left right`.
    #[inline(always)]
    pub(crate) fn plus_spread_product(
        self,
        BroadcastMatrix([i, j, k]): &BroadcastMatrix<L>,
        Self([x, y, z]): Self,
    ) -> Self {
        let [a, b, c] = self.0;
        Self([
            a.plus_times(i[0], x).plus_times(i[1], y).plus_times(i[2], z),
            b.plus_times(j[0], x).plus_times(j[1], y).plus_times(j[2], z),
            c.plus_times(k[0], x).plus_times(k[1], y).plus_times(k[2], z),
        ])
    }

    /// `self + factor * other`.
    #[inline(always)]
    pub(crate) fn plus_scaled(self, factor: L, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a.plus_times(factor, x), b.plus_times(factor, y), c.plus_times(factor, z)])
    }

    /// `self - factor * other`.
    #[inline(always)]
    pub(crate) fn minus_scaled(self, factor: L, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a.minus_times(factor, x), b.minus_times(factor, y), c.minus_times(factor, z)])
    }

    /// `self + leftᵀ right`.
    #[inline(always)]
    pub(crate) fn plus_transposed_product(
        self,
        Block3([i, j, k]): &Block3,
        Self([x, y, z]): Self,
    ) -> Self {
        let [a, b, c] = self.0;
        Self([
            a.plus(i[0], x).plus(j[0], y).plus(k[0], z),
            b.plus(i[1], x).plus(j[1], y).plus(k[1], z),
            c.plus(i[2], x).plus(j[2], y).plus(k[2], z),
        ])
    }

    /// `row + leftᵀ self`, where `left` is a column.
    #[inline(always)]
    pub(crate) fn plus_row_product(self, row: L, left: &Vector3<f64>) -> L {
        let [a, b, c] = self.0;
        row.plus(left.x, a).plus(left.y, b).plus(left.z, c)
    }

    /// `row` plus the sum of the rows of `self` times those of `other`, number by number: the
    /// diagonal of `selfᵀ other`.
    #[inline(always)]
    pub(crate) fn plus_inner_products(self, row: L, other: Self) -> L {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        row.plus_times(a, x).plus_times(b, y).plus_times(c, z)
    }

    /// `self` plus the rows of `other` times `row`, number by number: what adds up to `other rowᵀ`.
    #[inline(always)]
    pub(crate) fn plus_rows_times(self, Block3([i, j, k]): &Block3, row: L) -> Self {
        let [a, b, c] = self.0;
        Self([
            a.plus_times(L::load(i), row),
            b.plus_times(L::load(j), row),
            c.plus_times(L::load(k), row),
        ])
    }

    /// The sum of the numbers of each row.
    #[inline(always)]
    pub(crate) fn sums(self) -> L {
        let [a, b, c] = self.transpose().0;
        a.plus(1.0, b).plus(1.0, c)
    }
}

#[inline(always)]
pub(crate) fn load<L: Lanes>(rows: &Block3) -> BlockReg<L> {
    BlockReg::from(rows)
}

/// The block (i, j), above or below the diagonal.
#[inline(always)]
pub(crate) fn load_at<L: Lanes>(p: &Upper, i: usize, j: usize) -> BlockReg<L> {
    if i <= j { load(&p[at(i, j)]) } else { load(&p[at(j, i)]).transpose() }
}
