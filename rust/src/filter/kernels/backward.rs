//! The kernel of the backward pass: what carries the information Λ of later samples back over a
//! step, and what it tells of the errors there.
//!
//! As [`super::kernel`], compiled for each kind of lanes.  Nobody but a later observation of the
//! position knows anything of the position alone, since it moves no other state: until there is
//! one, its rows of Λ are zero, and the parameter `P` says whether they are worked on.

use nalgebra::{Matrix3, Vector3};

use crate::filter::error_state::{BLOCKS, Block};
use crate::math::block_matrix::{Block3, BlockReg, Upper, at, load};
use crate::math::simd::{Lanes, Work, dispatch};

const POSITION: usize = Block::Position.index();

/// Λ becomes Fᵀ Λ F, with the shears of [`super::kernel::predict`].
#[inline]
pub(crate) fn predict(information: &mut Upper, half: f64, tilt: &Block3, bias: &Block3) {
    if observes_position(information) {
        dispatch(Prediction::<true> { information, half, tilt, bias });
    } else {
        dispatch(Prediction::<false> { information, half, tilt, bias });
    }
}

/// Whether the rows of the position are not zero: Λ is not negative, so they are if their diagonal
/// is.
#[inline]
fn observes_position(information: &Upper) -> bool {
    information[at(POSITION, POSITION)].diagonal().into_iter().any(|known| known != 0.0)
}

/// The first block of which Λ tells.
const fn first(position: bool) -> usize {
    if position { POSITION } else { POSITION + 1 }
}

struct Prediction<'a, const P: bool> {
    information: &'a mut Upper,
    half: f64,
    tilt: &'a Block3,
    bias: &'a Block3,
}

impl<const P: bool> Work for Prediction<'_, P> {
    type Output = ();

    /// Letters are blocks, as in [`super::kernel`].
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { information, half, tilt: tilt_rows, bias: bias_rows } = self;
        let (tilt, bias) = (load::<L>(tilt_rows), load::<L>(bias_rows));
        let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = &mut information.0;

        if P {
            load::<L>(pw).plus_product(pa, bias).store(pw);
        }
        load::<L>(vw).plus_product(va, bias).store(vw);
        let to_w = BlockReg::<L>::zero().plus_product(aa, bias);
        let own =
            BlockReg::<L>::zero().plus_transposed_product(bias_rows, load(aw).plus(0.5, to_w));
        load::<L>(ww).add_symmetrized(own).store(ww);
        load::<L>(aw).plus(1.0, to_w).store(aw);
        load::<L>(wf).plus_transposed_product(bias_rows, load(af)).store(wf);

        if P {
            velocity_gains::<L>(half, [pp, pv, pa, pw, pf], [vv, va, vw, vf]);
        }

        let to_a = BlockReg::<L>::zero().plus_product(vv, tilt);
        let to_f = BlockReg::<L>::zero().plus_product(vv, bias);
        let own =
            BlockReg::<L>::zero().plus_transposed_product(tilt_rows, load(va).plus(0.5, to_a));
        load::<L>(aa).add_symmetrized(own).store(aa);
        let own =
            BlockReg::<L>::zero().plus_transposed_product(bias_rows, load(vf).plus(0.5, to_f));
        load::<L>(ff).add_symmetrized(own).store(ff);
        load::<L>(vf).plus(1.0, to_f).store(vf);
        let of_a = load::<L>(af).plus_transposed_product(va, bias);
        of_a.plus_transposed_product(tilt_rows, load(vf)).store(af);
        load::<L>(va).plus(1.0, to_a).store(va);
        load::<L>(aw).plus_transposed_product(tilt_rows, load(vw)).store(aw);
        load::<L>(wf).plus_transposed_product(vw, bias).store(wf);

        if P {
            load::<L>(pa).plus_product(pv, tilt).store(pa);
            load::<L>(pf).plus_product(pv, bias).store(pf);
            velocity_gains::<L>(half, [pp, pv, pa, pw, pf], [vv, va, vw, vf]);
        }
    }
}

/// The velocity gains `half` of the position.
#[inline(always)]
fn velocity_gains<L: Lanes>(
    half: f64,
    [pp, pv, pa, pw, pf]: [&mut Block3; 5],
    [vv, va, vw, vf]: [&mut Block3; 4],
) {
    let own = BlockReg::<L>::zero().plus(half, load::<L>(pv).plus(0.5 * half, load(pp)));
    load::<L>(vv).add_symmetrized(own).store(vv);
    load::<L>(pv).plus(half, load(pp)).store(pv);
    load::<L>(va).plus(half, load(pa)).store(va);
    load::<L>(vw).plus(half, load(pw)).store(vw);
    load::<L>(vf).plus(half, load(pf)).store(vf);
}

