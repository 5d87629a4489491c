//! Cost of the Allan deviation of one channel: `cargo bench --bench allan`.

use std::convert::Infallible;
use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use footnav::allan::{Curve, Integral};
use footnav::simulation::{SensorErrors, SimulationSettings, rest};

const SAMPLES: u32 = 1_000_000;

fn channel() -> Vec<f64> {
    let settings = SimulationSettings { rate_hz: 200.0, ..SimulationSettings::default() };
    let samples = rest(f64::from(SAMPLES) / settings.rate_hz, &SensorErrors::mpu6050(), &settings);
    samples.expect("the preset is valid").iter().map(|sample| sample.angular_rate.z).collect()
}

fn allan(criterion: &mut Criterion) {
    let samples = channel();
    let mut group = criterion.benchmark_group("allan");
    group.sample_size(10).throughput(Throughput::Elements(samples.len() as u64));
    group.bench_function("integral", |bencher| bencher.iter(|| Integral::new(black_box(&samples))));
    group.bench_function("one averaging time", |bencher| {
        let integral = Integral::new(&samples);
        bencher.iter(|| integral.deviation(black_box(1000)));
    });
    group.bench_function("curve", |bencher| {
        bencher.iter(|| Curve::of(black_box(&samples), |_| Ok::<(), Infallible>(())));
    });
}

criterion_group!(benches, allan);
criterion_main!(benches);
