//! The hot kernel: the prediction of the covariance and its reduction by an observation.
//!
//! Everything here is inlined by force into the two functions that [`crate::lanes`] compiles for
//! each kind of lanes; a call that is left over would run on the wrong instructions.
//!
//! The prediction applies the five shears of [`super::transition`] and adds the process noise in
//! one pass.  An observation of the block b costs the product `V = L⁻¹ P_b` and the reduction `P -
//! Vᵀ V`.
//!
//! A vector that is loaded soon after a part of it was stored must wait until the store is done; so
//! whole vectors are stored, and those of other numbers are put together in registers.

use nalgebra::{Matrix3, Vector3};

use crate::filter::error_state::{BLOCKS, Block};
use crate::filter::transition::Noise;
use crate::math::block_matrix::{
    Block3, BlockReg, BroadcastMatrix, BroadcastVector, Upper, at, load, load_at,
};
use crate::math::simd::{Lanes, Work, dispatch};

/// One transition, and the variance that each block gains in it.
pub(crate) struct Prediction<'a> {
    /// Half the interval: what a velocity turns into position, twice.
    pub(crate) half: f64,
    /// The vector s of [s×], what a tilt turns into velocity.
    pub(crate) tilt: Vector3<f64>,
    /// What a bias turns into velocity or attitude.
    pub(crate) bias: &'a Matrix3<f64>,
    pub(crate) noise: &'a Noise,
}

/// Where the blocks are: position, velocity, attitude, gyroscope bias and accelerometer bias.
const P: usize = Block::Position.index();
const V: usize = Block::Velocity.index();
const A: usize = Block::Attitude.index();
const W: usize = Block::GyroBias.index();
const F: usize = Block::AccelBias.index();

/// P becomes F P Fᵀ + Q.
///
/// Four shears move position and velocity, and the last one turns the attitude.  What moves gains
/// from rows that do not, so the four are applied together, one column of blocks after the other. A
/// block on the diagonal gains `G + Gᵀ`, where G is made of the mean of another block before and
/// after the shear.
#[inline(always)]
pub(crate) fn predict<L: Lanes>(p: &mut Upper, prediction: &Prediction<'_>) {
    let Prediction { half, tilt, bias, noise } = prediction;
    let shears = Shears::<L>::new(*half, tilt, bias);
    let accel_bias = shears.move_column(p, F);
    let gain = shears.gain_of_accel_bias(&accel_bias);
    add_noise::<L>(p, F, noise.accel_bias);
    let p = compiler_barrier(p);
    let attitude = shears.move_column(p, A);
    let gain = shears.plus_gain_of_attitude(&gain, &attitude);
    let p = compiler_barrier(p);
    shears.move_column(p, W);
    shears.move_own(p, &gain, noise);
    let p = compiler_barrier(p);
    shears.turn_row(p, noise);
    add_noise::<L>(p, W, noise.gyro_bias);
    let p = compiler_barrier(p);
    shears.turn_column(p);
}

/// Has the compiler forget what it knows of the blocks: it would save them on the stack until they
/// are used again, and take single numbers out of vectors that memory spreads at no cost.
#[inline(always)]
fn compiler_barrier(p: &mut Upper) -> &mut Upper {
    std::hint::black_box(p)
}

#[inline(always)]
fn add_noise<L: Lanes>(p: &mut Upper, block: usize, variance: f64) {
    let own = &mut p[at(block, block)];
    load::<L>(own).plus_diagonal(variance).store(own);
}

/// The numbers of a transition, each in all places of a vector.
struct Shears<L> {
    half: L,
    tilt: BroadcastVector<L>,
    bias: BroadcastMatrix<L>,
}

/// The blocks of position and velocity in a column.
struct Moving<L> {
    position: BlockReg<L>,
    velocity: BlockReg<L>,
}

impl<L: Lanes> Shears<L> {
    #[inline(always)]
    fn new(half: f64, tilt: &Vector3<f64>, bias: &Matrix3<f64>) -> Self {
        Self {
            half: L::splat(half),
            tilt: BroadcastVector::new(tilt),
            bias: BroadcastMatrix::new(bias),
        }
    }

