//! Cost of each stage per sample, on a walk simulated with a fixed seed: `cargo bench`.
//!
//! Compare ratios within one run; machines are noisy.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use footnav::config::{AdaptiveShoeConfig, DetectorConfig, MagnitudeVarianceConfig, ShoeConfig};
use footnav::detector::decide_all;
use footnav::filter::covariance::Covariance;
use footnav::filter::states::{Block, Linear};
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};
use footnav::strapdown::{Increments, MechanizationKind, NavState, Strapdown};
use footnav::{Config, ImuSample, Navigator, track};
use nalgebra::{Matrix3, SMatrix, UnitQuaternion, Vector3};

const RATE: f64 = 200.0;

fn samples() -> Vec<ImuSample> {
    let settings = SimulationSettings { rate_hz: RATE, seed: 1, ..SimulationSettings::default() };
    let walk = simulate(&Route::square(10.0), &Gait::walk(), &SensorErrors::mpu6050(), &settings);
    walk.expect("the presets are valid").samples
}

fn strapdown(criterion: &mut Criterion) {
    let samples = samples();
    let mut group = criterion.benchmark_group("strapdown");
    group.throughput(Throughput::Elements(samples.len() as u64));
    for kind in [MechanizationKind::TwoSample, MechanizationKind::SingleSample, MechanizationKind::FirstOrder] {
        let strapdown = Strapdown { kind, gravity: 9.81, earth_rate: Vector3::zeros(), nominal_interval: 1.0 / RATE };
        group.bench_function(format!("{kind:?}"), |bencher| {
            bencher.iter(|| {
                let mut state = NavState::at_rest(0.0, UnitQuaternion::identity());
                let mut before = Increments { dt: 0.0, angle: Vector3::zeros(), velocity: Vector3::zeros() };
                for pair in samples.windows(2) {
                    let now = strapdown.increments(&pair[0], &pair[1]);
                    strapdown.advance(&mut state, &before, &now);
                    before = now;
                }
                state
            });
        });
    }
}

fn detectors(criterion: &mut Criterion) {
    let samples = samples();
    let mut group = criterion.benchmark_group("detector");
    group.throughput(Throughput::Elements(samples.len() as u64));
    let detectors = [
        ("adaptive-shoe", DetectorConfig::AdaptiveShoe(AdaptiveShoeConfig::default())),
        ("shoe", DetectorConfig::Shoe(ShoeConfig::default())),
        ("magnitude-variance", DetectorConfig::MagnitudeVariance(MagnitudeVarianceConfig::default())),
    ];
    for (name, detector) in detectors {
        let config = Config { detector, ..Config::default() };
        group.bench_function(name, |bencher| bencher.iter(|| decide_all(&config, RATE, black_box(&samples))));
    }
}

fn covariance(criterion: &mut Criterion) {
    let mut p = Covariance::zero();
    for block in Block::ALL {
        p.add_variance(block, 0.01);
    }
    let (dt, m) = (1.0 / RATE, 0.01 * Matrix3::new(0.0, -9.8, 1.0, 9.8, 0.0, 2.0, -1.0, -2.0, 0.0));
    let mut group = criterion.benchmark_group("covariance");
    group.bench_function("prediction", |bencher| {
        bencher.iter_batched_ref(
            || p.clone(),
            |p| {
                p.add_scaled(Block::Position, Block::Velocity, dt);
                p.add_transformed(Block::Velocity, Block::Attitude, &m);
                p.add_transformed(Block::Velocity, Block::AccelBias, &m);
                p.add_transformed(Block::Attitude, Block::GyroBias, &m);
            },
            BatchSize::SmallInput,
        );
    });
    group.bench_function("prediction, dense", |bencher| {
        let mut f = SMatrix::<f64, 15, 15>::identity();
        f.fixed_view_mut::<3, 3>(0, 3).fill_diagonal(dt);
        f.fixed_view_mut::<3, 3>(3, 6).copy_from(&m);
        f.fixed_view_mut::<3, 3>(3, 12).copy_from(&m);
        f.fixed_view_mut::<3, 3>(6, 9).copy_from(&m);
        let dense = p.dense();
        bencher.iter(|| black_box(&f) * black_box(&dense) * f.transpose());
    });
    group.bench_function("zero velocity", |bencher| {
        let innovation = Vector3::new(0.01, -0.02, 0.01);
        bencher.iter_batched_ref(
            || p.clone(),
            |p| p.observe(Block::Velocity, &innovation, 1.0e-4, f64::INFINITY),
            BatchSize::SmallInput,
        );
    });
}

fn whole(criterion: &mut Criterion) {
    let samples = samples();
    let mut group = criterion.benchmark_group("whole");
    group.throughput(Throughput::Elements(samples.len() as u64));
    group.bench_function("track", |bencher| bencher.iter(|| track(black_box(&samples), &Config::default())));
    group.bench_function("track, shoe", |bencher| {
        let config = Config { detector: DetectorConfig::Shoe(ShoeConfig::default()), ..Config::default() };
        bencher.iter(|| track(black_box(&samples), &config));
    });
    group.bench_function("track, strides", |bencher| {
        let mut config = Config::default();
        config.output.strides = true;
        bencher.iter(|| track(black_box(&samples), &config));
    });
    group.bench_function("push", |bencher| {
        let mut navigator = Navigator::new(Config::default(), RATE).expect("the defaults are valid");
        bencher.iter(|| {
            navigator.reset();
            for sample in &samples {
                let _ = black_box(navigator.push(sample));
            }
        });
    });
}

criterion_group!(benches, strapdown, detectors, covariance, whole);
criterion_main!(benches);
