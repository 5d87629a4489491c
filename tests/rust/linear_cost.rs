//! However long a stream was, its detector says what one says that saw the last seconds only.

use footnav::config::DetectorConfig;
use footnav::detectors::{Decision, Detector};
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};
use footnav::{Config, ImuSample};

const RATE: f64 = 200.0;
const SAMPLES: usize = 1_000_000;
/// Samples that the other detector sees: more than any detector remembers.
const LAST: usize = 20_000;
/// Decisions that are compared.
const COMPARED: usize = 2_000;

/// A walk whose end leads to its beginning, again and again.
fn endless_walk() -> impl Iterator<Item = ImuSample> + Clone {
    let settings = SimulationSettings { rate_hz: RATE, seed: 1, ..SimulationSettings::default() };
    let walk =
        simulate(&Route::square(10.0), &Gait::walk(), &SensorErrors::mpu6050(), &settings).unwrap();
    let mut time = 0.0;
    walk.samples.into_iter().cycle().map(move |sample| {
        time += 1.0 / RATE;
        ImuSample { time, ..sample }
    })
}

fn decisions(
    mut detector: Box<dyn Detector>,
    samples: impl Iterator<Item = ImuSample>,
) -> Vec<Decision> {
    samples.filter_map(|sample| detector.push(&sample)).collect()
}

#[test]
fn the_statistic_after_a_million_samples_is_that_of_the_last_window_taken_afresh() {
    // The graph of a window is built afresh at every sample: it keeps no sums.
    let keeps_sums = |detector: &DetectorConfig| detector.kind() != "graph-theoretic";
    for detector in DetectorConfig::all().into_iter().filter(keeps_sums) {
        let build = || detector.build(RATE, Config::default().gravity());
        let streamed = decisions(build(), endless_walk().take(SAMPLES));
        let afresh = decisions(build(), endless_walk().take(SAMPLES).skip(SAMPLES - LAST));
        let last = |decisions: &[Decision]| decisions[decisions.len() - COMPARED..].to_vec();
        for (long, short) in last(&streamed).iter().zip(last(&afresh)) {
            let apart = (long.statistic - short.statistic).abs();
            assert!(apart <= 1e-9 * short.statistic.max(1e-3), "{detector:?}: {long:?} {short:?}");
            assert_eq!(long.stationary, short.stationary, "{detector:?}");
        }
    }
}
