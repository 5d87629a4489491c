//! The kernels of the backward pass: the propagation of the information Λ of later samples back over
//! an operation of the filter, and the smoothed errors.
//!
//! As [`super::forward`], compiled for each instruction set.  Only a later observation of
//! the position carries information on the position alone, since no other state depends on it:
//! without one, its rows of Λ are zero, and the parameter `P` is whether they are computed.

use nalgebra::{Matrix3, Vector3};

use crate::filter::error_state::{BLOCKS, Block};
use crate::math::block_matrix::{Block3, BlockReg, Upper, at, load};
use crate::math::simd::{F64x4, Simd, WithSimd};

const POSITION: usize = Block::Position.index();

/// Λ becomes Fᵀ Λ F, with the factors of [`super::forward::predict`].
#[inline]
pub(crate) fn predict<S: Simd>(
    simd: S,
    information: &mut Upper,
    half: f64,
    tilt: &Block3,
    bias: &Block3,
) {
    if observes_position(information) {
        simd.vectorize(Prediction::<true> { information, half, tilt, bias });
    } else {
        simd.vectorize(Prediction::<false> { information, half, tilt, bias });
    }
}

/// Whether the rows of the position are not zero: Λ is not negative, so they are if their diagonal
/// is.
#[inline]
fn observes_position(information: &Upper) -> bool {
    information[at(POSITION, POSITION)].diagonal().into_iter().any(|known| known != 0.0)
}

/// The first block with information in Λ.
const fn first(position: bool) -> usize {
    if position { POSITION } else { POSITION + 1 }
}

struct Prediction<'a, const P: bool> {
    information: &'a mut Upper,
    half: f64,
    tilt: &'a Block3,
    bias: &'a Block3,
}

impl<const P: bool> WithSimd for Prediction<'_, P> {
    type Output = ();

    /// Letters are blocks, as in [`super::forward`].
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { information, half, tilt: tilt_rows, bias: bias_rows } = self;
        let (tilt, bias) = (load::<S>(tilt_rows), load::<S>(bias_rows));
        let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = &mut information.0;

        if P {
            load::<S>(pw).add_product(pa, bias).store(pw);
        }
        load::<S>(vw).add_product(va, bias).store(vw);
        let to_w = BlockReg::<S>::zero().add_product(aa, bias);
        let own =
            BlockReg::<S>::zero().add_transposed_product(bias_rows, load(aw).add_scaled(0.5, to_w));
        load::<S>(ww).add_symmetrized(own).store(ww);
        load::<S>(aw).add_scaled(1.0, to_w).store(aw);
        load::<S>(wf).add_transposed_product(bias_rows, load(af)).store(wf);

        if P {
            velocity_gains::<S>(half, [pp, pv, pa, pw, pf], [vv, va, vw, vf]);
        }

        let to_a = BlockReg::<S>::zero().add_product(vv, tilt);
        let to_f = BlockReg::<S>::zero().add_product(vv, bias);
        let own =
            BlockReg::<S>::zero().add_transposed_product(tilt_rows, load(va).add_scaled(0.5, to_a));
        load::<S>(aa).add_symmetrized(own).store(aa);
        let own =
            BlockReg::<S>::zero().add_transposed_product(bias_rows, load(vf).add_scaled(0.5, to_f));
        load::<S>(ff).add_symmetrized(own).store(ff);
        load::<S>(vf).add_scaled(1.0, to_f).store(vf);
        let of_a = load::<S>(af).add_transposed_product(va, bias);
        of_a.add_transposed_product(tilt_rows, load(vf)).store(af);
        load::<S>(va).add_scaled(1.0, to_a).store(va);
        load::<S>(aw).add_transposed_product(tilt_rows, load(vw)).store(aw);
        load::<S>(wf).add_transposed_product(vw, bias).store(wf);

        if P {
            load::<S>(pa).add_product(pv, tilt).store(pa);
            load::<S>(pf).add_product(pv, bias).store(pf);
            velocity_gains::<S>(half, [pp, pv, pa, pw, pf], [vv, va, vw, vf]);
        }
    }
}

/// Adds `half` of the position to the velocity.
#[inline(always)]
fn velocity_gains<S: Simd>(
    half: f64,
    [pp, pv, pa, pw, pf]: [&mut Block3; 5],
    [vv, va, vw, vf]: [&mut Block3; 4],
) {
    let own =
        BlockReg::<S>::zero().add_scaled(half, load::<S>(pv).add_scaled(0.5 * half, load(pp)));
    load::<S>(vv).add_symmetrized(own).store(vv);
    load::<S>(pv).add_scaled(half, load(pp)).store(pv);
    load::<S>(va).add_scaled(half, load(pa)).store(va);
    load::<S>(vw).add_scaled(half, load(pw)).store(vw);
    load::<S>(vf).add_scaled(half, load(pf)).store(vf);
}

