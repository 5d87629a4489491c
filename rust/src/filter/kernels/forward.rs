//! The hot kernel: the prediction of the covariance and its reduction by an observation.
//!
//! Everything here is inlined by force into the two functions that [`crate::math::simd`]
//! compiles for each instruction set; a call that is not inlined would run on the wrong one.
//!
//! The prediction applies the five factors of [`crate::filter::transition`] and adds the process noise in
//! one pass.  An observation of the block b costs the product `V = L⁻¹ P_b` and the reduction `P -
//! Vᵀ V`.
//!
//! A vector that is loaded soon after a part of it is stored waits for the store; so whole vectors
//! are stored, and others are assembled in registers.

use nalgebra::{Matrix3, Vector3};

use crate::filter::error_state::{BLOCKS, Block};
use crate::filter::process_noise::Noise;
use crate::math::block_matrix::{
    Block3, BlockReg, BroadcastMatrix, BroadcastVector, Upper, at, load, load_at,
};
use crate::math::simd::{F64x4, Simd};

/// One transition, and the variance that each block gains in it.
pub(crate) struct Prediction<'a> {
    /// Half the interval, s: velocity to position, applied twice.
    pub(crate) half: f64,
    /// The vector s of [s×]: tilt to velocity.
    pub(crate) tilt: Vector3<f64>,
    /// Bias to velocity and to attitude.
    pub(crate) bias: &'a Matrix3<f64>,
    pub(crate) noise: &'a Noise,
}

/// Indices of the blocks: position, velocity, attitude, gyroscope bias and accelerometer bias.
const P: usize = Block::Position.index();
const V: usize = Block::Velocity.index();
const A: usize = Block::Attitude.index();
const W: usize = Block::GyroBias.index();
const F: usize = Block::AccelBias.index();

/// P becomes F P Fᵀ + Q.
///
/// Four factors act on position and velocity, and the last one on the attitude.  The first four add
/// rows that they do not change, so they are applied together, one column of blocks after the other.
/// A block on the diagonal gains `G + Gᵀ`, where G follows from the mean of another block before and
/// after the factor.
#[inline(always)]
pub(crate) fn predict<S: Simd>(_: S, p: &mut Upper, prediction: &Prediction<'_>) {
    let Prediction { half, tilt, bias, noise } = prediction;
    let factors = Factors::<S>::new(*half, tilt, bias);
    let accel_bias = factors.apply_column(p, F);
    let gain = factors.gain_from_accel_bias(&accel_bias);
    add_noise::<S>(p, F, noise.accel_bias);
    let p = compiler_barrier(p);
    let attitude = factors.apply_column(p, A);
    let gain = factors.add_gain_from_attitude(&gain, &attitude);
    let p = compiler_barrier(p);
    factors.apply_column(p, W);
    factors.apply_own(p, &gain, noise);
    let p = compiler_barrier(p);
    factors.apply_attitude_row(p, noise);
    add_noise::<S>(p, W, noise.gyro_bias);
    let p = compiler_barrier(p);
    factors.apply_attitude_column(p);
}

/// Makes the compiler load the blocks again: it would spill them to the stack, and extract single
/// numbers from vectors that memory broadcasts at no cost.
#[inline(always)]
fn compiler_barrier(p: &mut Upper) -> &mut Upper {
    std::hint::black_box(p)
}

#[inline(always)]
fn add_noise<S: Simd>(p: &mut Upper, block: usize, variance: f64) {
    let own = &mut p[at(block, block)];
    load::<S>(own).add_to_diagonal(variance).store(own);
}

/// The numbers of a transition, each broadcast to a vector.
struct Factors<S: Simd> {
    half: S::F64x4,
    tilt: BroadcastVector<S>,
    bias: BroadcastMatrix<S>,
}

/// The blocks of position and velocity in a column.
struct Rows<S: Simd> {
    position: BlockReg<S>,
    velocity: BlockReg<S>,
}

impl<S: Simd> Factors<S> {
    #[inline(always)]
    fn new(half: f64, tilt: &Vector3<f64>, bias: &Matrix3<f64>) -> Self {
        Self {
            half: S::F64x4::splat(half),
            tilt: BroadcastVector::new(tilt),
            bias: BroadcastMatrix::new(bias),
        }
    }

    /// Gain of the velocity's rows from those of attitude and accelerometer bias.
    #[inline(always)]
    fn gain(&self, attitude: BlockReg<S>, accel_bias: BlockReg<S>) -> BlockReg<S> {
        self.tilt.cross(attitude).add_broadcast_product(&self.bias, accel_bias)
    }

