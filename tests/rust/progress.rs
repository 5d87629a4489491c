//! Long computations call their progress function every 10,000 samples, and its error cancels them.

use footnav::config::{SmootherConfig, SmootherKind};
use footnav::simulation::{
    Gait, Route, SensorErrors, SimulationSettings, rest, rest_with_progress, simulate,
    simulate_with_progress,
};
use footnav::{Batch, Config, ConfigError, Error, ImuSample};
use footnav::{decide_all, decide_all_with};

const RATE: f64 = 200.0;

/// Reason for the end of a computation.
#[derive(Debug, PartialEq)]
enum End {
    Cancelled,
    Failure(Error),
}

impl From<Error> for End {
    fn from(error: Error) -> Self {
        Self::Failure(error)
    }
}

impl From<ConfigError> for End {
    fn from(error: ConfigError) -> Self {
        Self::Failure(error.into())
    }
}

/// Runs the computation with a progress function that cancels it at call `number`; also returns the
/// number of calls.
fn cancelled_at<T>(
    number: usize,
    work: impl FnOnce(&mut dyn FnMut() -> Result<(), End>) -> Result<T, End>,
) -> (Result<T, End>, usize) {
    let mut calls = 0;
    let outcome = work(&mut || {
        calls += 1;
        if calls == number { Err(End::Cancelled) } else { Ok(()) }
    });
    (outcome, calls)
}

/// Asserts that progress is called at least every 10,000 samples, and that an error of its first or
/// last call cancels the computation.
fn assert_cancellable<T: PartialEq>(
    samples: usize,
    expected: &T,
    work: impl Fn(&mut dyn FnMut() -> Result<(), End>) -> Result<T, End>,
) {
    let (complete, calls) = cancelled_at(usize::MAX, &work);
    assert!(complete.is_ok_and(|result| result == *expected));
    assert!(calls > 1 && calls >= samples / 10_000, "{calls} for {samples} samples");
    for number in [1, calls] {
        let (ended, asked) = cancelled_at(number, &work);
        assert!(ended.is_err_and(|end| end == End::Cancelled));
        assert_eq!(asked, number);
    }
}

fn settings() -> SimulationSettings {
    SimulationSettings { rate_hz: RATE, seed: 1, ..SimulationSettings::default() }
}

fn walk() -> Vec<ImuSample> {
    simulate(&Route::straight(125.0), &Gait::walk(), &SensorErrors::mpu6050(), &settings())
        .unwrap()
        .samples
}

#[test]
fn simulations_are_cancellable() {
    let (route, gait, sensor) = (Route::straight(125.0), Gait::walk(), SensorErrors::mpu6050());
    let walk = simulate(&route, &gait, &sensor, &settings()).unwrap();
    assert_cancellable(walk.samples.len(), &walk, |progress| {
        simulate_with_progress(&route, &gait, &sensor, &settings(), progress)
    });
    let still = rest(150.0, &sensor, &settings()).unwrap();
    assert_cancellable(still.len(), &still, |progress| {
        rest_with_progress(150.0, &sensor, &settings(), progress)
    });
}

#[test]
fn detectors_are_cancellable() {
    let (config, samples) = (Config::default(), walk());
    let bits = |decisions: Vec<footnav::detectors::Decision>| -> Vec<[u64; 2]> {
        decisions.iter().map(|d| [d.statistic.to_bits(), u64::from(d.stationary)]).collect()
    };
    let expected = bits(decide_all(&config, RATE, &samples).unwrap());
    assert_cancellable(samples.len(), &expected, |progress| {
        let detector = config.detector.build(RATE, config.gravity());
        decide_all_with(detector, &config, &samples, progress).map(bits)
    });
}

#[test]
fn smoothing_a_recording_is_cancellable() {
    let smoother = SmootherConfig { kind: SmootherKind::Rts, ..SmootherConfig::default() };
    let (config, samples) = (Config { smoother, ..Config::default() }, walk());
    let batch = || {
        let mut batch = Batch::new(config.clone(), RATE).unwrap();
        batch.push_block(&samples).unwrap();
        batch
    };
    let expected = batch().finish().unwrap().0;
    assert_cancellable(samples.len(), &expected, |progress| {
        Ok(batch().finish_with_progress(progress)?.0)
    });
}
