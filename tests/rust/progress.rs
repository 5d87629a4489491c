//! Work over many samples asks its progress every 10,000 of them, and ends when the progress says
//! so.

use footnav::config::{SmootherConfig, SmootherKind};
use footnav::simulation::{
    Gait, Route, SensorErrors, SimulationSettings, rest, rest_with_progress, simulate,
    simulate_with_progress,
};
use footnav::{Batch, Config, ConfigError, Error, ImuSample};
use footnav::{decide_all, decide_all_with};

const RATE: f64 = 200.0;

/// What ends the work.
#[derive(Debug, PartialEq)]
enum End {
    Watch,
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

/// Runs the work with a watch that ends it at the question of that number; also how many questions
/// there were.
fn ended_at<T>(
    number: usize,
    work: impl FnOnce(&mut dyn FnMut() -> Result<(), End>) -> Result<T, End>,
) -> (Result<T, End>, usize) {
    let mut questions = 0;
    let outcome = work(&mut || {
        questions += 1;
        if questions == number { Err(End::Watch) } else { Ok(()) }
    });
    (outcome, questions)
}

/// Asserts that the work ends at the first or the last question if the progress says so, and that
/// there is one for every 10,000 samples.
fn assert_with_progress<T: PartialEq>(
    samples: usize,
    expected: &T,
    work: impl Fn(&mut dyn FnMut() -> Result<(), End>) -> Result<T, End>,
) {
    let (whole, questions) = ended_at(usize::MAX, &work);
    assert!(whole.is_ok_and(|whole| whole == *expected));
    assert!(questions > 1 && questions >= samples / 10_000, "{questions} for {samples} samples");
    for number in [1, questions] {
        let (ended, asked) = ended_at(number, &work);
        assert!(ended.is_err_and(|end| end == End::Watch));
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
fn simulations() {
    let (route, gait, sensor) = (Route::straight(125.0), Gait::walk(), SensorErrors::mpu6050());
    let walk = simulate(&route, &gait, &sensor, &settings()).unwrap();
    assert_with_progress(walk.samples.len(), &walk, |progress| {
        simulate_with_progress(&route, &gait, &sensor, &settings(), progress)
    });
    let still = rest(150.0, &sensor, &settings()).unwrap();
    assert_with_progress(still.len(), &still, |progress| {
        rest_with_progress(150.0, &sensor, &settings(), progress)
    });
}

#[test]
fn detectors() {
    let (config, samples) = (Config::default(), walk());
    let bits = |decisions: Vec<footnav::detectors::Decision>| -> Vec<[u64; 2]> {
        decisions.iter().map(|d| [d.statistic.to_bits(), u64::from(d.stationary)]).collect()
    };
    let expected = bits(decide_all(&config, RATE, &samples).unwrap());
    assert_with_progress(samples.len(), &expected, |progress| {
        let detector = config.detector.build(RATE, config.gravity());
        decide_all_with(detector, &config, &samples, progress).map(bits)
    });
}

#[test]
fn the_end_of_a_recording() {
    let smoother = SmootherConfig { kind: SmootherKind::Rts, ..SmootherConfig::default() };
    let (config, samples) = (Config { smoother, ..Config::default() }, walk());
    let batch = || {
        let mut batch = Batch::new(config.clone(), RATE).unwrap();
        batch.push_block(&samples).unwrap();
        batch
    };
    let expected = batch().finish().unwrap().0;
    assert_with_progress(samples.len(), &expected, |progress| {
        Ok(batch().finish_with_progress(progress)?.0)
    });
}