    /// What the velocity's rows gain from those of attitude and accelerometer's bias.
    #[inline(always)]
    fn gain(&self, attitude: BlockReg<L>, accel_bias: BlockReg<L>) -> BlockReg<L> {
        self.tilt.cross(attitude).plus_spread_product(&self.bias, accel_bias)
    }

    /// The position's rows after the velocity's changed.
    #[inline(always)]
    fn led_on(
        &self,
        position: BlockReg<L>,
        before: BlockReg<L>,
        after: BlockReg<L>,
    ) -> BlockReg<L> {
        position.plus_scaled(self.half, before).plus_scaled(self.half, after)
    }

    /// Position and velocity move in the column of another block.  Returns what they are while the
    /// velocity gains: the mean of its own before and after, and the position between its two
    /// halves.
    #[inline(always)]
    fn move_column(&self, p: &mut Upper, column: usize) -> Moving<L> {
        let gain = self.gain(load_at(p, A, column), load_at(p, F, column));
        let before = load_at::<L>(p, V, column);
        let after = before.plus(1.0, gain);
        let position = load_at::<L>(p, P, column).plus_scaled(self.half, before);
        after.store(&mut p[at(V, column)]);
        position.plus_scaled(self.half, after).store(&mut p[at(P, column)]);
        Moving { position, velocity: before.plus_scaled(L::splat(0.5), gain) }
    }

    /// What the velocity's row gains in the columns of position and velocity from that of the
    /// accelerometer's bias.
    #[inline(always)]
    fn gain_of_accel_bias(&self, column: &Moving<L>) -> Moving<L> {
        Moving {
            position: self.bias.times(column.position.transpose()),
            velocity: self.bias.times(column.velocity.transpose()),
        }
    }

    /// The same from that of the attitude, too.
    #[inline(always)]
    fn plus_gain_of_attitude(&self, gain: &Moving<L>, column: &Moving<L>) -> Moving<L> {
        Moving {
            position: gain.position.plus_cross(&self.tilt, column.position.transpose()),
            velocity: gain.velocity.plus_cross(&self.tilt, column.velocity.transpose()),
        }
    }

    /// Position and velocity move in their own columns, where the velocity's row has this gain from
    /// all others.
    #[inline(always)]
    fn move_own(&self, p: &mut Upper, gain: &Moving<L>, noise: &Noise) {
        let own = gain.velocity.plus_transpose();
        let before = load_at::<L>(p, V, V);
        let after = before.plus(1.0, own);
        after.plus_diagonal(noise.velocity).store(&mut p[at(V, V)]);

        let cross = load_at::<L>(p, P, V);
        let moved = self.led_on(cross.plus(1.0, gain.position.transpose()), before, after);
        moved.plus_diagonal(noise.position_velocity).store(&mut p[at(P, V)]);
        self.move_position(p, cross.plus(1.0, moved), own, noise.position);
    }

    /// The position moves in its own column.
    ///
    /// Each half adds `half (C + Cᵀ) + half² D`, where C is the block of position and velocity
    /// before it, and D the velocity's own.  Together they add `half (S + Sᵀ) - half² G`, where S
    /// is C before all shears plus C after them, the `crosses`, and G what D gains between the
    /// halves.
    #[inline(always)]
    fn move_position(
        &self,
        p: &mut Upper,
        crosses: BlockReg<L>,
        velocity_gain: BlockReg<L>,
        variance: f64,
    ) {
        let moved = load_at::<L>(p, P, P).plus_scaled(self.half, crosses.plus_transpose());
        let moved = moved.minus_scaled(self.half.times(self.half), velocity_gain);
        moved.plus_diagonal(variance).store(&mut p[at(P, P)]);
    }

    /// The attitude turns in its own row.
    #[inline(always)]
    fn turn_row(&self, p: &mut Upper, noise: &Noise) {
        let gain = self.bias.times(load_at(p, W, W));
        let before = load_at::<L>(p, A, W);
        before.plus(1.0, gain).store(&mut p[at(A, W)]);
        let own = self.bias.times(before.plus_scaled(L::splat(0.5), gain).transpose());
        load_at::<L>(p, A, A)
            .add_symmetrized(own)
            .plus_diagonal(noise.attitude)
            .store(&mut p[at(A, A)]);
        load_at::<L>(p, A, F)
            .plus_spread_product(&self.bias, load_at(p, W, F))
            .store(&mut p[at(A, F)]);
    }