/// Λ becomes (I - K H)ᵀ Λ (I - K H) + Hᵀ S⁻¹ H, where the whitener is L⁻¹, `L Lᵀ = S`, b the
/// observed block and the gain `Kᵀ = L⁻ᵀ V`.
#[inline]
pub(crate) fn observe(
    information: &mut Upper,
    b: usize,
    whitener: &Matrix3<f64>,
    whitened_gain: &[Block3; BLOCKS],
) {
    let whitener = &whitener.into();
    if b == POSITION || observes_position(information) {
        dispatch(Observation::<true> { information, b, whitener, whitened_gain });
    } else {
        dispatch(Observation::<false> { information, b, whitener, whitened_gain });
    }
}

struct Observation<'a, const P: bool> {
    information: &'a mut Upper,
    b: usize,
    whitener: &'a Block3,
    whitened_gain: &'a [Block3; BLOCKS],
}

impl<const P: bool> Work for Observation<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { information, b, whitener, whitened_gain } = self;
        let mut gain = [Block3::default(); BLOCKS];
        for (gain, white) in gain.iter_mut().zip(whitened_gain).skip(first(P)) {
            BlockReg::<L>::zero().plus_transposed_product(white, load(whitener)).store(gain);
        }
        let seen = product::<L, P>(information, &gain);
        let mut own = BlockReg::<L>::zero().plus_transposed_product(whitener, load(whitener));
        for (gain, seen) in gain.iter().zip(&seen).skip(first(P)) {
            own = own.plus_transposed_product(gain, *seen);
        }
        for k in first(P)..BLOCKS {
            if k < b {
                let block = &mut information[at(k, b)];
                load(block).plus(-1.0, seen[k]).store(block);
            } else if k > b {
                let block = &mut information[at(b, k)];
                load(block).plus(-1.0, seen[k].transpose()).store(block);
            }
        }
        let change = BlockReg::<L>::zero().plus(0.5, own).plus(-1.0, seen[b]);
        let block = &mut information[at(b, b)];
        load(block).add_symmetrized(change).store(block);
    }
}

/// A symmetric matrix times a column of blocks; letters are blocks, and those of the column have a
/// c before them.
#[inline(always)]
fn product<L: Lanes, const P: bool>(
    matrix: &Upper,
    column: &[Block3; BLOCKS],
) -> [BlockReg<L>; BLOCKS] {
    let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = &matrix.0;
    let [cp, cv, ca, cw, cf] = column;
    let (cp, cv, ca, cw, cf) =
        (load::<L>(cp), load::<L>(cv), load::<L>(ca), load::<L>(cw), load::<L>(cf));
    let zero = BlockReg::zero();
    let v =
        zero.plus_product(vv, cv).plus_product(va, ca).plus_product(vw, cw).plus_product(vf, cf);
    let a = zero
        .plus_transposed_product(va, cv)
        .plus_product(aa, ca)
        .plus_product(aw, cw)
        .plus_product(af, cf);
    let w = zero.plus_transposed_product(vw, cv).plus_transposed_product(aw, ca);
    let w = w.plus_product(ww, cw).plus_product(wf, cf);
    let f = zero.plus_transposed_product(vf, cv).plus_transposed_product(af, ca);
    let f = f.plus_transposed_product(wf, cw).plus_product(ff, cf);
    if !P {
        return [zero, v, a, w, f];
    }
    let p = zero.plus_product(pp, cp).plus_product(pv, cv).plus_product(pa, ca);
    [
        p.plus_product(pw, cw).plus_product(pf, cf),
        v.plus_transposed_product(pv, cp),
        a.plus_transposed_product(pa, cp),
        w.plus_transposed_product(pw, cp),
        f.plus_transposed_product(pf, cp),
    ]
}

