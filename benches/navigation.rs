//! Cost of each stage per sample, on a walk simulated with a fixed seed: `cargo bench`.
//!
//! Compare ratios within one run; machines are noisy.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use footnav::config::{
    AdaptiveShoeConfig, DetectorConfig, MagnitudeVarianceConfig, ShoeConfig, SmootherConfig, SmootherKind,
};
use footnav::detector::decide_all;
use footnav::filter::covariance::Covariance;
use footnav::filter::states::Block;
use footnav::filter::transition::{Noise, Transition};
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};
use footnav::strapdown::{Increments, MechanizationKind, NavState, Step, Strapdown};
use footnav::{Config, ImuSample, Navigator, track};
use nalgebra::{Matrix3, SMatrix, UnitQuaternion, Vector3};

const RATE: f64 = 200.0;

type Dense = SMatrix<f64, 15, 15>;

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
    let step = Step { dt: 1.0 / RATE, specific_force: Vector3::new(1.0, 2.0, 9.8), attitude: Matrix3::identity() };
    let transition = Transition::new(&step, &Vector3::zeros());
    let noise = Noise { velocity: 1e-5, attitude: 1e-7, gyro_bias: 1e-10, accel_bias: 1e-8 };
    let dense = p.dense();
    let mut group = criterion.benchmark_group("covariance");
    group.bench_function("prediction", |bencher| {
        bencher.iter_batched_ref(|| p.clone(), |p| p.predict(&transition, &noise), BatchSize::SmallInput);
    });
    group.bench_function("prediction, dense", |bencher| {
        let f = Dense::identity() + 0.01 * Dense::repeat(1.0);
        let q = Dense::identity();
        bencher.iter(|| black_box(&f) * black_box(&dense) * f.transpose() + q);
    });
    group.bench_function("zero velocity", |bencher| {
        let innovation = Vector3::new(0.01, -0.02, 0.01);
        bencher.iter_batched_ref(
            || p.clone(),
            |p| p.observe(Block::Velocity, &innovation, 1.0e-4, f64::INFINITY),
            BatchSize::SmallInput,
        );
    });
    group.bench_function("zero velocity, dense", |bencher| {
        let mut h = SMatrix::<f64, 3, 15>::zeros();
        h.fixed_columns_mut::<3>(3).fill_with_identity();
        let r = Matrix3::from_diagonal_element(1.0e-4);
        bencher.iter(|| {
            let p = black_box(&dense);
            let k = (h * p * h.transpose() + r).try_inverse().map(|inverse| p * h.transpose() * inverse);
            k.map(|k| (Dense::identity() - k * h) * p * (Dense::identity() - k * h).transpose() + k * r * k.transpose())
        });
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
    group.bench_function("track, rts", |bencher| {
        let smoother = SmootherConfig { kind: SmootherKind::Rts, ..SmootherConfig::default() };
        let config = Config { smoother, ..Config::default() };
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