    /// The attitude turns in the rows of velocity and position: products from the right, whose left
    /// numbers memory spreads.
    #[inline(always)]
    fn turn_column(&self, p: &mut Upper) {
        let bias = self.bias.transposed();
        for row in [V, P] {
            load_at::<L>(p, row, A).plus_product(&p[at(row, W)], bias).store(&mut p[at(row, A)]);
        }
    }
}

/// Four columns of error states, block by block.
pub(crate) type Columns = [Block3; BLOCKS];

/// X becomes F X.
#[inline(always)]
pub(crate) fn move_columns<L: Lanes>(
    x: &mut Columns,
    half: f64,
    tilt: &Vector3<f64>,
    bias: &Matrix3<f64>,
) {
    let shears = Shears::<L>::new(half, tilt, bias);
    let [position, velocity, attitude, gyro_bias, accel_bias] = x;
    let before = load(velocity);
    let after = before.plus(1.0, shears.gain(load(attitude), load(accel_bias)));
    shears.led_on(load(position), before, after).store(position);
    after.store(velocity);
    load(attitude).plus_spread_product(&shears.bias, load(gyro_bias)).store(attitude);
}

/// X becomes (I - K H) X, which is `X - Vᵀ L⁻¹ H X`, where the whitener is the lower triangle L⁻¹
/// and the block b is observed.
#[inline(always)]
pub(crate) fn reduce_columns<L: Lanes>(
    x: &mut Columns,
    b: usize,
    whitener: &Matrix3<f64>,
    WhitenedGain(gain): &WhitenedGain,
) {
    let lost = BlockReg::<L>::zero().plus(-1.0, load(&x[b]).times_lower(&whitener.into()));
    for (block, gain) in x.iter_mut().zip(gain) {
        load(block).plus_transposed_product(gain, lost).store(block);
    }
}

/// The states of the block `target` gain `m` times those of `source`, another block.
#[inline]
pub(crate) fn shear(p: &mut Upper, target: usize, source: usize, m: &Matrix3<f64>) {
    dispatch(Shear { p, target, source, m: &m.into() });
}

struct Shear<'a> {
    p: &'a mut Upper,
    target: usize,
    source: usize,
    m: &'a Block3,
}

impl Work for Shear<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { p, target, source, m } = self;
        let half = load_at::<L>(p, target, source)
            .plus_product(&load::<L>(m).halved(), load(&p[at(source, source)]));
        let own = BlockReg::<L>::zero().plus_product(&half.stored(), load(m).transpose());
        for k in 0..BLOCKS {
            let gain = BlockReg::<L>::zero().plus_product(m, load_at(p, source, k));
            if k > target {
                let block = &mut p[at(target, k)];
                load(block).plus(1.0, gain).store(block);
            } else if k < target {
                let block = &mut p[at(k, target)];
                load(block).plus(1.0, gain.transpose()).store(block);
            }
        }
        let block = &mut p[at(target, target)];
        load(block).add_symmetrized(own).store(block);
    }
}

/// What an observation of one block changes: `V = L⁻¹ P_b`, a row of blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct WhitenedGain(pub(crate) [Block3; BLOCKS]);

