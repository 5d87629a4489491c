//! A stretch of the walk, as the forward pass leaves it and the backward pass goes back over it.

use nalgebra::{Matrix3, Vector3};

use crate::filter::covariance::{Covariance, PackedCovariance};
use crate::filter::journal::Journal;
use crate::filter::observation::Observation;
use crate::filter::states::{Block, ErrorStates, Linear};
use crate::filter::transition::Transition;
use crate::navigator::Solution;

/// The solutions of a stretch of the walk with the steps that led from each to the next.
#[derive(Debug, Default)]
pub(crate) struct Segment {
    rows: Vec<Row>,
    steps: Vec<Step>,
    observations: Vec<Observation>,
}

/// A solution, the covariance of its errors, and how many steps had been taken by then.
#[derive(Debug)]
struct Row {
    solution: Solution,
    covariance: PackedCovariance,
    steps: usize,
}

/// One step of the filter.
#[derive(Debug)]
enum Step {
    Transition(Transition),
    Tie(Matrix3<f64>),
    /// The next of the segment's observations.
    Observation,
    Forget(Block),
}

impl Journal for Segment {
    fn transition(&mut self, transition: &Transition) {
        self.steps.push(Step::Transition(*transition));
    }

    fn tie(&mut self, m: &Matrix3<f64>) {
        self.steps.push(Step::Tie(*m));
    }

    fn observation(&mut self, observation: &Observation) {
        self.observations.push(*observation);
        self.steps.push(Step::Observation);
    }

    fn forget(&mut self, block: Block) {
        self.steps.push(Step::Forget(block));
    }
}

impl Segment {
    /// With room for the solutions of a step, each with a transition and two observations.
    pub(crate) fn with_capacity(solutions: usize) -> Self {
        Self {
            rows: Vec::with_capacity(solutions),
            steps: Vec::with_capacity(3 * solutions),
            observations: Vec::with_capacity(2 * solutions),
        }
    }

    /// Appends the solution that the steps since the last one led to.
    pub(crate) fn push(&mut self, solution: &Solution, covariance: &Covariance) {
        self.rows.push(Row { solution: *solution, covariance: covariance.packed(), steps: self.steps.len() });
    }

    /// Number of solutions.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Smooths all solutions and hands them out in their order; the segment is empty afterwards and keeps its memory.
    pub(crate) fn smooth(&mut self) -> impl Iterator<Item = Solution> {
        let mut later = Later::default();
        let mut observations = self.observations.drain(..).rev();
        let mut steps = self.steps.len();
        for row in self.rows.iter_mut().rev() {
            for step in self.steps[row.steps..steps].iter().rev() {
                match step {
                    Step::Transition(transition) => later.transition(transition),
                    Step::Tie(m) => later.tie(m),
                    Step::Observation => observations.next().iter().for_each(|one| later.observation(one)),
                    Step::Forget(block) => later.forget(*block),
                }
            }
            steps = row.steps;
            later.improve(&mut row.solution, &row.covariance.unpacked());
        }
        self.steps.clear();
        self.rows.drain(..).map(|row| row.solution)
    }
}

/// What later samples tell of the errors at one instant.
#[derive(Debug)]
struct Later {
    costate: ErrorStates,
    information: Covariance,
}

impl Default for Later {
    fn default() -> Self {
        Self { costate: ErrorStates::default(), information: Covariance::zero() }
    }
}

impl Later {
    fn transition(&mut self, transition: &Transition) {
        transition.apply_transposed(&mut self.costate);
        transition.apply_transposed(&mut self.information);
    }

    fn tie(&mut self, m: &Matrix3<f64>) {
        self.costate.add_transformed(Block::AccelBias, Block::Attitude, &m.transpose());
        self.information.add_transformed(Block::AccelBias, Block::Attitude, &m.transpose());
    }

    fn observation(&mut self, observation: &Observation) {
        observation.costate_before(&mut self.costate);
        observation.information_before(&mut self.information);
    }

    fn forget(&mut self, block: Block) {
        *self.costate.block_mut(block) = Vector3::zeros();
        self.information.replace(block, 0.0);
    }