/// P λ, and the diagonal of the position's block of P Λ P.
#[inline]
pub(crate) fn smooth(
    p: &Upper,
    costate: &[Vector3<f64>; BLOCKS],
    information: &Upper,
) -> ([Vector3<f64>; BLOCKS], Vector3<f64>) {
    let (mut errors, mut known) = ([[0.0; 4]; BLOCKS], [0.0; 4]);
    let (into, known_into) = (&mut errors, &mut known);
    if observes_position(information) {
        dispatch(Smoothing::<true> { p, costate, information, errors: into, known: known_into });
    } else {
        dispatch(Smoothing::<false> { p, costate, information, errors: into, known: known_into });
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

impl<const P: bool> Work for Smoothing<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { p, costate, information, errors, known } = self;
        for (errors, row) in errors.iter_mut().zip(times::<L, P>(p, costate)) {
            row.store(errors);
        }
        known_of_position::<L, P>(p, information).store(known);
    }
}

/// A symmetric matrix times a column of states, as rows; the states have an s before their letters.
#[inline(always)]
fn times<L: Lanes, const P: bool>(matrix: &Upper, states: &[Vector3<f64>; BLOCKS]) -> [L; BLOCKS] {
    let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = &matrix.0;
    let [np, nv, na, nw, nf] = states;
    let (sp, sv, sa, sw, sf) =
        (row::<L>(np), row::<L>(nv), row::<L>(na), row::<L>(nw), row::<L>(nf));
    let zero = BlockReg::zero();
    let p = zero.plus_rows_times(pv, sv).plus_rows_times(pa, sa);
    let p = p.plus_rows_times(pw, sw).plus_rows_times(pf, sf);
    let v = zero.plus_rows_times(vv, sv).plus_rows_times(va, sa);
    let v = v.plus_rows_times(vw, sw).plus_rows_times(vf, sf).sums();
    let a = zero.plus_rows_times(aa, sa).plus_rows_times(aw, sw).plus_rows_times(af, sf).sums();
    let a = load(va).plus_row_product(a, nv);
    let w = zero.plus_rows_times(ww, sw).plus_rows_times(wf, sf).sums();
    let w = load(aw).plus_row_product(load(vw).plus_row_product(w, nv), na);
    let f = zero.plus_rows_times(ff, sf).sums();
    let f = load(wf)
        .plus_row_product(load(af).plus_row_product(load(vf).plus_row_product(f, nv), na), nw);
    if !P {
        return [p.sums(), v, a, w, f];
    }
    [
        p.plus_rows_times(pp, sp).sums(),
        load(pv).plus_row_product(v, np),
        load(pa).plus_row_product(a, np),
        load(pw).plus_row_product(w, np),
        load(pf).plus_row_product(f, np),
    ]
}

#[inline(always)]
fn row<L: Lanes>(v: &Vector3<f64>) -> L {
    L::load(&[v.x, v.y, v.z, 0.0])
}

/// `0.5 left right`.
#[inline(always)]
fn half<L: Lanes>(left: &Block3, right: BlockReg<L>) -> BlockReg<L> {
    BlockReg::zero().plus_product(left, BlockReg::zero().plus(0.5, right))
}

/// The diagonal of `X Λ Xᵀ`, where X is the row of the position in P; its blocks have an x before
/// their letters.
#[inline(always)]
fn known_of_position<L: Lanes, const P: bool>(p: &Upper, information: &Upper) -> L {
    let [xp, xv, xa, xw, xf, ..] = &p.0;
    let (xp, xv, xa) = (load::<L>(xp), load::<L>(xv).transpose(), load::<L>(xa).transpose());
    let (xw, xf) = (load::<L>(xw).transpose(), load::<L>(xf).transpose());
    let [pp, pv, pa, pw, pf, vv, va, vw, vf, aa, aw, af, ww, wf, ff] = &information.0;
    let v = half(vv, xv).plus_product(va, xa).plus_product(vw, xw).plus_product(vf, xf);
    let a = half(aa, xa).plus_product(aw, xw).plus_product(af, xf);
    let w = half(ww, xw).plus_product(wf, xf);
    let known = xv.plus_inner_products(L::load(&[0.0; 4]), v);
    let known = xf.plus_inner_products(
        xw.plus_inner_products(xa.plus_inner_products(known, a), w),
        half(ff, xf),
    );
    let known = if P {
        let p = half(pp, xp)
            .plus_product(pv, xv)
            .plus_product(pa, xa)
            .plus_product(pw, xw)
            .plus_product(pf, xf);
        xp.plus_inner_products(known, p)
    } else {
        known
    };
    known.plus(1.0, known)
}

#[cfg(test)]
mod tests {
    use nalgebra::SMatrix;
    use proptest::prelude::*;