/// Λ becomes (I - K H)ᵀ Λ (I - K H) + Hᵀ S⁻¹ H, where the whitener is L⁻¹, `L Lᵀ = S`, b the
/// observed block and the gain `Kᵀ = L⁻ᵀ V`.
#[inline]
pub(crate) fn observe<S: Simd>(
    simd: S,
    information: &mut Upper,
    b: usize,
    whitener: &Matrix3<f64>,
    whitened_gain: &[Block3; BLOCKS],
) {
    let whitener = &whitener.into();
    if b == POSITION || observes_position(information) {
        simd.vectorize(Observation::<true> { information, b, whitener, whitened_gain });
    } else {
        simd.vectorize(Observation::<false> { information, b, whitener, whitened_gain });
    }
}

struct Observation<'a, const P: bool> {
    information: &'a mut Upper,
    b: usize,
    whitener: &'a Block3,
    whitened_gain: &'a [Block3; BLOCKS],
}

impl<const P: bool> WithSimd for Observation<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { information, b, whitener, whitened_gain } = self;
        let mut gain = [Block3::default(); BLOCKS];
        for (gain, white) in gain.iter_mut().zip(whitened_gain).skip(first(P)) {
            BlockReg::<S>::zero().add_transposed_product(white, load(whitener)).store(gain);
        }
        let seen = product::<S, P>(information, &gain);
        let mut own = BlockReg::<S>::zero().add_transposed_product(whitener, load(whitener));
        for (gain, seen) in gain.iter().zip(&seen).skip(first(P)) {
            own = own.add_transposed_product(gain, *seen);
        }
        for k in first(P)..BLOCKS {
            if k < b {
                let block = &mut information[at(k, b)];
                load(block).add_scaled(-1.0, seen[k]).store(block);
            } else if k > b {
                let block = &mut information[at(b, k)];
                load(block).add_scaled(-1.0, seen[k].transpose()).store(block);
            }
        }
        let change = BlockReg::<S>::zero().add_scaled(0.5, own).add_scaled(-1.0, seen[b]);
        let block = &mut information[at(b, b)];
        load(block).add_symmetrized(change).store(block);
    }
}

/// A symmetric matrix times a column of blocks; letters are blocks, and those of the column have a
/// c before them.
#[inline(always)]
fn product<S: Simd, const P: bool>(
    matrix: &Upper,
    column: &[Block3; BLOCKS],
) -> [BlockReg<S>; BLOCKS] {
    let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = &matrix.0;
    let [cp, cv, ca, cw, cf] = column;
    let (cp, cv, ca, cw, cf) =
        (load::<S>(cp), load::<S>(cv), load::<S>(ca), load::<S>(cw), load::<S>(cf));
    let zero = BlockReg::zero();
    let v = zero.add_product(vv, cv).add_product(va, ca).add_product(vw, cw).add_product(vf, cf);
    let a = zero
        .add_transposed_product(va, cv)
        .add_product(aa, ca)
        .add_product(aw, cw)
        .add_product(af, cf);
    let w = zero.add_transposed_product(vw, cv).add_transposed_product(aw, ca);
    let w = w.add_product(ww, cw).add_product(wf, cf);
    let f = zero.add_transposed_product(vf, cv).add_transposed_product(af, ca);
    let f = f.add_transposed_product(wf, cw).add_product(ff, cf);
    if !P {
        return [zero, v, a, w, f];
    }
    let p = zero.add_product(pp, cp).add_product(pv, cv).add_product(pa, ca);
    [
        p.add_product(pw, cw).add_product(pf, cf),
        v.add_transposed_product(pv, cp),
        a.add_transposed_product(pa, cp),
        w.add_transposed_product(pw, cp),
        f.add_transposed_product(pf, cp),
    ]
}

/// P λ, and the diagonal of the position's block of P Λ P.
#[inline]
pub(crate) fn smooth<S: Simd>(
    simd: S,
    p: &Upper,
    costate: &[Vector3<f64>; BLOCKS],
    information: &Upper,
) -> ([Vector3<f64>; BLOCKS], Vector3<f64>) {
    let (mut errors, mut known) = ([[0.0; 4]; BLOCKS], [0.0; 4]);
    let (into, known_into) = (&mut errors, &mut known);
    if observes_position(information) {
        simd.vectorize(Smoothing::<true> {
            p,
            costate,
            information,
            errors: into,
            known: known_into,
        });
    } else {
        simd.vectorize(Smoothing::<false> {
            p,
            costate,
            information,
            errors: into,
            known: known_into,
        });
    }
    let vector = |[x, y, z, _]: [f64; 4]| Vector3::new(x, y, z);
    (errors.map(vector), vector(known))
}

