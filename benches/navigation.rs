//! Cost of each stage per sample, on a walk simulated with a fixed seed: `cargo bench`.
//!
//! Compare ratios within one run; machines are noisy.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use footnav::config::{DetectorConfig, ShoeConfig, SmootherConfig, SmootherKind};
use footnav::decide_all;
use footnav::filter::bench::Step;
use footnav::ins::strapdown::{Increments, MechanizationKind, Strapdown, StrapdownStep};
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};
use footnav::types::nav_state::NavState;
use footnav::{Batch, Config, ImuSample, Navigator, track};
use nalgebra::{Matrix3, SMatrix, UnitQuaternion, Vector3};

const RATE: f64 = 200.0;

type Dense = SMatrix<f64, 15, 15>;

fn samples(seed: u64) -> Vec<ImuSample> {
    let settings = SimulationSettings { rate_hz: RATE, seed, ..SimulationSettings::default() };
    let walk = simulate(&Route::square(10.0), &Gait::walk(), &SensorErrors::mpu6050(), &settings);
    walk.expect("the presets are valid").samples
}

fn strapdown(criterion: &mut Criterion) {
    let samples = samples(1);
    let mut group = criterion.benchmark_group("strapdown");
    group.throughput(Throughput::Elements(samples.len() as u64));
    for kind in [
        MechanizationKind::TwoSample,
        MechanizationKind::SingleSample,
        MechanizationKind::FirstOrder,
    ] {
        let strapdown = Strapdown {
            kind,
            gravity: 9.81,
            earth_rate: Vector3::zeros(),
            nominal_interval: 1.0 / RATE,
        };
        group.bench_function(format!("{kind:?}"), |bencher| {
            bencher.iter(|| {
                let mut state = NavState::at_rest(0.0, UnitQuaternion::identity());
                let mut before =
                    Increments { dt: 0.0, angle: Vector3::zeros(), velocity: Vector3::zeros() };
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
    let samples = samples(1);
    let mut group = criterion.benchmark_group("detector");
    group.throughput(Throughput::Elements(samples.len() as u64));
    for detector in DetectorConfig::all() {
        let name = detector.kind();
        let config = Config { detector, ..Config::default() };
        group.bench_function(name, |bencher| {
            bencher.iter(|| decide_all(&config, RATE, black_box(&samples)));
        });
    }
}

/// A fully populated covariance.
fn propagated_covariance() -> Step {
    let step = StrapdownStep {
        dt: 1.0 / RATE,
        velocity_increment_n: Vector3::new(1.0, 2.0, 9.8) / RATE,
        attitude: Matrix3::identity(),
    };
    let mut step = Step::new(&step, [0.1; 5], [2e-3, 2e-5, 2e-8, 2e-6]);
    (0..5).for_each(|_| step.predict());
    step
}

fn prediction(criterion: &mut Criterion) {
    let step = propagated_covariance();
    let mut group = criterion.benchmark_group("prediction");
    group.bench_function("blocks", |bencher| {
        bencher.iter_batched_ref(
            || step.clone(),
            |step| black_box(step).predict(),
            BatchSize::SmallInput,
        );
    });
    group.bench_function("dense", |bencher| {
        let (f, q) = (Dense::identity() + 0.01 * Dense::repeat(1.0), Dense::identity());
        let p = step.covariance().dense();
        bencher.iter(|| black_box(&f) * black_box(&p) * f.transpose() + q);
    });
}

fn zero_velocity(criterion: &mut Criterion) {
    let step = propagated_covariance();
    let mut group = criterion.benchmark_group("zero velocity");
    group.bench_function("blocks", |bencher| {
        let innovation = Vector3::new(0.01, -0.02, 0.01);
        bencher.iter_batched_ref(
            || step.clone(),
            |step| black_box(step).observe_velocity(&innovation, 1.0e-4),
            BatchSize::SmallInput,
        );
    });
    group.bench_function("dense", |bencher| {
        let mut h = SMatrix::<f64, 3, 15>::zeros();
        h.fixed_columns_mut::<3>(3).fill_with_identity();
        let r = Matrix3::from_diagonal_element(1.0e-4);
        let p = step.covariance().dense();
        bencher.iter(|| {
            let p = black_box(&p);
            let k = (h * p * h.transpose() + r)
                .try_inverse()
                .map(|inverse| p * h.transpose() * inverse);
            k.map(|k| {
                (Dense::identity() - k * h) * p * (Dense::identity() - k * h).transpose()
                    + k * r * k.transpose()
            })
        });
    });
}

/// Settings by the name in the results.
fn settings() -> [(&'static str, Config); 4] {
    let shoe =
        Config { detector: DetectorConfig::Shoe(ShoeConfig::default()), ..Config::default() };
    let mut strides = Config::default();
    strides.output.strides = true;
    let smoother = SmootherConfig { kind: SmootherKind::Stepwise, ..SmootherConfig::default() };
    let stepwise = Config { smoother, ..Config::default() };
    [("shoe", shoe), ("default", Config::default()), ("strides", strides), ("stepwise", stepwise)]
}

/// All stages, sample by sample.
fn push(criterion: &mut Criterion) {
    let samples = samples(1);
    let mut group = criterion.benchmark_group("push");
    group.throughput(Throughput::Elements(samples.len() as u64));
    for (name, config) in settings() {
        let mut navigator = Navigator::new(config, RATE).expect("the settings are valid");
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                navigator.reset();
                for sample in &samples {
                    let _ = black_box(navigator.push(sample));
                }
            });
        });
    }
}

/// All stages, over a whole recording.
fn track_recording(criterion: &mut Criterion) {
    let samples = samples(1);
    let mut group = criterion.benchmark_group("track");
    group.throughput(Throughput::Elements(samples.len() as u64));
    for (name, config) in settings() {
        group.bench_function(name, |bencher| bencher.iter(|| track(black_box(&samples), &config)));
    }
}

/// Forward pass and backward pass of the RTS smoother.
fn rts(criterion: &mut Criterion) {
    let samples = samples(1);
    let smoother = SmootherConfig { kind: SmootherKind::Rts, ..SmootherConfig::default() };
    let config = Config { smoother, ..Config::default() };
    let forward = || {
        let mut batch = Batch::new(config.clone(), RATE).expect("the settings are valid");
        batch.push_block(&samples).expect("a simulated walk can be tracked");
        batch
    };
    let mut group = criterion.benchmark_group("rts");
    group.throughput(Throughput::Elements(samples.len() as u64));
    group.bench_function("forward pass", |bencher| bencher.iter_with_large_drop(forward));
    group.bench_function("backward pass", |bencher| {
        bencher.iter_batched(forward, Batch::finish, BatchSize::PerIteration);
    });
}

/// Four walks, on one thread and on two.
fn several(criterion: &mut Criterion) {
    let recordings: Vec<_> = (1..=4).map(samples).collect();
    let config = Config::default();
    let follow = |recordings: &[Vec<ImuSample>]| {
        for samples in recordings {
            let _ = black_box(track(samples, &config));
        }
    };
    let mut group = criterion.benchmark_group("several recordings");
    group.throughput(Throughput::Elements(
        recordings.iter().map(|samples| samples.len() as u64).sum(),
    ));
    group.bench_function("one thread", |bencher| bencher.iter(|| follow(&recordings)));
    group.bench_function("two threads", |bencher| {
        let (first, second) = recordings.split_at(2);
        bencher.iter(|| {
            std::thread::scope(|scope| {
                scope.spawn(|| follow(first));
                follow(second);
            });
        });
    });
}

criterion_group!(
    benches,
    strapdown,
    detectors,
    prediction,
    zero_velocity,
    push,
    track_recording,
    rts,
    several
);
criterion_main!(benches);
