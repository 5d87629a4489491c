//! Decisions of a detector do not depend on the length of the preceding stream.

use footnav::config::DetectorConfig;
use footnav::detectors::{Decision, Detector};
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};
use footnav::{Config, ImuSample};

const RATE: f64 = 200.0;
const SAMPLES: usize = 1_000_000;
/// Samples of the short stream: more than the window of any detector.
const LAST: usize = 20_000;
/// Number of decisions compared.
const COMPARED: usize = 2_000;

/// An endless repetition of a closed walk.
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
fn statistic_after_a_million_samples_equals_that_of_a_fresh_detector() {
    // The graph-theoretic detector keeps no sums: it builds the graph of each window anew.
    let keeps_sums = |detector: &DetectorConfig| detector.kind() != "graph-theoretic";
    for detector in DetectorConfig::all().into_iter().filter(keeps_sums) {
        let build = || detector.build(RATE, Config::default().gravity());
        let streamed = decisions(build(), endless_walk().take(SAMPLES));
        let fresh = decisions(build(), endless_walk().take(SAMPLES).skip(SAMPLES - LAST));
        let last = |decisions: &[Decision]| decisions[decisions.len() - COMPARED..].to_vec();
        for (long, short) in last(&streamed).iter().zip(last(&fresh)) {
            let difference = (long.statistic - short.statistic).abs();
            assert!(
                difference <= 1e-9 * short.statistic.max(1e-3),
                "{detector:?}: {long:?} {short:?}"
            );
            assert_eq!(long.stationary, short.stationary, "{detector:?}");
        }
    }
}
