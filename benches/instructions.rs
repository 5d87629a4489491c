//! The workload of `benches/instructions.py`: one simulated walk through [`Batch`].
//!
//! The argument is the kind of detector.  Only instructions within `follow` are counted.

use std::env;
use std::hint::black_box;

use footnav::config::{DetectorConfig, ShoeConfig};
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};
use footnav::{Batch, Config, ImuSample};

const RATE: f64 = 200.0;

fn main() {
    let detector = match env::args().nth(1).as_deref() {
        Some("shoe") => DetectorConfig::Shoe(ShoeConfig::default()),
        _ => DetectorConfig::default(),
    };
    let settings = SimulationSettings { rate_hz: RATE, seed: 1, ..SimulationSettings::default() };
    let walk = simulate(&Route::square(10.0), &Gait::walk(), &SensorErrors::mpu6050(), &settings);
    let samples = walk.expect("the presets are valid").samples;
    follow(&samples, Config { detector, ..Config::default() });
    println!("{}", samples.len());
}

/// Never inlined: the counter identifies the workload by this name.
#[inline(never)]
fn follow(samples: &[ImuSample], config: Config) {
    let mut batch = Batch::new(config, RATE).expect("the defaults are valid");
    batch.push_block(samples).expect("a simulated walk can be tracked");
    black_box(batch.finish().expect("a simulated walk can be tracked"));
}
