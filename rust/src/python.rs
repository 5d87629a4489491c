//! The extension module `footnav._core`: each wrapper converts and delegates.

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::config::{Config, PRESETS};
use crate::detectors::adaptive_shoe::AdaptiveShoeConfig;
use crate::detectors::registry::DetectorConfig;
use crate::pipeline::detection::{configured, decide_all_with};
use crate::python::block::Block;
use crate::python::conversion::{check_signals, from_json, to_json};
use crate::python::detector::PyDetector;

mod allan;
mod batch;
mod block;
mod calibration;
mod conversion;
mod detector;
mod errors;
mod exclusive;
mod gait;
mod navigator;
mod rest;
mod simulation;
mod validation;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<batch::PyBatch>()?;
    module.add_class::<navigator::PyColumns>()?;
    module.add_class::<navigator::PyNavigator>()?;
    module.add_class::<rest::PyRestDetector>()?;
    module.add_function(wrap_pyfunction!(default_config, module)?)?;
    module.add_function(wrap_pyfunction!(live_detector, module)?)?;
    module.add_function(wrap_pyfunction!(preset_config, module)?)?;
    module.add_function(wrap_pyfunction!(preset_names, module)?)?;
    module.add_function(wrap_pyfunction!(settings_schema, module)?)?;
    module.add_function(wrap_pyfunction!(check_config, module)?)?;
    module.add_function(wrap_pyfunction!(gravity, module)?)?;
    module.add_function(wrap_pyfunction!(detect, module)?)?;
    module.add_function(wrap_pyfunction!(allan::allan, module)?)?;
    module.add_function(wrap_pyfunction!(calibration::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(calibration::calibration_at, module)?)?;
    module.add_function(wrap_pyfunction!(rest::alignment_rest_limits, module)?)?;
    module.add_function(wrap_pyfunction!(validation::sample_flags, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::corrupt, module)?)?;
    module.add_function(wrap_pyfunction!(gait::strides, module)?)?;
    module.add_function(wrap_pyfunction!(gait::stances, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::simulate_rest, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::gait_preset, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::sensor_preset, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::route, module)?)?;
    Ok(())
}

/// The default settings as JSON.
#[pyfunction]
fn default_config() -> PyResult<String> {
    to_json(&Config::default())
}

/// The settings of a preset as JSON.
#[pyfunction]
fn preset_config(name: &str) -> PyResult<String> {
    to_json(&Config::preset(name)?)
}

/// The settings of the default detector for a stream that must not be late, as JSON.
#[pyfunction]
fn live_detector() -> PyResult<String> {
    to_json(&DetectorConfig::AdaptiveShoe(AdaptiveShoeConfig::live()))
}

/// The names of the presets.
#[pyfunction]
fn preset_names() -> Vec<&'static str> {
    PRESETS.to_vec()
}

/// Every setting with its type, default, unit, limits and meaning, section by section, as JSON.
#[pyfunction]
fn settings_schema() -> PyResult<String> {
    to_json(&Config::schema())
}

/// Raises `ConfigError` for settings that make no sense.
#[pyfunction]
fn check_config(config: &[u8]) -> PyResult<()> {
    Ok(from_json::<Config>(config)?.validate()?)
}

/// Gravity (m/s²) that the settings amount to.
#[pyfunction]
fn gravity(config: &[u8]) -> PyResult<f64> {
    Ok(from_json::<Config>(config)?.gravity())
}

/// Statistic, threshold and decision of the configured detector, or of the user's own, for each
/// sample.
#[pyfunction]
#[pyo3(signature = (config, rate_hz, t, accel, gyro, detector=None))]
fn detect<'py>(
    py: Python<'py>,
    config: &[u8],
    rate_hz: f64,
    t: PyReadonlyArray1<'py, f64>,
    accel: PyReadonlyArray2<'py, f64>,
    gyro: PyReadonlyArray2<'py, f64>,
    detector: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let config: Config = from_json(config)?;
    let samples = Block::of(&(t, accel, gyro))?.samples();
    let decisions = match detector {
        None => {
            let detector = configured(&config, rate_hz)?;
            py.detach(|| decide_all_with(detector, &config, &samples, check_signals))?
        }
        Some(object) => {
            let (detector, failure) = PyDetector::new(object)?;
            let decisions =
                py.detach(|| decide_all_with(Box::new(detector), &config, &samples, check_signals));
            failure.check(py)?;
            decisions?
        }
    };
    let columns = PyDict::new(py);
    columns
        .set_item("statistic", PyArray1::from_iter(py, decisions.iter().map(|d| d.statistic)))?;
    columns
        .set_item("threshold", PyArray1::from_iter(py, decisions.iter().map(|d| d.threshold)))?;
    columns
        .set_item("decision", PyArray1::from_iter(py, decisions.iter().map(|d| d.stationary)))?;
    Ok(columns)
}