    /// The position's rows, given the velocity's before and after.
    #[inline(always)]
    fn integrated(
        &self,
        position: BlockReg<S>,
        before: BlockReg<S>,
        after: BlockReg<S>,
    ) -> BlockReg<S> {
        position.add_broadcast_scaled(self.half, before).add_broadcast_scaled(self.half, after)
    }

    /// Applies the factors of position and velocity in the column of another block.  Returns the
    /// values during the change of the velocity: the mean of the velocity before and after, and the
    /// position between its two halves.
    #[inline(always)]
    fn apply_column(&self, p: &mut Upper, column: usize) -> Rows<S> {
        let gain = self.gain(load_at(p, A, column), load_at(p, F, column));
        let before = load_at::<S>(p, V, column);
        let after = before.add_scaled(1.0, gain);
        let position = load_at::<S>(p, P, column).add_broadcast_scaled(self.half, before);
        after.store(&mut p[at(V, column)]);
        position.add_broadcast_scaled(self.half, after).store(&mut p[at(P, column)]);
        Rows { position, velocity: before.add_broadcast_scaled(S::F64x4::splat(0.5), gain) }
    }

    /// Gain of the velocity's row in the columns of position and velocity from the accelerometer
    /// bias.
    #[inline(always)]
    fn gain_from_accel_bias(&self, column: &Rows<S>) -> Rows<S> {
        Rows {
            position: self.bias.mul(column.position.transpose()),
            velocity: self.bias.mul(column.velocity.transpose()),
        }
    }

    /// As above, with the gain from the attitude added.
    #[inline(always)]
    fn add_gain_from_attitude(&self, gain: &Rows<S>, column: &Rows<S>) -> Rows<S> {
        Rows {
            position: gain.position.add_cross(&self.tilt, column.position.transpose()),
            velocity: gain.velocity.add_cross(&self.tilt, column.velocity.transpose()),
        }
    }

    /// Applies the factors in the columns of position and velocity, given the gain of the velocity's
    /// row from all others.
    #[inline(always)]
    fn apply_own(&self, p: &mut Upper, gain: &Rows<S>, noise: &Noise) {
        let own = gain.velocity.add_transpose();
        let before = load_at::<S>(p, V, V);
        let after = before.add_scaled(1.0, own);
        after.add_to_diagonal(noise.velocity).store(&mut p[at(V, V)]);

        let cross = load_at::<S>(p, P, V);
        let moved =
            self.integrated(cross.add_scaled(1.0, gain.position.transpose()), before, after);
        moved.add_to_diagonal(noise.position_velocity).store(&mut p[at(P, V)]);
        self.apply_position(p, cross.add_scaled(1.0, moved), own, noise.position);
    }

    /// Applies the factors of the position in its own column.
    ///
    /// Each half adds `half (C + Cᵀ) + half² D`, where C is the block of position and velocity
    /// before it, and D the velocity's own.  Together they add `half (S + Sᵀ) - half² G`, where S
    /// is C before all factors plus C after them, the `crosses`, and G what D gains between the
    /// halves.
    #[inline(always)]
    fn apply_position(
        &self,
        p: &mut Upper,
        crosses: BlockReg<S>,
        velocity_gain: BlockReg<S>,
        variance: f64,
    ) {
        let moved = load_at::<S>(p, P, P).add_broadcast_scaled(self.half, crosses.add_transpose());
        let moved = moved.sub_broadcast_scaled(self.half.mul(self.half), velocity_gain);
        moved.add_to_diagonal(variance).store(&mut p[at(P, P)]);
    }

    /// Applies the factor of the attitude in its own row.
    #[inline(always)]
    fn apply_attitude_row(&self, p: &mut Upper, noise: &Noise) {
        let gain = self.bias.mul(load_at(p, W, W));
        let before = load_at::<S>(p, A, W);
        before.add_scaled(1.0, gain).store(&mut p[at(A, W)]);
        let own =
            self.bias.mul(before.add_broadcast_scaled(S::F64x4::splat(0.5), gain).transpose());
        load_at::<S>(p, A, A)
            .add_symmetrized(own)
            .add_to_diagonal(noise.attitude)
            .store(&mut p[at(A, A)]);
        load_at::<S>(p, A, F)
            .add_broadcast_product(&self.bias, load_at(p, W, F))
            .store(&mut p[at(A, F)]);
    }

    /// Applies the factor of the attitude in the rows of velocity and position: products from the
    /// right, whose left numbers memory broadcasts.
    #[inline(always)]
    fn apply_attitude_column(&self, p: &mut Upper) {
        let bias = self.bias.transposed();
        for row in [V, P] {
            load_at::<S>(p, row, A).add_product(&p[at(row, W)], bias).store(&mut p[at(row, A)]);
        }
    }
}

