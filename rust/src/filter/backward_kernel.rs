//! The kernel of the backward pass: what carries the information Λ of later samples back over a step, and what it tells of the errors there.
//!
//! As [`super::kernel`], compiled for each kind of lanes.  Nobody but a later observation of the position knows anything of the position alone, since it moves no other state: until there is one, its
//! rows of Λ are zero, and the parameter `P` says whether they are worked on.

use nalgebra::{Matrix3, Vector3};

use super::blocks::{Loaded, Rows, Upper, at, load, load_at};
use super::lanes::{Lanes, Work, dispatch};
use super::states::{BLOCKS, Block};

const POSITION: usize = Block::Position.index();

/// Λ becomes Fᵀ Λ F, with the shears of [`super::kernel::predict`].
#[inline]
pub(super) fn predict(information: &mut Upper, half: f64, tilt: &Rows, bias: &Rows) {
    if tells_of_position(information) {
        dispatch(Prediction::<true> { information, half, tilt, bias });
    } else {
        dispatch(Prediction::<false> { information, half, tilt, bias });
    }
}

/// Whether the rows of the position are not zero: Λ is not negative, so they are if their diagonal is.
#[inline]
fn tells_of_position(information: &Upper) -> bool {
    information[at(POSITION, POSITION)].diagonal().into_iter().any(|known| known != 0.0)
}

/// The first block of which Λ tells.
const fn first(position: bool) -> usize {
    if position { POSITION } else { POSITION + 1 }
}

struct Prediction<'a, const P: bool> {
    information: &'a mut Upper,
    half: f64,
    tilt: &'a Rows,
    bias: &'a Rows,
}

impl<const P: bool> Work for Prediction<'_, P> {
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
        let to_w = Loaded::<L>::zero().plus_product(aa, bias);
        let own = Loaded::<L>::zero().plus_transposed_product(bias_rows, load(aw).plus(0.5, to_w));
        load::<L>(ww).plus_both(own).store(ww);
        load::<L>(aw).plus(1.0, to_w).store(aw);
        load::<L>(wf).plus_transposed_product(bias_rows, load(af)).store(wf);

        if P {
            velocity_gains::<L>(half, [pp, pv, pa, pw, pf], [vv, va, vw, vf]);
        }

        let to_a = Loaded::<L>::zero().plus_product(vv, tilt);
        let to_f = Loaded::<L>::zero().plus_product(vv, bias);
        let own = Loaded::<L>::zero().plus_transposed_product(tilt_rows, load(va).plus(0.5, to_a));
        load::<L>(aa).plus_both(own).store(aa);
        let own = Loaded::<L>::zero().plus_transposed_product(bias_rows, load(vf).plus(0.5, to_f));
        load::<L>(ff).plus_both(own).store(ff);
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
fn velocity_gains<L: Lanes>(half: f64, [pp, pv, pa, pw, pf]: [&mut Rows; 5], [vv, va, vw, vf]: [&mut Rows; 4]) {
    let own = Loaded::<L>::zero().plus(half, load::<L>(pv).plus(0.5 * half, load(pp)));
    load::<L>(vv).plus_both(own).store(vv);
    load::<L>(pv).plus(half, load(pp)).store(pv);
    load::<L>(va).plus(half, load(pa)).store(va);
    load::<L>(vw).plus(half, load(pw)).store(vw);
    load::<L>(vf).plus(half, load(pf)).store(vf);
}

/// Λ becomes (I - K H)ᵀ Λ (I - K H) + Hᵀ S⁻¹ H, where the whitener is L⁻¹, `L Lᵀ = S`, b the observed block and the gain `Kᵀ = L⁻ᵀ V`.
#[inline]
pub(super) fn observe(information: &mut Upper, b: usize, whitener: &Matrix3<f64>, white_gain: &[Rows; BLOCKS]) {
    let whitener = &whitener.into();
    if b == POSITION || tells_of_position(information) {
        dispatch(Observation::<true> { information, b, whitener, white_gain });
    } else {
        dispatch(Observation::<false> { information, b, whitener, white_gain });
    }
}

struct Observation<'a, const P: bool> {
    information: &'a mut Upper,
    b: usize,
    whitener: &'a Rows,
    white_gain: &'a [Rows; BLOCKS],
}

impl<const P: bool> Work for Observation<'_, P> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { information, b, whitener, white_gain } = self;
        let mut gain = [Rows::default(); BLOCKS];
        for (gain, white) in gain.iter_mut().zip(white_gain).skip(first(P)) {
            Loaded::<L>::zero().plus_transposed_product(white, load(whitener)).store(gain);
        }
        let mut own = Loaded::<L>::zero().plus_transposed_product(whitener, load(whitener));
        let mut seen = [Loaded::<L>::zero(); BLOCKS];
        for i in first(P)..BLOCKS {
            for j in first(P)..BLOCKS {
                seen[i] = if i <= j {
                    seen[i].plus_product(&information[at(i, j)], load(&gain[j]))
                } else {
                    seen[i].plus_transposed_product(&information[at(j, i)], load(&gain[j]))
                };
            }
            own = own.plus_transposed_product(&gain[i], seen[i]);
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
        let change = Loaded::<L>::zero().plus(0.5, own).plus(-1.0, seen[b]);
        let block = &mut information[at(b, b)];
        load(block).plus_both(change).store(block);
    }
}

/// P λ, and the diagonal of the position's block of P Λ P.
#[inline]
pub(super) fn smooth(
    p: &Upper,
    costate: &[Vector3<f64>; BLOCKS],
    information: &Upper,
) -> ([Vector3<f64>; BLOCKS], Vector3<f64>) {
    let (mut errors, mut known) = ([[0.0; 4]; BLOCKS], [0.0; 4]);
    let (into, known_into) = (&mut errors, &mut known);
    if tells_of_position(information) {
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
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { p, costate, information, errors, known } = self;
        let zero = L::load(&[0.0; 4]);
        for (j, errors) in errors.iter_mut().enumerate() {
            let mut row = zero;
            for (i, costate) in costate.iter().enumerate().skip(first(P)) {
                row = load_at::<L>(p, i, j).plus_row_product(row, costate);
            }
            row.store(errors);
        }
        let mut half = zero;
        let with_position: [Loaded<L>; BLOCKS] = std::array::from_fn(|i| load_at(p, i, POSITION));
        for i in first(P)..BLOCKS {
            let own = Loaded::zero().plus_product(&information[at(i, i)], with_position[i]);
            let mut row = Loaded::zero().plus(0.5, own);
            for j in i + 1..BLOCKS {
                row = row.plus_product(&information[at(i, j)], with_position[j]);
            }
            half = with_position[i].plus_column_products(half, row);
        }
        zero.plus(2.0, half).store(known);
    }
}