struct Smoothing<'a, const P: bool> {
    p: &'a Upper,
    costate: &'a [Vector3<f64>; BLOCKS],
    information: &'a Upper,
    errors: &'a mut [[f64; 4]; BLOCKS],
    known: &'a mut [f64; 4],
}

impl<const P: bool> WithSimd for Smoothing<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { p, costate, information, errors, known } = self;
        for (errors, row) in errors.iter_mut().zip(mul::<S, P>(p, costate)) {
            row.store(errors);
        }
        known_of_position::<S, P>(p, information).store(known);
    }
}

/// A symmetric matrix times a column of states, as rows; the states have an s before their letters.
#[inline(always)]
fn mul<S: Simd, const P: bool>(
    matrix: &Upper,
    states: &[Vector3<f64>; BLOCKS],
) -> [S::F64x4; BLOCKS] {
    let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = &matrix.0;
    let [np, nv, na, nw, nf] = states;
    let (sp, sv, sa, sw, sf) =
        (row::<S>(np), row::<S>(nv), row::<S>(na), row::<S>(nw), row::<S>(nf));
    let zero = BlockReg::<S>::zero();
    let p = zero.add_outer_products(pv, sv).add_outer_products(pa, sa);
    let p = p.add_outer_products(pw, sw).add_outer_products(pf, sf);
    let v = zero.add_outer_products(vv, sv).add_outer_products(va, sa);
    let v = v.add_outer_products(vw, sw).add_outer_products(vf, sf).sums();
    let a = zero
        .add_outer_products(aa, sa)
        .add_outer_products(aw, sw)
        .add_outer_products(af, sf)
        .sums();
    let a = load::<S>(va).add_row_product(a, nv);
    let w = zero.add_outer_products(ww, sw).add_outer_products(wf, sf).sums();
    let w = load::<S>(aw).add_row_product(load::<S>(vw).add_row_product(w, nv), na);
    let f = zero.add_outer_products(ff, sf).sums();
    let f = load::<S>(wf).add_row_product(
        load::<S>(af).add_row_product(load::<S>(vf).add_row_product(f, nv), na),
        nw,
    );
    if !P {
        return [p.sums(), v, a, w, f];
    }
    [
        p.add_outer_products(pp, sp).sums(),
        load::<S>(pv).add_row_product(v, np),
        load::<S>(pa).add_row_product(a, np),
        load::<S>(pw).add_row_product(w, np),
        load::<S>(pf).add_row_product(f, np),
    ]
}

#[inline(always)]
fn row<S: Simd>(v: &Vector3<f64>) -> S::F64x4 {
    S::F64x4::load(&[v.x, v.y, v.z, 0.0])
}

/// `0.5 left right`.
#[inline(always)]
fn half<S: Simd>(left: &Block3, right: BlockReg<S>) -> BlockReg<S> {
    BlockReg::zero().add_product(left, BlockReg::zero().add_scaled(0.5, right))
}

/// The diagonal of `X Λ Xᵀ`, where X is the row of the position in P; its blocks have an x before
/// their letters.
#[inline(always)]
fn known_of_position<S: Simd, const P: bool>(p: &Upper, information: &Upper) -> S::F64x4 {
    let [xp, xv, xa, xw, xf, ..] = &p.0;
    let (xp, xv, xa) = (load::<S>(xp), load::<S>(xv).transpose(), load::<S>(xa).transpose());
    let (xw, xf) = (load::<S>(xw).transpose(), load::<S>(xf).transpose());
    let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = &information.0;
    let v = half(vv, xv).add_product(va, xa).add_product(vw, xw).add_product(vf, xf);
    let a = half(aa, xa).add_product(aw, xw).add_product(af, xf);
    let w = half(ww, xw).add_product(wf, xf);
    let known = xv.add_inner_products(S::F64x4::load(&[0.0; 4]), v);
    let known = xf.add_inner_products(
        xw.add_inner_products(xa.add_inner_products(known, a), w),
        half(ff, xf),
    );
    let known = if P {
        let p = half(pp, xp)
            .add_product(pv, xv)
            .add_product(pa, xa)
            .add_product(pw, xw)
            .add_product(pf, xf);
        xp.add_inner_products(known, p)
    } else {
        known
    };
    known.add_scaled(1.0, known)
}

#[cfg(test)]
mod tests {
    use nalgebra::SMatrix;
    use proptest::prelude::*;

    use super::*;
    use crate::filter::error_state::STATES;
    use crate::filter::kernels::dense::{BLOCK, Dense, difference, matrices, shear, upper};
    use crate::math::simd::{Baseline, on_best_instruction_set};