/// Four columns of error states, block by block.
pub(crate) type Columns = [Block3; BLOCKS];

/// X becomes F X.
#[inline(always)]
pub(crate) fn move_columns<S: Simd>(
    _: S,
    x: &mut Columns,
    half: f64,
    tilt: &Vector3<f64>,
    bias: &Matrix3<f64>,
) {
    let factors = Factors::<S>::new(half, tilt, bias);
    let [position, velocity, attitude, gyro_bias, accel_bias] = x;
    let before = load(velocity);
    let after = before.add_scaled(1.0, factors.gain(load(attitude), load(accel_bias)));
    factors.integrated(load(position), before, after).store(position);
    after.store(velocity);
    load(attitude).add_broadcast_product(&factors.bias, load(gyro_bias)).store(attitude);
}

/// X becomes (I - K H) X, which is `X - Vᵀ L⁻¹ H X`, where the whitener is the lower triangle L⁻¹
/// and the block b is observed.
#[inline(always)]
pub(crate) fn reduce_columns<S: Simd>(
    _: S,
    x: &mut Columns,
    b: usize,
    whitener: &Matrix3<f64>,
    WhitenedGain(gain): &WhitenedGain,
) {
    let lost = BlockReg::<S>::zero().add_scaled(-1.0, load(&x[b]).lower_mul(&whitener.into()));
    for (block, gain) in x.iter_mut().zip(gain) {
        load(block).add_transposed_product(gain, lost).store(block);
    }
}

/// Adds `m` times the states of the block `source` to those of `target`, another block.
#[inline(always)]
pub(crate) fn shear<S: Simd>(_: S, p: &mut Upper, target: usize, source: usize, m: &Matrix3<f64>) {
    let m = &m.into();
    let half = load_at::<S>(p, target, source)
        .add_product(&load::<S>(m).half(), load(&p[at(source, source)]));
    let own = BlockReg::<S>::zero().add_product(&half.to_block(), load(m).transpose());
    for k in 0..BLOCKS {
        let gain = BlockReg::<S>::zero().add_product(m, load_at(p, source, k));
        if k > target {
            let block = &mut p[at(target, k)];
            load(block).add_scaled(1.0, gain).store(block);
        } else if k < target {
            let block = &mut p[at(k, target)];
            load(block).add_scaled(1.0, gain.transpose()).store(block);
        }
    }
    let block = &mut p[at(target, target)];
    load(block).add_symmetrized(own).store(block);
}

/// What an observation of one block changes: `V = L⁻¹ P_b`, a row of blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct WhitenedGain(pub(crate) [Block3; BLOCKS]);

impl WhitenedGain {
    /// Adds Wᵀ λ to `white`.
    #[inline]
    pub(crate) fn add_gain_transposed(
        &self,
        costate: &[Vector3<f64>; BLOCKS],
        white: &mut Vector3<f64>,
    ) {
        for (part, Block3(rows)) in costate.iter().zip(&self.0) {
            for (white, row) in white.iter_mut().zip(rows) {
                *white += row[0] * part.x + row[1] * part.y + row[2] * part.z;
            }
        }
    }
}

/// Errors block by block: three numbers and a zero.
pub(crate) type Errors = [[f64; 4]; BLOCKS];

/// P becomes P - Vᵀ V, where the whitener is the lower triangle L⁻¹ and b the observed block; V is
/// left in `gain`, and the errors Vᵀ y estimated from the whitened innovation y in `errors`.
#[inline(always)]
pub(crate) fn reduce<S: Simd>(
    _: S,
    p: &mut Upper,
    b: usize,
    whitener: &Matrix3<f64>,
    y: &Vector3<f64>,
    WhitenedGain(gain): &mut WhitenedGain,
    errors: &mut Errors,
) {
    let whitener = &whitener.into();
    for (k, (block, errors)) in gain.iter_mut().zip(errors).enumerate() {
        let v = load_at::<S>(p, b, k).lower_mul(whitener);
        v.store(block);
        v.transposed_mul(y).store(errors);
    }
    let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = &mut p.0;
    let [gp, gv, ga, gw, gf] = &*gain;
    let [rp, rv, ra, rw, rf] = [load::<S>(gp), load(gv), load(ga), load(gw), load(gf)];
    reduce_row(gp, [rp, rv], [pp, pv]);
    reduce_row(gv, [rv], [vv]);
    reduce_row(gp, [ra, rw, rf], [pa, pw, pf]);
    reduce_row(gv, [ra, rw, rf], [va, vw, vf]);
    reduce_row(ga, [ra, rw, rf], [aa, aw, af]);
    reduce_row(gw, [rw, rf], [ww, wf]);
    reduce_row(gf, [rf], [ff]);
}

