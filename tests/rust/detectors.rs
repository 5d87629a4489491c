//! Every registered detector keeps the contract of a detector.

use std::collections::HashSet;

use footnav::Config;
use footnav::config::DetectorConfig;
use footnav::detectors::{Decision, Detector};
use footnav::settings::{Literal, ValueType};
use footnav::simulation::{Gait, Route, SensorErrors, SimulationSettings, simulate};

const RATE: f64 = 200.0;

/// Decisions as they come, and those that are due at the end of the data.
fn decisions(detector: &mut dyn Detector) -> (Vec<Option<Decision>>, Vec<Decision>) {
    let settings = SimulationSettings { rate_hz: RATE, seed: 4, ..SimulationSettings::default() };
    let walk = simulate(&Route::square(5.0), &Gait::walk(), &SensorErrors::ideal(), &settings);
    let samples = walk.unwrap().samples;
    let pushed = samples.iter().map(|sample| detector.push(sample)).collect();
    (pushed, std::iter::from_fn(|| detector.drain()).collect())
}

#[test]
fn default_settings_are_valid_and_what_a_file_that_names_the_detector_alone_means() {
    let kinds: HashSet<_> = DetectorConfig::all().iter().map(DetectorConfig::kind).collect();
    assert_eq!(kinds.len(), DetectorConfig::all().len());
    assert!(kinds.contains(DetectorConfig::default().kind()));
    for detector in DetectorConfig::all() {
        assert_eq!(detector.validate(), Ok(()));
        let file = format!("[detector]\nkind = \"{}\"", detector.kind());
        assert_eq!(Config::from_toml(&file), Ok(Config { detector, ..Config::default() }));
    }
}

#[test]
fn every_number_has_limits_that_include_its_default_and_no_infinite_one() {
    for section in Config::schema() {
        for setting in section.settings {
            let number = ValueType::Number;
            if setting.value == number || setting.value == ValueType::Optional(number.into()) {
                let limits = setting.limits.unwrap_or_else(|| panic!("{}", setting.name));
                assert!(!limits.contains(f64::INFINITY) && !limits.contains(f64::NAN));
                let Literal::Number(default) = setting.default else { continue };
                assert!(limits.contains(default), "{} {}", section.class, setting.name);
            }
        }
    }
}

#[test]
fn every_sample_gets_one_decision_as_late_as_announced() {
    for settings in DetectorConfig::all() {
        let mut detector = settings.build(RATE, Config::default().gravity());
        let (pushed, drained) = decisions(&mut *detector);
        let latency = detector.latency();
        assert!(pushed[..latency].iter().all(Option::is_none), "{settings:?}");
        assert!(pushed[latency..].iter().all(Option::is_some), "{settings:?}");
        assert_eq!(drained.len(), latency, "{settings:?}");
        detector.reset();
        let bits = |decision: &Option<Decision>| {
            decision.map(|d| (d.stationary, d.statistic.to_bits(), d.threshold.to_bits()))
        };
        let again = decisions(&mut *detector).0;
        assert!(pushed.iter().map(bits).eq(again.iter().map(bits)), "{settings:?}");
    }
}

#[test]
fn a_walk_has_samples_at_rest_and_in_motion() {
    for settings in DetectorConfig::all() {
        let (pushed, _) = decisions(&mut *settings.build(RATE, Config::default().gravity()));
        let decided: Vec<_> = pushed.into_iter().flatten().collect();
        let rest = decided.iter().filter(|decision| decision.stationary).count();
        let (few, most) = (decided.len() / 20, decided.len() * 19 / 20);
        assert!((few..most).contains(&rest), "{}: {rest}", settings.kind());
    }
}
