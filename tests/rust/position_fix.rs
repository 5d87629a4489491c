//! Position fixes: their weight, their innovation test, and their stamps.

use footnav::aiding::position_fix::PositionFix;
use footnav::config::{FilterConfig, FilterKind, SmootherConfig, SmootherKind};
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, Walk, simulate};
use footnav::types::nav_state::NavState;
use footnav::{Batch, Config, Health, Navigator, Trajectory};

const RATE: f64 = 100.0;

/// A square of 20 m with an MPU6050, whose dead reckoning drifts by decimetres.
fn walk() -> Walk {
    let settings = SimulationSettings { rate_hz: RATE, seed: 5, ..SimulationSettings::default() };
    simulate(&Route::square(20.0), &Gait::walk(), &SensorErrors::mpu6050(), &settings).unwrap()
}

fn fix(truth: &NavState, offset: [f64; 3], std: f64) -> PositionFix {
    let p = truth.position;
    let variance = std * std;
    let covariance = [[variance, 0.0, 0.0], [0.0, variance, 0.0], [0.0, 0.0, variance]];
    let position = [p.x + offset[0], p.y + offset[1], p.z + offset[2]];
    PositionFix::new(truth.time, position, covariance).unwrap()
}

fn track(walk: &Walk, config: Config, fixes: &[PositionFix]) -> (Trajectory, Health) {
    let mut batch = Batch::new(config, RATE).unwrap();
    for fix in fixes {
        batch.push_reading(*fix);
    }
    batch.push_block(&walk.samples).unwrap();
    let (trajectory, health, _) = batch.finish().unwrap();
    (trajectory, health)
}

/// Distance from the truth at each row, m.
fn errors(walk: &Walk, trajectory: &Trajectory) -> Vec<f64> {
    let rows = trajectory.position.iter().zip(&walk.truth);
    rows.map(|(p, truth)| (nalgebra::Vector3::from(*p) - truth.position).norm()).collect()
}

/// Every second, from 3 s after the start.
fn every_second(walk: &Walk) -> impl Iterator<Item = &NavState> {
    walk.truth.iter().skip(300).step_by(100)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

#[test]
fn fixes_hold_the_track_and_its_uncertainty_down() {
    let walk = walk();
    let fixes: Vec<_> = every_second(&walk).map(|truth| fix(truth, [0.0; 3], 0.02)).collect();
    let (alone, _) = track(&walk, Config::default(), &[]);
    let (aided, health) = track(&walk, Config::default(), &fixes);
    let count = health.counters.updates.position_fix;
    assert_eq!((count.accepted, count.rejected), (fixes.len() as u64, 0));
    assert!(largest(&errors(&walk, &aided)) < 0.1);
    assert!(largest(&errors(&walk, &aided)) < 0.5 * largest(&errors(&walk, &alone)));
    let [std, std_alone] = [&aided, &alone].map(|t| t.position_std.last().unwrap()[0]);
    assert!(std < 0.05 && std < 0.5 * std_alone, "{std} {std_alone}");
}

#[test]
fn a_fix_of_very_large_covariance_changes_nothing() {
    let walk = walk();
    let fixes: Vec<_> = every_second(&walk).map(|truth| fix(truth, [3.0; 3], 1e6)).collect();
    let step_by_step = FilterConfig { covariance_interval: 0.0, ..FilterConfig::default() };
    let config = Config { filter: step_by_step, ..Config::default() };
    let (alone, _) = track(&walk, config.clone(), &[]);
    let (aided, health) = track(&walk, config, &fixes);
    assert_eq!(health.counters.updates.position_fix.accepted, fixes.len() as u64);
    for (p, q) in alone.position.iter().zip(&aided.position) {
        assert!((0..3).all(|axis| (p[axis] - q[axis]).abs() < 1e-9));
    }
}

#[test]
fn a_wrong_fix_is_rejected_and_counted() {
    let walk = walk();
    let mut fixes: Vec<_> = every_second(&walk).map(|truth| fix(truth, [0.0; 3], 0.1)).collect();
    let (right, _) = track(&walk, Config::default(), &fixes);
    let wrong = every_second(&walk).nth(10).unwrap();
    fixes[10] = fix(wrong, [20.0, 0.0, 0.0], 0.1);
    let (aided, health) = track(&walk, Config::default(), &fixes);
    let count = health.counters.updates.position_fix;
    assert_eq!((count.accepted, count.rejected), (fixes.len() as u64 - 1, 1));
    let moved = right.position.iter().zip(&aided.position);
    let moved: Vec<f64> = moved.map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).collect();
    assert!(largest(&moved) < 0.2, "{}", largest(&moved));
}

#[test]
fn a_late_fix_is_rejected_and_counted() {
    let walk = walk();
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    let late = fix(&walk.truth[400], [0.0; 3], 0.1);
    for (row, sample) in walk.samples.iter().enumerate() {
        navigator.push(sample).unwrap();
        if row == 800 {
            navigator.push_reading(late);
        }
    }
    let count = navigator.health().counters.updates.position_fix;
    assert_eq!((count.accepted, count.rejected), (0, 1));
}

#[test]
fn a_stream_gives_the_track_of_a_batch_to_the_bit() {
    let walk = walk();
    let fixes: Vec<_> = every_second(&walk).map(|truth| fix(truth, [0.1; 3], 0.2)).collect();
    let (batch, _) = track(&walk, Config::default(), &fixes);
    let mut navigator = Navigator::new(Config::default(), RATE).unwrap();
    let mut stream = Trajectory::default();
    let mut left = fixes.as_slice();
    for block in walk.samples.chunks(37) {
        let until = block.last().unwrap().time;
        let due = left.iter().take_while(|fix| fix.time() <= until).count();
        for fix in &left[..due] {
            navigator.push_reading(*fix);
        }
        left = &left[due..];
        navigator.push_block_into(block, &mut stream).unwrap();
    }
    navigator.flush_into(&mut stream).unwrap();
    assert_eq!(stream, batch);
}

#[test]
fn a_smoother_corrects_the_track_before_a_fix() {
    let walk = walk();
    let last = fix(walk.truth.last().unwrap(), [0.0; 3], 0.01);
    let smoother = SmootherConfig { kind: SmootherKind::Rts, ..SmootherConfig::default() };
    let config = Config { smoother, ..Config::default() };
    let (alone, _) = track(&walk, config.clone(), &[]);
    let (aided, health) = track(&walk, config, &[last]);
    assert_eq!(health.counters.updates.position_fix.accepted, 1);
    let [sum_alone, sum_aided] = [&alone, &aided].map(|t| errors(&walk, t).iter().sum::<f64>());
    assert!(sum_aided < 0.7 * sum_alone, "{sum_aided} {sum_alone}");
}

#[test]
fn without_a_kalman_filter_fixes_are_not_used() {
    let walk = walk();
    let filter = FilterConfig { kind: FilterKind::Dr, ..FilterConfig::default() };
    let config = Config { filter, ..Config::default() };
    let fixes: Vec<_> = every_second(&walk).map(|truth| fix(truth, [0.0; 3], 0.1)).collect();
    let (alone, _) = track(&walk, config.clone(), &[]);
    assert_eq!(track(&walk, config, &fixes).0, alone);
}
