//! Navigation allocates no memory in steady state.

use allocation_counter::measure;
use footnav::config::{DetectorConfig, ShoeConfig, SmootherConfig, SmootherKind};
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};
use footnav::{Config, ImuSample, Navigator};

const RATE: f64 = 200.0;

fn samples() -> Vec<ImuSample> {
    let settings = SimulationSettings { rate_hz: RATE, seed: 1, ..SimulationSettings::default() };
    simulate(&Route::square(10.0), &Gait::walk(), &SensorErrors::mpu6050(), &settings)
        .unwrap()
        .samples
}

/// Allocations of a stream that repeats the same walk, after the first round.
fn allocations_after_the_first_round(config: Config, rounds: u32) -> u64 {
    let samples = samples();
    let mut navigator = Navigator::new(config, RATE).unwrap();
    let duration = samples.last().unwrap().time - samples[0].time + 1.0 / RATE;
    let mut round = |number: u32| {
        for sample in &samples {
            let time = sample.time + f64::from(number) * duration;
            navigator.push(&ImuSample { time, ..*sample }).unwrap();
        }
    };
    round(0);
    measure(|| (1..=rounds).for_each(&mut round)).count_total
}

#[test]
fn a_stream_allocates_nothing_in_steady_state() {
    let shoe =
        Config { detector: DetectorConfig::Shoe(ShoeConfig::default()), ..Config::default() };
    let stepwise = SmootherConfig { kind: SmootherKind::Stepwise, ..SmootherConfig::default() };
    let stepwise = Config { smoother: stepwise, ..Config::default() };
    for config in [Config::default(), shoe, stepwise] {
        assert_eq!(allocations_after_the_first_round(config.clone(), 3), 0, "{config:?}");
    }
}