    use super::*;
    use crate::filter::error_state::STATES;
    use crate::filter::kernels::dense::{BLOCK, Dense, difference, matrices, shear, upper};
    use crate::math::simd::Baseline;

    /// A positive matrix A Aᵀ.
    fn positive() -> impl Strategy<Value = Dense> {
        prop::collection::vec(-1.0..1.0, STATES * STATES).prop_map(|values| {
            let a = Dense::from_column_slice(&values);
            a * a.transpose()
        })
    }

    /// An information matrix, which tells of the position or not.
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
        fn information_goes_back_over_a_transition_on_any_lanes(dense in information(), half in 0.001..0.5, tilt in matrices(), bias in matrices()) {
            let (tilt_rows, bias_rows) = (Block3::from(&tilt), Block3::from(&bias));
            let (mut best, mut baseline) = (upper(&dense), upper(&dense));
            predict(&mut best, half, &tilt_rows, &bias_rows);
            let (tilt_of, bias_of) = (&tilt_rows, &bias_rows);
            if tells(&dense) {
                Prediction::<true> { information: &mut baseline, half, tilt: tilt_of, bias: bias_of }.run::<Baseline>();
            } else {
                Prediction::<false> { information: &mut baseline, half, tilt: tilt_of, bias: bias_of }.run::<Baseline>();
            }
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
        fn information_goes_back_over_an_observation_on_any_lanes(dense in information(), p in positive(), b in 0..BLOCKS, whitener in matrices()) {
            let whitener = 0.3 * whitener.lower_triangle();
            let v = whitener * p.fixed_rows::<BLOCK>(BLOCK * b);
            let gain: [Block3; BLOCKS] = std::array::from_fn(|k| Block3::from(&v.fixed_columns::<BLOCK>(BLOCK * k).into_owned()));
            let (mut best, mut baseline) = (upper(&dense), upper(&dense));
            observe(&mut best, b, &whitener, &gain);
            let (whitener_rows, whitened_gain) = (&Block3::from(&whitener), &gain);
            if tells(&dense) || b == POSITION {
                Observation::<true> { information: &mut baseline, b, whitener: whitener_rows, whitened_gain }.run::<Baseline>();
            } else {
                Observation::<false> { information: &mut baseline, b, whitener: whitener_rows, whitened_gain }.run::<Baseline>();
            }
            let mut h = SMatrix::<f64, BLOCK, STATES>::zeros();
            h.fixed_columns_mut::<BLOCK>(BLOCK * b).fill_with_identity();
            let rest = Dense::identity() - v.transpose() * whitener * h;
            let expected = rest.transpose() * dense * rest + h.transpose() * whitener.transpose() * whitener * h;
            for observed in [best, baseline] {
                prop_assert!(difference(&observed, &expected) < 1e-11 * expected.amax().max(1.0));
                for k in 0..BLOCKS {
                    prop_assert_eq!(&observed[at(k, k)], &observed[at(k, k)].transpose());
                }
            }
        }

        #[test]
        fn smoothing_is_the_dense_product_on_any_lanes(p in positive(), dense in information(), mut costate in states()) {
            if !tells(&dense) {
                costate[POSITION] = Vector3::zeros();
            }
            let (p_upper, information) = (upper(&p), upper(&dense));
            let (p_upper, information, costate) = (&p_upper, &information, &costate);
            let (mut errors, mut known) = ([[0.0; 4]; BLOCKS], [0.0; 4]);
            let (into, known_into) = (&mut errors, &mut known);
            if tells(&dense) {
                Smoothing::<true> { p: p_upper, costate, information, errors: into, known: known_into }.run::<Baseline>();
            } else {
                Smoothing::<false> { p: p_upper, costate, information, errors: into, known: known_into }.run::<Baseline>();
            }
            let vector = |[x, y, z, _]: [f64; 4]| Vector3::new(x, y, z);
            let expected_known = (p * dense * p).diagonal();
            for (errors, known) in [smooth(p_upper, costate, information), (errors.map(vector), vector(known))] {
                prop_assert!((known - expected_known.fixed_rows::<BLOCK>(0)).norm() < 1e-10 * expected_known.norm().max(1.0));
                for (i, errors) in errors.iter().enumerate() {
                    let row = (0..BLOCKS).map(|j| p.fixed_view::<BLOCK, BLOCK>(BLOCK * i, BLOCK * j) * costate[j]);
                    prop_assert!((errors - row.sum::<Vector3<f64>>()).norm() < 1e-11);
                }
            }
        }
    }
}
