use nalgebra::{SMatrix, SVector, UnitQuaternion};
use proptest::prelude::*;

use super::*;
use crate::filter::error_state::{ErrorStates, STATES};
use crate::ins::strapdown::StrapdownStep;
use crate::math::simd::Baseline;
use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::solution::Estimate;

type Dense = SMatrix<f64, STATES, STATES>;
type States = SVector<f64, STATES>;

const BLOCK_SIZE: usize = 3;
const NOISE: f64 = 1.0e-3;
/// Errors so small that composing rotations is adding them.
const SMALL: f64 = 1.0e-6;

/// One row of a random linear system: how the states move, which block is observed, on one axis
/// or on all, and the innovations.
#[derive(Clone, Debug)]
struct Move {
    step: StrapdownStep,
    coupling: Option<Matrix3<f64>>,
    block: Block,
    axis: Option<usize>,
    reading: Vector3<f64>,
}

impl Move {
    /// The same in less time, so that many of them stay within the linear range.
    fn in_a_few_milliseconds(mut self) -> Self {
        self.step.dt = 0.005;
        self
    }
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
        .prop_map(|(force, turn, coupling, block, axis, reading)| Move {
            step: StrapdownStep {
                dt: 0.1,
                velocity_increment_n: 0.1 * force,
                attitude: UnitQuaternion::from_scaled_axis(turn).to_rotation_matrix().into_inner(),
            },
            coupling: coupling.map(|v| crate::math::rotation::cross_matrix(&v)),
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
    Solution {
        estimate,
        position_std: Vector3::zeros(),
        zero_velocity: true,
        flags: Flags::empty(),
    }
}

fn states(solution: &Solution) -> States {
    let Estimate { nav, gyro_bias, accel_bias } = solution.estimate;
    flat(&ErrorStates([
        nav.position,
        nav.velocity,
        nav.attitude.scaled_axis(),
        gyro_bias,
        accel_bias,
    ]))
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
            if let Some(m) = &step.coupling {
                states.add_transformed(Baseline, Block::Attitude, Block::AccelBias, m);
            }
            transition.apply(Baseline, states);
        });
        (x, p) = (f * x, f * p * f.transpose() + Dense::identity() * NOISE);
        let predicted = (x, p);
        for axis in (0..BLOCK_SIZE).filter(|&axis| step.axis.is_none_or(|only| only == axis)) {
            let h = SMatrix::<f64, 1, STATES>::from_fn(|_, k| {
                f64::from(
                    k == BLOCK_SIZE * Block::ALL.iter().position(|&b| b == step.block).unwrap()
                        + axis,
                )
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

/// The same system through the blocks and the recorder.
fn walk(segment: &mut Segment, moves: &[Move], rows: &[DenseRow]) -> Vec<Solution> {
    let mut solutions = Vec::new();
    let mut p = Covariance::zero();
    for block in Block::ALL {
        p.add_variance(block, 1.0);
    }
    let mut x = States::zeros();
    let noise = Noise {
        velocity: NOISE,
        attitude: NOISE,
        gyro_bias: NOISE,
        accel_bias: NOISE,
        ..Noise::default()
    };
    for (step, row) in moves.iter().zip(rows) {
        let transition = Transition::new(&step.step, &Vector3::new(0.0, 0.02, 0.03));
        if let Some(m) = &step.coupling {
            p.add_transformed(Baseline, Block::Attitude, Block::AccelBias, m);
            segment.couple(Baseline, m);
        }
        p.predict(Baseline, &transition, &noise);
        segment.transition(Baseline, &transition, &noise);
        p.add_variance(Block::Position, NOISE);
        segment.inflate(Block::Position, NOISE);
        x = row.f * x;
        let first = BLOCK_SIZE * Block::ALL.iter().position(|&b| b == step.block).unwrap();
        let innovation = step.reading - x.fixed_rows::<3>(first);
        let (r, mut used) = (Matrix3::from_diagonal_element(NOISE), None);
        match step.axis {
            None => p.observe(Baseline, step.block, &innovation, &r, f64::INFINITY, &mut used),
            Some(axis) => {
                let (state, innovation) = ((step.block, axis), innovation[axis]);
                p.observe_axis(Baseline, state, innovation, NOISE, f64::INFINITY, &mut used)
            }
        };
        let observation = used.unwrap();
        segment.observation(Baseline, &observation);
        x += flat(&observation.errors());
        segment.push(&p);
        solutions.push(solution(&x));
    }
    solutions
}

fn smooth(mut segment: Segment, mut solutions: Vec<Solution>) -> Vec<Solution> {
    while segment.len() > 0 {
        let open = segment.len();
        segment.smooth_window(Baseline, solutions[..open].iter_mut().rev());
    }
    solutions
}

#[test]
fn a_step_takes_the_memory_that_the_documentation_says() {
    assert_eq!((size_of::<Step>(), size_of::<Solution>()), (184, 168));
    assert_eq!(size_of::<Covariance>() / WINDOW + size_of::<usize>(), 30);
}

proptest! {
    #[test]
    fn it_is_the_smoother_of_rauch_tung_and_striebel(moves in moves()) {
        let rows = dense_filter(&moves, States::zeros(), Dense::identity());
        let mut segment = Segment::default();
        let filtered = walk(&mut segment, &moves, &rows);
        let smoothed = smooth(segment, filtered);
        prop_assert_eq!(smoothed.len(), moves.len());
        for (ours, (states_there, covariance)) in smoothed.iter().zip(dense_smoother(&rows)) {
            prop_assert!((states(ours) - states_there).norm() < 1e-5 * SMALL.max(states_there.norm()));
            let std = covariance.diagonal().fixed_rows::<3>(0).map(f64::sqrt);
            prop_assert!((ours.position_std - std).norm() < 1e-8 * std.norm());
        }
    }

    #[test]
    fn later_samples_do_not_smooth_over_a_reset(moves in moves()) {
        let rows = dense_filter(&moves, States::zeros(), Dense::identity());
        let (mut alone, mut followed) = (Segment::default(), Segment::default());
        let filtered = walk(&mut alone, &moves, &rows);
        walk(&mut followed, &moves, &rows);
        for block in Block::ALL {
            followed.reset_block(block, &Vector3::repeat(1.0));
        }
        walk(&mut followed, &moves, &rows);
        let twice = [&filtered[..], &filtered[..]].concat();
        prop_assert_eq!(&smooth(followed, twice)[..moves.len()], &smooth(alone, filtered)[..]);
    }
}
proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn windows_change_nothing(moves in moves()) {
        let moves: Vec<Move> =
            moves.into_iter().cycle().take(2 * WINDOW + 3).map(Move::in_a_few_milliseconds).collect();
        let rows = dense_filter(&moves, States::zeros(), Dense::identity());
        let mut segment = Segment::default();
        let filtered = walk(&mut segment, &moves, &rows);
        let smoothed = smooth(segment, filtered);
        for (ours, (states_there, covariance)) in smoothed.iter().zip(dense_smoother(&rows)) {
            prop_assert!((states(ours) - states_there).norm() < 1e-5 * SMALL.max(states_there.norm()));
            let std = covariance.diagonal().fixed_rows::<3>(0).map(f64::sqrt);
            prop_assert!((ours.position_std - std).norm() < 1e-8 * std.norm());
        }
    }
}
