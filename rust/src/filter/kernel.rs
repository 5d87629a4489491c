//! The hot kernel: the prediction of the covariance and its reduction by an observation.
//!
//! Everything here is inlined by force into the two functions that [`super::lanes`] compiles for each kind of lanes; a call that is left over would run on the wrong instructions.
//!
//! The prediction applies the five shears of [`super::transition`] and adds the process noise in one pass.  An observation of the block b costs the product `V = L⁻¹ P_b` and the reduction
//! `P - Vᵀ V`.
//!
//! A vector that is loaded soon after a part of it was stored must wait until the store is done; so whole vectors are stored, and those of other numbers are put together in registers.

use nalgebra::{Matrix3, Vector3};

use super::blocks::{Loaded, Rows, Upper, at, load, load_at};
use super::lanes::{Lanes, Work, dispatch};
use super::states::BLOCKS;
use super::transition::Noise;

/// The matrix [v×]ᵀ.
#[inline(always)]
fn cross_transposed<L: Lanes>(v: &Vector3<f64>) -> Loaded<L> {
    Loaded([L::of([0.0, v.z, -v.y]), L::of([-v.z, 0.0, v.x]), L::of([v.y, -v.x, 0.0])])
}

/// One transition, and the variance that each block gains in it.
pub(super) struct Prediction<'a> {
    /// Half the interval: what a velocity turns into position, twice.
    pub(super) half: f64,
    /// The vector s of [s×], what a tilt turns into velocity.
    pub(super) tilt: Vector3<f64>,
    /// What a bias turns into velocity or attitude.
    pub(super) bias: &'a Matrix3<f64>,
    pub(super) noise: &'a Noise,
}

/// P becomes F P Fᵀ + Q.
#[inline]
pub(super) fn predict(p: &mut Upper, prediction: &Prediction<'_>) {
    dispatch((p, prediction));
}

impl Work for (&mut Upper, &Prediction<'_>) {
    /// Letters are blocks: position, velocity, attitude, gyroscope bias and accelerometer bias are `p v a w f`.
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (Upper(p), &Prediction { half, tilt, bias, noise }) = self;
        let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = p;
        let tilt_transposed = cross_transposed::<L>(&tilt);
        let bias_transposed = Loaded::<L>(bias.data.0.map(L::of));
        let (tilt, bias) = (&tilt, &Rows::from(bias));

        load::<L>(pa).plus(half, load(va)).store(pa);
        load::<L>(pf).plus(half, load(vf)).store(pf);
        let first = load::<L>(pv).plus(0.5 * half, load(vv));
        let between = load::<L>(pv).plus(half, load(vv));
        let between = between.plus_product(pa, tilt_transposed).plus_product(pf, bias_transposed);

        let to_a = Loaded::<L>::zero().plus_cross(tilt, load(aa)).plus_product(bias, load(af).transpose());
        let to_f = Loaded::<L>::zero().plus_cross(tilt, load(af)).plus_product(bias, load(ff));
        let own = Loaded::<L>::zero()
            .plus_product(&load::<L>(va).plus(0.5, to_a).stored(), tilt_transposed)
            .plus_product(&load::<L>(vf).plus(0.5, to_f).stored(), bias_transposed);
        let sheared = load::<L>(vv).plus_both(own);
        let second = between.plus(0.5 * half, sheared);
        let own = Loaded::<L>::zero().plus(half, first).plus(half, second);
        load::<L>(pp).plus_both(own).plus_diagonal(noise.position).store(pp);
        between.plus(half, sheared).store(pv);
        sheared.plus_diagonal(noise.velocity).store(vv);

        let gained = load::<L>(vf).plus(1.0, to_f);
        gained.store(vf);
        load::<L>(pf).plus(half, gained).store(pf);
        let before = load::<L>(vw);
        let gained = before.plus_cross(tilt, load(aw)).plus_product(bias, load(wf).transpose());
        gained.store(vw);
        load::<L>(pw).plus(half, before).plus(half, gained).store(pw);

        let va_gained = load::<L>(va).plus(1.0, to_a);
        load::<L>(pa).plus(half, va_gained).plus_product(pw, bias_transposed).store(pa);
        va_gained.plus_product(vw, bias_transposed).store(va);
        let to_w = Loaded::<L>::zero().plus_product(bias, load(ww));
        let own = Loaded::<L>::zero().plus_product(&load::<L>(aw).plus(0.5, to_w).stored(), bias_transposed);
        load::<L>(aa).plus_both(own).plus_diagonal(noise.attitude).store(aa);
        load::<L>(aw).plus(1.0, to_w).store(aw);
        load::<L>(af).plus_product(bias, load(wf)).store(af);
        load::<L>(ww).plus_diagonal(noise.gyro_bias).store(ww);
        load::<L>(ff).plus_diagonal(noise.accel_bias).store(ff);
    }
}

/// The states of the block `target` gain `m` times those of `source`, another block.
#[inline]
pub(super) fn shear(p: &mut Upper, target: usize, source: usize, m: &Matrix3<f64>) {
    dispatch(Shear { p, target, source, m: &m.into() });
}

struct Shear<'a> {
    p: &'a mut Upper,
    target: usize,
    source: usize,
    m: &'a Rows,
}