    /// Corrects a solution by what later samples tell of it.
    fn improve(&self, solution: &mut Solution, covariance: &Covariance) {
        let costate = ErrorStates(self.costate.0.map(|part| -part));
        solution.estimate.correct(&covariance.times_states(&costate));
        let variance = covariance.diagonal_given(Block::Position, &self.information);
        solution.position_std = variance.map(|v| v.max(0.0).sqrt());
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{SMatrix, SVector, UnitQuaternion};
    use proptest::prelude::*;

    use super::*;
    use crate::detector::Decision;
    use crate::filter::Estimate;
    use crate::filter::states::STATES;
    use crate::health::Reasons;
    use crate::strapdown::{NavState, Step as StrapdownStep};

    type Dense = SMatrix<f64, STATES, STATES>;
    type States = SVector<f64, STATES>;

    const BLOCK_SIZE: usize = 3;
    const NOISE: f64 = 1.0e-3;
    /// Errors so small that composing rotations is adding them.
    const SMALL: f64 = 1.0e-6;

    /// One row of a random linear system: how the states move, which block is observed, on one axis or on all, and the innovations.
    #[derive(Clone, Debug)]
    struct Move {
        step: StrapdownStep,
        tie: Option<Matrix3<f64>>,
        block: Block,
        axis: Option<usize>,
        reading: Vector3<f64>,
    }

    fn vectors(range: std::ops::Range<f64>) -> impl Strategy<Value = Vector3<f64>> {
        [range.clone(), range.clone(), range].prop_map(Vector3::from)
    }

    fn moves() -> impl Strategy<Value = Vec<Move>> {
        let one = (
            vectors(-10.0..10.0),
            vectors(-3.0..3.0),
            prop::option::of(vectors(-0.1..0.1)),
            prop::sample::select(&Block::ALL[..]),
            prop::option::of(0_usize..3),
            vectors(-1.0..1.0),
        )
            .prop_map(|(force, turn, tie, block, axis, reading)| Move {
                step: StrapdownStep {
                    dt: 0.1,
                    specific_force: force,
                    attitude: UnitQuaternion::from_scaled_axis(turn).to_rotation_matrix().into_inner(),
                },
                tie: tie.map(|v| crate::rotation::cross_matrix(&v)),
                block,
                axis,
                reading: SMALL * reading,
            });
        prop::collection::vec(one, 2..8)
    }

    fn dense_of(apply: impl Fn(&mut ErrorStates)) -> Dense {
        let mut dense = Dense::zeros();
        for column in 0..STATES {
            let mut states = ErrorStates::default();
            states.0[column / BLOCK_SIZE][column % BLOCK_SIZE] = 1.0;
            apply(&mut states);
            dense.set_column(column, &flat(&states));
        }
        dense
    }

    fn flat(states: &ErrorStates) -> States {
        States::from_fn(|k, _| states.0[k / BLOCK_SIZE][k % BLOCK_SIZE])
    }

    fn solution(states: &States) -> Solution {
        let part = |k: usize| Vector3::new(states[k], states[k + 1], states[k + 2]);
        let nav = NavState {
            time: 0.0,
            position: part(0),
            velocity: part(3),
            attitude: UnitQuaternion::from_scaled_axis(part(6)),
        };
        let estimate = Estimate { nav, gyro_bias: part(9), accel_bias: part(12) };
        let decision = Decision { stationary: true, statistic: 0.0, threshold: 0.0 };
        Solution {
            estimate,
            position_std: Vector3::zeros(),
            zero_velocity: decision.stationary,
            reasons: Reasons::empty(),
        }
    }

    fn states(solution: &Solution) -> States {
        let Estimate { nav, gyro_bias, accel_bias } = solution.estimate;
        flat(&ErrorStates([nav.position, nav.velocity, nav.attitude.scaled_axis(), gyro_bias, accel_bias]))
    }

    /// What a dense filter and the smoother of Rauch, Tung and Striebel keep of one row.
    struct DenseRow {
        f: Dense,
        predicted: (States, Dense),
        filtered: (States, Dense),
    }

    #[expect(clippy::many_single_char_names, reason = "the symbols of the equations")]
    fn dense_filter(moves: &[Move], mut x: States, mut p: Dense) -> Vec<DenseRow> {
        let mut rows = Vec::new();
        for step in moves {
            let transition = Transition::new(&step.step, &Vector3::new(0.0, 0.02, 0.03));
            let f = dense_of(|states| {
                transition.apply(states);
                if let Some(m) = &step.tie {
                    states.add_transformed(Block::Attitude, Block::AccelBias, m);
                }
            });
            (x, p) = (f * x, f * p * f.transpose() + Dense::identity() * NOISE);
            let predicted = (x, p);
            for axis in (0..BLOCK_SIZE).filter(|&axis| step.axis.is_none_or(|only| only == axis)) {
                let h = SMatrix::<f64, 1, STATES>::from_fn(|_, k| {
                    f64::from(k == BLOCK_SIZE * Block::ALL.iter().position(|&b| b == step.block).unwrap() + axis)
                });
                let s = (h * p * h.transpose())[0] + NOISE;
                let k = p * h.transpose() / s;
                x += k * (step.reading[axis] - (h * x)[0]);
                let rest = Dense::identity() - k * h;
                p = rest * p * rest.transpose() + k * k.transpose() * NOISE;
            }
            rows.push(DenseRow { f, predicted, filtered: (x, p) });
        }
        rows
    }

    fn dense_smoother(rows: &[DenseRow]) -> Vec<(States, Dense)> {
        let mut smoothed = vec![rows.last().unwrap().filtered];
        for pair in rows.windows(2).rev() {
            let (now, next) = (&pair[0], &pair[1]);
            let (x, p) = smoothed.last().unwrap();
            let gain = now.filtered.1 * next.f.transpose() * next.predicted.1.try_inverse().unwrap();
            let states = now.filtered.0 + gain * (x - next.predicted.0);
            let covariance = now.filtered.1 + gain * (p - next.predicted.1) * gain.transpose();
            smoothed.push((states, covariance));
        }
        smoothed.reverse();
        smoothed
    }

    /// The same system through the blocks and the journal.
    fn walk(segment: &mut Segment, moves: &[Move], rows: &[DenseRow]) {
        let mut p = Covariance::zero();
        for block in Block::ALL {
            p.add_variance(block, 1.0);
        }
        let mut x = States::zeros();
        for (step, row) in moves.iter().zip(rows) {
            let transition = Transition::new(&step.step, &Vector3::new(0.0, 0.02, 0.03));
            transition.apply(&mut p);
            segment.transition(&transition);
            if let Some(m) = &step.tie {
                p.add_transformed(Block::Attitude, Block::AccelBias, m);
                segment.tie(m);
            }
            for block in Block::ALL {
                p.add_variance(block, NOISE);
            }
            x = row.f * x;
            let first = BLOCK_SIZE * Block::ALL.iter().position(|&b| b == step.block).unwrap();
            let innovation = step.reading - x.fixed_rows::<3>(first);
            let (_, observation) = match step.axis {
                None => p.observe(step.block, &innovation, NOISE, f64::INFINITY),
                Some(axis) => p.observe_axis(step.block, axis, innovation[axis], NOISE, f64::INFINITY),
            };
            let observation = observation.unwrap();
            segment.observation(&observation);
            x += flat(&observation.errors());
            segment.push(&solution(&x), &p);
        }
    }

    fn smooth(mut segment: Segment) -> Vec<Solution> {
        segment.smooth().collect()
    }

    proptest! {
        #[test]
        fn it_is_the_smoother_of_rauch_tung_and_striebel(moves in moves()) {
            let rows = dense_filter(&moves, States::zeros(), Dense::identity());
            let mut segment = Segment::default();
            walk(&mut segment, &moves, &rows);
            let smoothed = smooth(segment);
            prop_assert_eq!(smoothed.len(), moves.len());
            for (ours, (states_there, covariance)) in smoothed.iter().zip(dense_smoother(&rows)) {
                prop_assert!((states(ours) - states_there).norm() < 1e-5 * SMALL.max(states_there.norm()));
                let std = covariance.diagonal().fixed_rows::<3>(0).map(f64::sqrt);
                prop_assert!((ours.position_std - std).norm() < 1e-8 * std.norm());
            }
        }

        #[test]
        fn nothing_comes_back_over_what_was_forgotten(moves in moves()) {
            let rows = dense_filter(&moves, States::zeros(), Dense::identity());
            let (mut alone, mut followed) = (Segment::default(), Segment::default());
            walk(&mut alone, &moves, &rows);
            walk(&mut followed, &moves, &rows);
            for block in Block::ALL {
                followed.forget(block);
            }
            walk(&mut followed, &moves, &rows);
            prop_assert_eq!(&smooth(followed)[..moves.len()], &smooth(alone)[..]);
        }
    }
}