    /// A positive matrix A Aᵀ.
    fn positive() -> impl Strategy<Value = Dense> {
        prop::collection::vec(-1.0..1.0, STATES * STATES).prop_map(|values| {
            let a = Dense::from_column_slice(&values);
            a * a.transpose()
        })
    }

    /// An information matrix, with or without information on the position.
    fn information() -> impl Strategy<Value = Dense> {
        (positive(), any::<bool>()).prop_map(|(mut dense, position)| {
            if !position {
                dense.fixed_rows_mut::<BLOCK>(0).fill(0.0);
                dense.fixed_columns_mut::<BLOCK>(0).fill(0.0);
            }
            dense
        })
    }

    fn states() -> impl Strategy<Value = [Vector3<f64>; BLOCKS]> {
        [(); BLOCKS].map(|()| [-1.0..1.0, -1.0..1.0, -1.0..1.0].prop_map(Vector3::from))
    }

    fn tells(dense: &Dense) -> bool {
        dense[(0, 0)] > 0.0
    }

    proptest! {
        #[test]
        fn information_goes_back_over_a_transition_on_any_instruction_set(
            dense in information(),
            half in 0.001..0.5,
            tilt in matrices(),
            bias in matrices(),
        ) {
            let (tilt_rows, bias_rows) = (Block3::from(&tilt), Block3::from(&bias));
            let (mut best, mut baseline) = (upper(&dense), upper(&dense));
            on_best_instruction_set!(simd => predict(simd, &mut best, half, &tilt_rows, &bias_rows));
            predict(Baseline, &mut baseline, half, &tilt_rows, &bias_rows);
            let position = shear(Block::Position, Block::Velocity, &Matrix3::from_diagonal_element(half));
            let f = shear(Block::Attitude, Block::GyroBias, &bias)
                * position
                * shear(Block::Velocity, Block::AccelBias, &bias)
                * shear(Block::Velocity, Block::Attitude, &tilt)
                * position;
            let expected = f.transpose() * dense * f;
            for moved in [best, baseline] {
                prop_assert!(difference(&moved, &expected) < 1e-11 * expected.amax().max(1.0));
            }
        }

        #[test]
        fn information_goes_back_over_an_observation_on_any_instruction_set(
            dense in information(),
            p in positive(),
            b in 0..BLOCKS,
            whitener in matrices(),
        ) {
            let whitener = 0.3 * whitener.lower_triangle();
            let v = whitener * p.fixed_rows::<BLOCK>(BLOCK * b);
            let gain: [Block3; BLOCKS] =
                std::array::from_fn(|k| Block3::from(&v.fixed_columns::<BLOCK>(BLOCK * k).into_owned()));
            let (mut best, mut baseline) = (upper(&dense), upper(&dense));
            on_best_instruction_set!(simd => observe(simd, &mut best, b, &whitener, &gain));
            observe(Baseline, &mut baseline, b, &whitener, &gain);
            let mut h = SMatrix::<f64, BLOCK, STATES>::zeros();
            h.fixed_columns_mut::<BLOCK>(BLOCK * b).fill_with_identity();
            let rest = Dense::identity() - v.transpose() * whitener * h;
            let expected =
                rest.transpose() * dense * rest + h.transpose() * whitener.transpose() * whitener * h;
            for observed in [best, baseline] {
                prop_assert!(difference(&observed, &expected) < 1e-11 * expected.amax().max(1.0));
                for k in 0..BLOCKS {
                    prop_assert_eq!(&observed[at(k, k)], &observed[at(k, k)].transpose());
                }
            }
        }

        #[test]
        fn smoothing_is_the_dense_product_on_any_instruction_set(
            p in positive(),
            dense in information(),
            mut costate in states(),
        ) {
            if !tells(&dense) {
                costate[POSITION] = Vector3::zeros();
            }
            let (p_upper, information) = (upper(&p), upper(&dense));
            let best = on_best_instruction_set!(simd => smooth(simd, &p_upper, &costate, &information));
            let baseline = smooth(Baseline, &p_upper, &costate, &information);
            let expected_known = (p * dense * p).diagonal();
            for (errors, known) in [best, baseline] {
                prop_assert!(
                    (known - expected_known.fixed_rows::<BLOCK>(0)).norm()
                        < 1e-10 * expected_known.norm().max(1.0)
                );
                for (i, errors) in errors.iter().enumerate() {
                    let row =
                        (0..BLOCKS).map(|j| p.fixed_view::<BLOCK, BLOCK>(BLOCK * i, BLOCK * j) * costate[j]);
                    prop_assert!((errors - row.sum::<Vector3<f64>>()).norm() < 1e-11);
                }
            }
        }
    }
}