impl Work for Shear<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { p, target, source, m } = self;
        let half = load_at::<L>(p, target, source).plus_product(&load::<L>(m).halved(), load(&p[at(source, source)]));
        let own = Loaded::<L>::zero().plus_product(&half.stored(), load(m).transpose());
        for k in 0..BLOCKS {
            let gain = Loaded::<L>::zero().plus_product(m, load_at(p, source, k));
            if k > target {
                let block = &mut p[at(target, k)];
                load(block).plus(1.0, gain).store(block);
            } else if k < target {
                let block = &mut p[at(k, target)];
                load(block).plus(1.0, gain.transpose()).store(block);
            }
        }
        let block = &mut p[at(target, target)];
        load(block).plus_both(own).store(block);
    }
}

/// What an observation of one block changes: `V = L⁻¹ P_b`, a row of blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct WhiteGain(pub(super) [Rows; BLOCKS]);

impl WhiteGain {
    /// A block of Vᵀ, the white gain W of the observation.
    pub(super) fn block(&self, index: usize) -> Matrix3<f64> {
        Matrix3::from(&self.0[index].transpose())
    }

    /// Adds Wᵀ λ to `white`.
    #[inline]
    pub(super) fn add_seen(&self, costate: &[Vector3<f64>; BLOCKS], white: &mut Vector3<f64>) {
        for (part, Rows(rows)) in costate.iter().zip(&self.0) {
            for (white, row) in white.iter_mut().zip(rows) {
                *white += row[0] * part.x + row[1] * part.y + row[2] * part.z;
            }
        }
    }

    /// Vᵀ y: the errors that a whitened innovation tells of.
    pub(super) fn errors(&self, y: &Vector3<f64>) -> [Vector3<f64>; BLOCKS] {
        std::array::from_fn(|k| self.block(k) * y)
    }
}

/// Errors block by block: three numbers and a zero.
pub(super) type Errors = [[f64; 4]; BLOCKS];

/// P becomes P - Vᵀ V, where the whitener is the lower triangle L⁻¹ and b the observed block; V is left in `gain`, and the errors Vᵀ y that the whitened innovation y tells of in `errors`.
#[inline]
pub(super) fn reduce(
    p: &mut Upper,
    b: usize,
    whitener: &Matrix3<f64>,
    y: &Vector3<f64>,
    gain: &mut WhiteGain,
    errors: &mut Errors,
) {
    dispatch(Reduction { p, b, whitener: &whitener.into(), y, gain, errors });
}

struct Reduction<'a> {
    p: &'a mut Upper,
    b: usize,
    whitener: &'a Rows,
    y: &'a Vector3<f64>,
    gain: &'a mut WhiteGain,
    errors: &'a mut Errors,
}

impl Work for Reduction<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { p, b, whitener, y, gain: WhiteGain(gain), errors } = self;
        for (k, (block, errors)) in gain.iter_mut().zip(errors).enumerate() {
            let v = load_at::<L>(p, b, k).times_lower(whitener);
            v.store(block);
            v.combined(y).store(errors);
        }
        let mut upper = p.0.iter_mut();
        for (i, left) in gain.iter().enumerate() {
            for (right, block) in gain[i..].iter().zip(&mut upper) {
                load::<L>(block).minus_transposed_product(left, load(right)).store(block);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::filter::blocks::dense::{BLOCK, Dense, difference, matrices, positive, shear, upper};
    use crate::filter::lanes::Baseline;
    use crate::filter::states::Block::{AccelBias, Attitude, GyroBias, Position, Velocity};
    use crate::rotation::cross_matrix;

    fn assert_diagonal_blocks_are_symmetric(upper: &Upper) {
        for i in 0..BLOCKS {
            assert_eq!(upper[at(i, i)], upper[at(i, i)].transpose());
        }
    }

    proptest! {
        #[test]
        fn the_prediction_is_the_dense_congruence_on_any_lanes(
            dense in positive(),
            half in 0.001..0.5,
            tilt in [-2.0..2.0, -2.0..2.0, -2.0..2.0],
            bias in matrices(),
            [position_noise, velocity, attitude, gyro_bias, accel_bias] in [0.0..1.0, 0.0..1.0, 0.0..1.0, 0.0..1.0, 0.0..1.0],
        ) {
            let tilt = Vector3::from(tilt);
            let noise = Noise { position: position_noise, velocity, attitude, gyro_bias, accel_bias };
            let prediction = Prediction { half, tilt, bias: &bias, noise: &noise };
            let (mut best, mut baseline) = (upper(&dense), upper(&dense));
            predict(&mut best, &prediction);
            (&mut baseline, &prediction).run::<Baseline>();
            let position = shear(Position, Velocity, &Matrix3::from_diagonal_element(half));
            let f = shear(Attitude, GyroBias, &bias)
                * position * shear(Velocity, AccelBias, &bias) * shear(Velocity, Attitude, &cross_matrix(&tilt)) * position;
            let variances = [position_noise, velocity, attitude, gyro_bias, accel_bias];
            let q = Dense::from_fn(|i, j| if i == j { variances[i / BLOCK] } else { 0.0 });
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
            let (mut gain, mut errors) = (WhiteGain::default(), Errors::default());
            let y = &Vector3::new(0.1, -0.2, 0.3);
            let rows = Rows::from(&whitener);
            Reduction { p: &mut baseline, b, whitener: &rows, y, gain: &mut gain, errors: &mut errors }.run::<Baseline>();
            reduce(&mut best, b, &whitener, y, &mut gain, &mut errors);
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
