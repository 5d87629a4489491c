use nalgebra::{SMatrix, UnitQuaternion};
use proptest::prelude::*;

use super::*;
use crate::filter::error_state::{ErrorStates, STATES};
use crate::ins::strapdown::StrapdownStep;
use crate::math::simd::Baseline;

const ALL: usize = STATES + 4;
const NOISE: f64 = 1.0e-3;

type Dense = SMatrix<f64, ALL, ALL>;
type Selector = SMatrix<f64, ALL, STATES>;

/// What the filter does in one row: moves, ties or not, and observes a block, or resets it.
#[derive(Clone, Debug)]
struct Move {
    force: Vector3<f64>,
    turn: Vector3<f64>,
    coupling: Option<Vector3<f64>>,
    block: Block,
    axis: Option<usize>,
    resets: bool,
}

fn vectors(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
    [-limit..limit, -limit..limit, -limit..limit].prop_map(Vector3::from)
}

fn moves() -> impl Strategy<Value = Vec<Move>> {
    let one = (
        vectors(10.0),
        vectors(3.0),
        prop::option::of(vectors(0.1)),
        prop::sample::select(&Block::ALL[..]),
        prop::option::of(0_usize..3),
        prop::bool::weighted(0.1),
    );
    let one = one.prop_map(|(force, turn, coupling, block, axis, resets)| Move {
        force,
        turn,
        coupling,
        block,
        axis,
        resets,
    });
    prop::collection::vec(one, 1..12)
}

/// The 19 states right after the copy.
fn augmented(p: &Covariance) -> Dense {
    let mut copy = Selector::zeros();
    copy.fixed_view_mut::<STATES, STATES>(0, 0).fill_with_identity();
    for (row, state) in [0, 1, 2, 8].into_iter().enumerate() {
        copy[(STATES + row, state)] = 1.0;
    }
    copy * p.dense() * copy.transpose()
}

/// A step of the 15 states as a matrix of all 19.
fn whole(apply: impl Fn(&mut ErrorStates)) -> Dense {
    let mut dense = Dense::identity();
    for column in 0..STATES {
        let mut states = ErrorStates::default();
        states.0[column / 3][column % 3] = 1.0;
        apply(&mut states);
        for row in 0..STATES {
            dense[(row, column)] = states.0[row / 3][row % 3];
        }
    }
    dense
}

fn add_to_all(p: &mut Covariance, variance: f64) {
    for block in Block::ALL {
        p.add_variance(block, variance);
    }
}

/// A covariance as the filter leaves it after some moves.
fn after(moves: &[Move]) -> Covariance {
    let mut p = Covariance::zero();
    add_to_all(&mut p, 1.0);
    for one in moves {
        one.of_filter(&mut p, &mut ());
    }
    p
}

fn observe(p: &mut Dense, state: usize) {
    let mut h = SMatrix::<f64, 1, ALL>::zeros();
    h[state] = 1.0;
    let mut k = *p * h.transpose() / ((h * *p * h.transpose())[0] + NOISE);
    k.fixed_rows_mut::<4>(STATES).fill(0.0);
    let rest = Dense::identity() - k * h;
    *p = rest * *p * rest.transpose() + NOISE * k * k.transpose();
}

impl Move {
    fn transition(&self) -> Transition {
        let attitude =
            UnitQuaternion::from_scaled_axis(self.turn).to_rotation_matrix().into_inner();
        let step = StrapdownStep { dt: 0.1, velocity_increment_n: 0.1 * self.force, attitude };
        Transition::new(&step, &Vector3::new(0.0, 0.02, 0.03))
    }

    fn couple(&self) -> Option<Matrix3<f64>> {
        self.coupling.map(|v| crate::math::rotation::cross_matrix(&v))
    }

    fn of_filter(&self, p: &mut Covariance, recorder: &mut impl FilterRecorder) {
        let transition = self.transition();
        transition.apply(Baseline, p);
        recorder.transition(Baseline, &transition, &Noise::default());
        if let Some(m) = self.couple() {
            p.add_transformed(Baseline, Block::Attitude, Block::AccelBias, &m);
            recorder.couple(Baseline, &m);
        }
        add_to_all(p, NOISE);
        if self.resets {
            p.reset_block(self.block, &Vector3::repeat(1.0));
            recorder.reset_block(self.block, &Vector3::repeat(1.0));
            return;
        }
        let (zero, mut used) = (Vector3::zeros(), None);
        let r = Matrix3::from_diagonal_element(NOISE);
        match self.axis {
            None => p.observe(Baseline, self.block, &zero, &r, f64::INFINITY, &mut used),
            Some(axis) => {
                let state = (self.block, axis);
                p.observe_axis(Baseline, state, 0.0, NOISE, f64::INFINITY, &mut used)
            }
        };
        recorder.observation(Baseline, &used.unwrap());
    }

    fn of_dense(&self, p: &mut Dense) {
        let transition = self.transition();
        let f = whole(|states| {
            transition.apply(Baseline, states);
            if let Some(m) = self.couple() {
                states.add_transformed(Baseline, Block::Attitude, Block::AccelBias, &m);
            }
        });
        *p = f * *p * f.transpose();
        for state in 0..STATES {
            p[(state, state)] += NOISE;
        }
        let first = 3 * self.block.index();
        for state in
            (first..first + 3).filter(|&state| self.axis.is_none_or(|axis| first + axis == state))
        {
            if !self.resets {
                observe(p, state);
            }
        }
        for state in (first..first + 3).filter(|_| self.resets) {
            p.row_mut(state).fill(0.0);
            p.column_mut(state).fill(0.0);
            p[(state, state)] = 1.0;
        }
    }
}

proptest! {
    #[test]
    fn the_clone_is_the_augmented_filter(before in moves(), later in moves()) {
        let mut p = after(&before);
        let (mut dense, mut clone) = (augmented(&p), ClonedErrors::of(&p));
        for one in &later {
            one.of_filter(&mut p, &mut clone);
            one.of_dense(&mut dense);
        }
        let scale = dense.norm();
        prop_assert!((p.dense() - dense.fixed_view::<STATES, STATES>(0, 0)).norm() < 1e-9 * scale);
        prop_assert!((clone.own - dense.fixed_view::<4, 4>(STATES, STATES)).norm() < 1e-9 * scale);
        for block in Block::ALL {
            let expected = dense.fixed_view::<3, 4>(3 * block.index(), STATES);
            prop_assert!((clone.block(block) - expected).norm() < 1e-9 * scale);
        }
    }

    #[test]
    fn errors_that_were_just_cloned_are_those_of_now(before in moves()) {
        let p = after(&before);
        let clone = ClonedErrors::of(&p);
        prop_assert_eq!(clone.with_now(), pose_covariance(&p));
        prop_assert!((clone.own - clone.own.transpose()).norm() == 0.0);
    }
}
