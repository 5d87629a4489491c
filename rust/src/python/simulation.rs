//! `footnav._core.simulate` and the presets that go with it.

use nalgebra::Vector3;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Deserialize;

use crate::python::block::Block;
use crate::python::conversion::{check_signals, from_json, matrix, to_json};
use crate::python::errors::ConfigError;
use crate::simulation::{Gait, Route, SensorErrors, SimulationSettings, Walk};

/// All that a simulation needs.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Plan {
    route: Route,
    gait: Gait,
    sensor: SensorErrors,
    settings: SimulationSettings,
}

/// The samples and the truth of a simulated walk, column by column.
#[pyfunction]
pub(super) fn simulate<'py>(py: Python<'py>, plan: &[u8]) -> PyResult<Bound<'py, PyDict>> {
    let Plan { route, gait, sensor, settings } = from_json(plan)?;
    let walk = py.detach(|| {
        crate::simulation::simulate_with_progress(&route, &gait, &sensor, &settings, check_signals)
    })?;
    columns(py, &walk)
}

/// What a rest needs.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RestPlan {
    duration: f64,
    sensor: SensorErrors,
    settings: SimulationSettings,
}

/// The samples of a sensor that lies still, column by column.
#[pyfunction]
pub(super) fn simulate_rest<'py>(py: Python<'py>, plan: &[u8]) -> PyResult<Bound<'py, PyDict>> {
    let RestPlan { duration, sensor, settings } = from_json(plan)?;
    let samples = py.detach(|| {
        crate::simulation::rest_with_progress(duration, &sensor, &settings, check_signals)
    })?;
    let fields = PyDict::new(py);
    fields.set_item("t", PyArray1::from_iter(py, samples.iter().map(|sample| sample.time)))?;
    fields.set_item(
        "accel",
        matrix(py, samples.iter().map(|sample| sample.specific_force.into()).collect())?,
    )?;
    fields.set_item(
        "gyro",
        matrix(py, samples.iter().map(|sample| sample.angular_rate.into()).collect())?,
    )?;
    Ok(fields)
}

/// Accelerometer and gyroscope, shape (n, 3) each, as a sensor with errors reads them.
#[pyfunction]
#[expect(clippy::type_complexity, reason = "two arrays")]
pub(super) fn corrupt<'py>(
    py: Python<'py>,
    sensor: &[u8],
    seed: u64,
    t: PyReadonlyArray1<'py, f64>,
    accel: PyReadonlyArray2<'py, f64>,
    gyro: PyReadonlyArray2<'py, f64>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
    let errors: SensorErrors = from_json(sensor)?;
    let truth = Block::of(&(t, accel, gyro))?.samples();
    let readings = py.detach(|| crate::simulation::corrupt(&truth, &errors, seed))?;
    let accel = readings.iter().map(|sample| sample.specific_force.into()).collect();
    let gyro = readings.iter().map(|sample| sample.angular_rate.into()).collect();
    Ok((matrix(py, accel)?, matrix(py, gyro)?))
}

/// The parameters of a gait preset as JSON.
#[pyfunction]
pub(super) fn gait_preset(name: &str) -> PyResult<String> {
    to_json(&Gait::preset(name)?)
}

/// The parameters of a sensor preset as JSON.
#[pyfunction]
pub(super) fn sensor_preset(name: &str) -> PyResult<String> {
    to_json(&SensorErrors::preset(name)?)
}

/// A route of a known shape as JSON.
#[pyfunction]
#[expect(clippy::needless_pass_by_value, reason = "an argument from Python is owned")]
pub(super) fn route(shape: &str, sizes: Vec<f64>) -> PyResult<String> {
    let route = match (shape, sizes.as_slice()) {
        ("straight", &[length]) => Route::straight(length),
        ("square", &[side]) => Route::square(side),
        ("rectangle", &[length, width]) => Route::rectangle(length, width),
        ("figure-of-eight", &[length]) => Route::figure_of_eight(length),
        ("out-and-back", &[length]) => Route::out_and_back(length),
        ("stairs", &[floors, risers, riser, tread]) => {
            Route::stairs(count(floors)?, count(risers)?, riser, tread)
        }
        _ => {
            return Err(ConfigError::new_err(format!(
                "no route {shape:?} with {} sizes",
                sizes.len()
            )));
        }
    };
    to_json(&route)
}

/// An integer that is given as a float.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked to be a whole number below 10000"
)]
fn count(value: f64) -> PyResult<u32> {
    if value.fract() == 0.0 && (1.0..1.0e4).contains(&value) {
        return Ok(value as u32);
    }
    Err(ConfigError::new_err(format!(
        "{value} is not a number of floors or risers: expected a whole number from 1 to 9999"
    )))
}

fn columns<'py>(py: Python<'py>, walk: &Walk) -> PyResult<Bound<'py, PyDict>> {
    let vectors = |column: &mut dyn Iterator<Item = Vector3<f64>>| {
        matrix(py, column.map(<[f64; 3]>::from).collect())
    };
    let fields = PyDict::new(py);
    fields.set_item("t", PyArray1::from_iter(py, walk.samples.iter().map(|sample| sample.time)))?;
    fields.set_item(
        "accel",
        vectors(&mut walk.samples.iter().map(|sample| sample.specific_force))?,
    )?;
    fields
        .set_item("gyro", vectors(&mut walk.samples.iter().map(|sample| sample.angular_rate))?)?;
    fields.set_item("position", vectors(&mut walk.truth.iter().map(|state| state.position))?)?;
    fields.set_item("velocity", vectors(&mut walk.truth.iter().map(|state| state.velocity))?)?;
    fields.set_item(
        "quaternion",
        matrix(py, walk.truth.iter().map(|state| state.attitude.coords.into()).collect())?,
    )?;
    fields.set_item("stance", PyArray1::from_slice(py, &walk.stance))?;
    fields.set_item("gyro_bias", vectors(&mut walk.gyro_bias.iter().copied())?)?;
    fields.set_item("accel_bias", vectors(&mut walk.accel_bias.iter().copied())?)?;
    Ok(fields)
}
