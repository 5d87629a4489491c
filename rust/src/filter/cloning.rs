//! Stochastic cloning: the cross-covariance of the present errors with those at an earlier instant.
//!
//! At that instant the errors of the pose, δp and φ about the up axis of n, are copied.  The copy is
//! constant, and its cross-covariance X with the present errors is propagated as the covariance P, from
//! one side:
//!
//! ```text
//! over a transition     P <- F P Fᵀ + Q          X <- F X
//! over an observation   P <- (I - K H) P         X <- (I - K H) X
//! ```
//!
//! This is the filter of the 19 states with the copy, in which no observation corrects the copy: the
//! solution of that instant is output and does not change.
//!
//! # References
//! S. I. Roumeliotis, J. W. Burdick, "Stochastic Cloning: A Generalized Framework for Processing
//! Relative State Measurements", ICRA 2002.

use nalgebra::{Matrix3, Matrix3x4, Matrix4, Vector3};

use crate::filter::covariance::Covariance;
use crate::filter::error_state::{Block, LinearMap};
use crate::filter::kernels::forward::{Columns, move_columns, reduce_columns};
use crate::filter::observation::Observation;
use crate::filter::process_noise::Noise;
use crate::filter::recorder::FilterRecorder;
use crate::filter::transition::Transition;
use crate::math::block_matrix::Block3;
use crate::math::simd::{Simd, WithSimd};

/// Pose errors at an earlier instant, and their cross-covariance with the present errors.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClonedErrors {
    own: Matrix4<f64>,
    /// X, a column for each of the cloned errors.
    cross: Columns,
}

impl ClonedErrors {
    /// Clones the present errors.
    pub(crate) fn of(p: &Covariance) -> Self {
        let cross =
            Block::ALL.map(|block| {
                let position = p.block(block, Block::Position);
                let attitude = p.block(block, Block::Attitude);
                Block3([0, 1, 2].map(|k| {
                    [position[(k, 0)], position[(k, 1)], position[(k, 2)], attitude[(k, 2)]]
                }))
            });
        Self { own: pose_rows(&cross), cross }
    }

    /// Covariance of the cloned pose errors, in the order of [`pose_covariance`].
    pub(crate) fn own(&self) -> &Matrix4<f64> {
        &self.own
    }

    /// Cross-covariance of the present pose errors, along the rows, with the cloned ones.
    pub(crate) fn with_now(&self) -> Matrix4<f64> {
        pose_rows(&self.cross)
    }

    fn block(&self, block: Block) -> Matrix3x4<f64> {
        Matrix3x4::from_row_slice(self.cross[block.index()].0.as_flattened())
    }

    fn replace(&mut self, block: Block, columns: &Matrix3x4<f64>) {
        self.cross[block.index()] = Block3([0, 1, 2].map(|k| columns.row(k).transpose().into()));
    }
}

/// Covariance of the errors of position (m) and heading (rad, about the up axis), in n.
pub(crate) fn pose_covariance(p: &Covariance) -> Matrix4<f64> {
    *ClonedErrors::of(p).own()
}

fn pose_rows(columns: &Columns) -> Matrix4<f64> {
    let [x, y, z] = columns[Block::Position.index()].0;
    let heading = columns[Block::Attitude.index()].0[2];
    Matrix4::from_row_slice([x, y, z, heading].as_flattened())
}

impl LinearMap for ClonedErrors {
    #[inline]
    fn add_transformed(&mut self, _: impl Simd, target: Block, source: Block, m: &Matrix3<f64>) {
        self.replace(target, &(self.block(target) + m * self.block(source)));
    }

    #[inline]
    fn add_scaled(&mut self, _: impl Simd, target: Block, source: Block, scale: f64) {
        self.replace(target, &(self.block(target) + scale * self.block(source)));
    }

    #[inline]
    fn transform(&mut self, block: Block, m: &Matrix3<f64>) {
        self.replace(block, &(m * self.block(block)));
    }
}

impl FilterRecorder for ClonedErrors {
    #[inline]
    fn transition(&mut self, simd: impl Simd, transition: &Transition, _: &Noise) {
        simd.vectorize(Propagate { cross: &mut self.cross, transition });
        transition.apply_earth_rate(self);
    }

    #[inline]
    fn inflate(&mut self, _: Block, _: f64) {}

    #[inline]
    fn couple(&mut self, simd: impl Simd, m: &Matrix3<f64>) {
        self.add_transformed(simd, Block::Attitude, Block::AccelBias, m);
    }

    #[inline]
    fn observation(&mut self, simd: impl Simd, observation: &Observation) {
        simd.vectorize(Reduce { cross: &mut self.cross, observation });
    }

    #[inline]
    fn reset_block(&mut self, block: Block, _: &Vector3<f64>) {
        self.cross[block.index()] = Block3::default();
    }
}

/// X becomes F X, without Earth rate.
struct Propagate<'a> {
    cross: &'a mut Columns,
    transition: &'a Transition,
}

impl WithSimd for Propagate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (half, tilt, bias) = self.transition.factors();
        move_columns(simd, self.cross, half, &tilt, &bias);
    }
}

/// X becomes (I - K H) X.
struct Reduce<'a> {
    cross: &'a mut Columns,
    observation: &'a Observation,
}

impl WithSimd for Reduce<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Observation { block, whitener, whitened_gain, .. } = self.observation;
        reduce_columns(simd, self.cross, block.index(), whitener, whitened_gain);
    }
}

#[cfg(test)]
mod tests {
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
            for state in (first..first + 3)
                .filter(|&state| self.axis.is_none_or(|axis| first + axis == state))
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
}