impl WhitenedGain {
    /// Adds Wᵀ λ to `white`.
    #[inline]
    pub(crate) fn add_seen(&self, costate: &[Vector3<f64>; BLOCKS], white: &mut Vector3<f64>) {
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
/// left in `gain`, and the errors Vᵀ y that the whitened innovation y tells of in `errors`.
#[inline(always)]
pub(crate) fn reduce<L: Lanes>(
    p: &mut Upper,
    b: usize,
    whitener: &Matrix3<f64>,
    y: &Vector3<f64>,
    WhitenedGain(gain): &mut WhitenedGain,
    errors: &mut Errors,
) {
    let whitener = &whitener.into();
    for (k, (block, errors)) in gain.iter_mut().zip(errors).enumerate() {
        let v = load_at::<L>(p, b, k).times_lower(whitener);
        v.store(block);
        v.combined(y).store(errors);
    }
    let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = &mut p.0;
    let [gp, gv, ga, gw, gf] = &*gain;
    let [rp, rv, ra, rw, rf] = [load::<L>(gp), load(gv), load(ga), load(gw), load(gf)];
    reduce_row(gp, [rp, rv], [pp, pv]);
    reduce_row(gv, [rv], [vv]);
    reduce_row(gp, [ra, rw, rf], [pa, pw, pf]);
    reduce_row(gv, [ra, rw, rf], [va, vw, vf]);
    reduce_row(ga, [ra, rw, rf], [aa, aw, af]);
    reduce_row(gw, [rw, rf], [ww, wf]);
    reduce_row(gf, [rf], [ff]);
}

/// Blocks side by side lose the products `leftᵀ right`.  They are at most three: so many of `right`
/// stay in registers, and each number of `left` is spread over a vector once for all of them.
#[inline(always)]
fn reduce_row<L: Lanes, const N: usize>(
    left: &Block3,
    right: [BlockReg<L>; N],
    mut blocks: [&mut Block3; N],
) {
    for k in 0..3 {
        let [x, y, z] = left.spread_column::<L>(k);
        for (BlockReg([a, b, c]), block) in right.iter().zip(&mut blocks) {
            let row = &mut block.0[k];
            L::load(row).minus_times(x, *a).minus_times(y, *b).minus_times(z, *c).store(row);
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
    use crate::math::simd::Baseline;

    fn assert_diagonal_blocks_are_symmetric(upper: &Upper) {
        for i in 0..BLOCKS {
            assert_eq!(upper[at(i, i)], upper[at(i, i)].transpose());
        }
    }

    struct Predicting<'a> {
        p: &'a mut Upper,
        prediction: Prediction<'a>,
    }

    impl Work for Predicting<'_> {
        type Output = ();

        #[inline(always)]
        fn run<L: Lanes>(self) {
            predict::<L>(self.p, &self.prediction);
        }
    }

    struct Reduction<'a> {
        p: &'a mut Upper,
        b: usize,
        whitener: &'a Matrix3<f64>,
        y: &'a Vector3<f64>,
        gain: &'a mut WhitenedGain,
        errors: &'a mut Errors,
    }

    impl Work for Reduction<'_> {
        type Output = ();

        #[inline(always)]
        fn run<L: Lanes>(self) {
            let Self { p, b, whitener, y, gain, errors } = self;
            reduce::<L>(p, b, whitener, y, gain, errors);
        }
    }

    proptest! {
        #[test]
        fn the_prediction_is_the_dense_congruence_on_any_lanes(
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
            predict::<Baseline>(&mut baseline, &prediction);
            dispatch(Predicting { p: &mut best, prediction });
            let half_way = shear(Position, Velocity, &Matrix3::from_diagonal_element(half));
            let f = shear(Attitude, GyroBias, &bias)
                * half_way * shear(Velocity, AccelBias, &bias) * shear(Velocity, Attitude, &cross_matrix(&tilt)) * half_way;
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
        fn the_reduction_is_the_dense_product_on_any_lanes(dense in positive(), b in 0..BLOCKS, whitener in matrices()) {
            let whitener = 0.3 * whitener.lower_triangle();
            let (mut best, mut baseline) = (upper(&dense), upper(&dense));
            let (mut gain, mut errors) = (WhitenedGain::default(), Errors::default());
            let y = &Vector3::new(0.1, -0.2, 0.3);
            reduce::<Baseline>(&mut baseline, b, &whitener, y, &mut gain, &mut errors);
            dispatch(Reduction { p: &mut best, b, whitener: &whitener, y, gain: &mut gain, errors: &mut errors });
            let v = whitener * dense.fixed_rows::<BLOCK>(BLOCK * b);
            let expected = dense - v.transpose() * v;
            for reduced in [best, baseline] {
                prop_assert!(difference(&reduced, &expected) < 1e-11);
                assert_diagonal_blocks_are_symmetric(&reduced);
            }
            for (k, &[e0, e1, e2, zero]) in errors.iter().enumerate() {
                prop_assert!((Vector3::new(e0, e1, e2) - v.fixed_columns::<BLOCK>(BLOCK * k).transpose() * y).norm() < 1e-12);
                prop_assert!(zero.abs() < f64::MIN_POSITIVE);
            }
        }
    }
}