/// Subtracts the products `leftᵀ right` from blocks side by side.  They are at most three, so that
/// `right` stays in registers, and each number of `left` is broadcast once for all of them.
#[inline(always)]
fn reduce_row<S: Simd, const N: usize>(
    left: &Block3,
    right: [BlockReg<S>; N],
    mut blocks: [&mut Block3; N],
) {
    for k in 0..3 {
        let [x, y, z] = left.broadcast_column::<S>(k);
        for (BlockReg([a, b, c]), block) in right.iter().zip(&mut blocks) {
            let row = &mut block.0[k];
            S::F64x4::load(row)
                .sub_product_of(x, *a)
                .sub_product_of(y, *b)
                .sub_product_of(z, *c)
                .store(row);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::filter::error_state::Block::{AccelBias, Attitude, GyroBias, Position, Velocity};
    use crate::filter::kernels::dense::{
        BLOCK, Dense, difference, matrices, positive, shear, upper,
    };
    use crate::math::rotation::cross_matrix;
    use crate::math::simd::{Baseline, on_best_instruction_set};

    fn assert_diagonal_blocks_are_symmetric(upper: &Upper) {
        for i in 0..BLOCKS {
            assert_eq!(upper[at(i, i)], upper[at(i, i)].transpose());
        }
    }

    proptest! {
        #[test]
        fn prediction_is_the_dense_congruence_on_any_instruction_set(
            dense in positive(),
            half in 0.001..0.5,
            tilt in [-2.0..2.0, -2.0..2.0, -2.0..2.0],
            bias in matrices(),
            variances in [0.0..1.0, 0.0..1.0, 0.0..1.0, 0.0..1.0, 0.0..1.0],
            position_velocity in -1.0..1.0,
        ) {
            let tilt = Vector3::from(tilt);
            let [position, velocity, attitude, gyro_bias, accel_bias] = variances;
            let noise = Noise { position, velocity, attitude, gyro_bias, accel_bias, position_velocity };
            let prediction = Prediction { half, tilt, bias: &bias, noise: &noise };
            let (mut best, mut baseline) = (upper(&dense), upper(&dense));
            predict(Baseline, &mut baseline, &prediction);
            on_best_instruction_set!(simd => predict(simd, &mut best, &prediction));
            let half_way = shear(Position, Velocity, &Matrix3::from_diagonal_element(half));
            let f = shear(Attitude, GyroBias, &bias)
                * half_way
                * shear(Velocity, AccelBias, &bias)
                * shear(Velocity, Attitude, &cross_matrix(&tilt))
                * half_way;
            let q = Dense::from_fn(|i, j| match (i / BLOCK, j / BLOCK) {
                (0, 1) | (1, 0) if i % BLOCK == j % BLOCK => position_velocity,
                (block, _) if i == j => variances[block],
                _ => 0.0,
            });
            let expected = f * dense * f.transpose() + q;
            for moved in [best, baseline] {
                prop_assert!(difference(&moved, &expected) < 1e-11);
                assert_diagonal_blocks_are_symmetric(&moved);
            }
        }

        #[test]
        fn the_reduction_is_the_dense_product_on_any_instruction_set(
            dense in positive(),
            b in 0..BLOCKS,
            whitener in matrices(),
        ) {
            let whitener = 0.3 * whitener.lower_triangle();
            let (mut best, mut baseline) = (upper(&dense), upper(&dense));
            let (mut gain, mut errors) = (WhitenedGain::default(), Errors::default());
            let y = &Vector3::new(0.1, -0.2, 0.3);
            reduce(Baseline, &mut baseline, b, &whitener, y, &mut gain, &mut errors);
            on_best_instruction_set!(
                simd => reduce(simd, &mut best, b, &whitener, y, &mut gain, &mut errors)
            );
            let v = whitener * dense.fixed_rows::<BLOCK>(BLOCK * b);
            let expected = dense - v.transpose() * v;
            for reduced in [best, baseline] {
                prop_assert!(difference(&reduced, &expected) < 1e-11);
                assert_diagonal_blocks_are_symmetric(&reduced);
            }
            for (k, &[e0, e1, e2, zero]) in errors.iter().enumerate() {
                prop_assert!(
                    (Vector3::new(e0, e1, e2)
                        - v.fixed_columns::<BLOCK>(BLOCK * k).transpose() * y)
                        .norm()
                        < 1e-12
                );
                prop_assert!(zero.abs() < f64::MIN_POSITIVE);
            }
        }
    }
}
