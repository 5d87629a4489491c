//! `footnav._core.Navigator`.

use numpy::{Element, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::config::Config;
use crate::error::Error;
use crate::filter::error_state::STATES;
use crate::pipeline::health_monitor::Health;
use crate::pipeline::navigator::Navigator;
use crate::python::block::Arrays;
use crate::python::conversion::{from_json, matrix};
use crate::python::detector::{Failure, PyDetector};
use crate::python::exclusive::Exclusive;
use crate::python::gait::columns_with_covariance;
use crate::types::health::Flags;
use crate::types::nav_state::NavState;
use crate::types::sample::ImuSample;
use crate::types::solution::Solution;
use crate::types::trajectory::Trajectory;

/// Samples of a block from which on the interpreter is left to others; to leave it and take it back
/// takes as long as a sample.
const SHORT: usize = 100;

/// New solutions, with the health after them; a column becomes an array
/// at its first use.
#[pyclass(frozen, name = "Columns", module = "footnav._core")]
pub(super) struct PyColumns {
    solutions: Vec<Solution>,
    health: Health,
}

#[pymethods]
impl PyColumns {
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        Ok(match name {
            "t" => self.numbers(py, |solution| solution.estimate.nav.time),
            "position" => self.rows(py, |solution| solution.estimate.nav.position.into())?,
            "velocity" => self.rows(py, |solution| solution.estimate.nav.velocity.into())?,
            "quaternion" => {
                self.rows::<4>(py, |solution| solution.estimate.nav.attitude.coords.into())?
            }
            "zero_velocity" => self.numbers(py, |solution| solution.zero_velocity),
            "position_std" => self.rows(py, |solution| solution.position_std.into())?,
            "gyro_bias" => self.rows(py, |solution| solution.estimate.gyro_bias.into())?,
            "accel_bias" => self.rows(py, |solution| solution.estimate.accel_bias.into())?,
            "flags" => self.numbers(py, |solution| solution.flags.bits()),
            _ => return Err(PyKeyError::new_err(name.to_owned())),
        })
    }

    fn health<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        health_fields(py, &self.health)
    }
}

impl PyColumns {
    fn numbers<'py, T: Element>(
        &self,
        py: Python<'py>,
        number: impl Fn(&Solution) -> T,
    ) -> Bound<'py, PyAny> {
        PyArray1::from_iter(py, self.solutions.iter().map(number)).into_any()
    }

    fn rows<'py, const N: usize>(
        &self,
        py: Python<'py>,
        row: impl Fn(&Solution) -> [f64; N],
    ) -> PyResult<Bound<'py, PyAny>> {
        Ok(matrix(py, self.solutions.iter().map(row).collect())?.into_any())
    }
}

/// The core's navigator; `footnav.Navigator` dresses its columns as Python objects.
#[pyclass(frozen, subclass, name = "Navigator", module = "footnav._core")]
pub(super) struct PyNavigator {
    inner: Exclusive<Navigator>,
    /// What a detector of the user's raised; absent with one of the core's.
    failure: Option<Failure>,
}

#[pymethods]
impl PyNavigator {
    #[new]
    #[pyo3(signature = (config, rate_hz, detector=None))]
    fn new(config: &[u8], rate_hz: f64, detector: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let config: Config = from_json(config)?;
        let Some(object) = detector else {
            return Ok(Self {
                inner: Exclusive::new(Navigator::new(config, rate_hz)?),
                failure: None,
            });
        };
        let (detector, failure) = PyDetector::new(object)?;
        let inner = Navigator::with_detector(config, rate_hz, Box::new(detector))?;
        Ok(Self { inner: Exclusive::new(inner), failure: Some(failure) })
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "floats are the cheapest thing to hand over from Python"
    )]
    fn push(
        &self,
        py: Python<'_>,
        t: f64,
        ax: f64,
        ay: f64,
        az: f64,
        gx: f64,
        gy: f64,
        gz: f64,
    ) -> PyResult<bool> {
        self.check(py)?;
        let sample = ImuSample::new(t, [ax, ay, az], [gx, gy, gz]);
        let is_new = self.inner.lock()?.advance(&sample);
        self.check(py)?;
        Ok(is_new?)
    }

    /// None if an array has to be converted first.
    #[pyo3(name = "_push_columns", signature = (t, accel, gyro, mag=None))]
    fn push_columns(
        &self,
        py: Python<'_>,
        t: &Bound<'_, PyAny>,
        accel: &Bound<'_, PyAny>,
        gyro: &Bound<'_, PyAny>,
        mag: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Option<PyColumns>> {
        self.check(py)?;
        let Some(arrays) = Arrays::of(t, accel, gyro) else { return Ok(None) };
        let (samples, fields) = arrays.read(mag)?;
        let navigator = &mut **self.inner.lock()?;
        if let Some(fields) = fields {
            navigator.check_block(&samples)?;
            for reading in &fields {
                navigator.push_reading(*reading);
            }
        } else {
            navigator.check_readings().map_err(Error::from)?;
        }
        let mut solutions = Vec::with_capacity(samples.len());
        let mut push = || navigator.push_block_into(&samples, &mut solutions);
        let pushed = if samples.len() < SHORT { push() } else { py.detach(push) };
        self.check(py)?;
        pushed?;
        Ok(Some(PyColumns { solutions, health: navigator.health() }))
    }

    #[pyo3(name = "_flush_columns")]
    fn flush_columns(&self, py: Python<'_>) -> PyResult<PyColumns> {
        self.check(py)?;
        let navigator = &mut **self.inner.lock()?;
        let mut solutions = Vec::new();
        let flushed = py.detach(|| navigator.flush_into(&mut solutions));
        self.check(py)?;
        flushed?;
        Ok(PyColumns { solutions, health: navigator.health() })
    }

    #[pyo3(name = "_stride_columns")]
    fn stride_columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        columns_with_covariance(py, &self.inner.lock()?.strides()?)
    }

    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        self.inner.lock()?.reset();
        self.check(py)
    }

    #[pyo3(name = "_state_now")]
    fn state_now<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let state = self.inner.lock()?.now().map_err(Error::from)?;
        state.map(|state| state_columns(py, &state)).transpose()
    }

    #[pyo3(name = "_health_fields")]
    fn health_fields<'py>(&self, py: Python<'py>, of_walk: bool) -> PyResult<Bound<'py, PyDict>> {
        let navigator = self.inner.lock()?;
        let health = if of_walk { navigator.health_of_walk() } else { navigator.health() };
        health_fields(py, &health)
    }

    #[getter]
    fn latency(&self) -> PyResult<usize> {
        Ok(self.inner.lock()?.latency())
    }

    #[getter]
    fn t(&self) -> PyResult<Option<f64>> {
        self.of_latest(|solution| solution.estimate.nav.time)
    }

    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        self.of_latest(|solution| {
            PyArray1::from_slice(py, solution.estimate.nav.position.as_slice())
        })
    }

    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        self.of_latest(|solution| {
            PyArray1::from_slice(py, solution.estimate.nav.velocity.as_slice())
        })
    }

    #[getter]
    fn quaternion<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        self.of_latest(|solution| {
            PyArray1::from_slice(py, solution.estimate.nav.attitude.coords.as_slice())
        })
    }

    #[getter]
    fn gyro_bias<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        self.of_latest(|solution| PyArray1::from_slice(py, solution.estimate.gyro_bias.as_slice()))
    }

    #[getter]
    fn accel_bias<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        self.of_latest(|solution| PyArray1::from_slice(py, solution.estimate.accel_bias.as_slice()))
    }

    #[getter]
    fn zero_velocity(&self) -> PyResult<Option<bool>> {
        self.of_latest(|solution| solution.zero_velocity)
    }

    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let navigator = self.inner.lock()?;
        let Some(covariance) = navigator.covariance() else { return Ok(None) };
        let dense: Vec<[f64; STATES]> =
            covariance.dense().row_iter().map(|row| row.transpose().into()).collect();
        matrix(py, dense).map(Some)
    }
}

impl PyNavigator {
    /// Raises what the user's detector raised.
    fn check(&self, py: Python<'_>) -> PyResult<()> {
        self.failure.as_ref().map_or(Ok(()), |failure| failure.check(py))
    }

    /// Something of the newest solution.
    fn of_latest<T>(&self, something: impl FnOnce(&Solution) -> T) -> PyResult<Option<T>> {
        Ok(self.inner.lock()?.with_latest(something))
    }
}

/// The fields of `footnav.Health`, by name.
pub(super) fn health_fields<'py>(py: Python<'py>, health: &Health) -> PyResult<Bound<'py, PyDict>> {
    let counters = PyDict::new(py);
    counters.set_item("samples", health.counters.samples)?;
    counters.set_item("repeated", health.counters.repeated)?;
    counters.set_item("gaps", health.counters.gaps)?;
    counters.set_item("clipped", health.counters.clipped)?;
    counters.set_item("refused", health.counters.refused)?;
    let updates = &health.counters.updates;
    counters.set_item("zero_velocity_updates", updates.zero_velocity.accepted)?;
    counters.set_item("zero_velocity_rejected", updates.zero_velocity.rejected)?;
    counters.set_item("zero_angular_rate_updates", updates.zero_angular_rate.accepted)?;
    counters.set_item("magnetic_updates", updates.magnetic_heading.accepted)?;
    counters.set_item("magnetic_rejected", updates.magnetic_heading.rejected)?;
    let fields = PyDict::new(py);
    fields.set_item("flags", health.flags.bits())?;
    fields.set_item("counters", counters)?;
    fields.set_item("horizontal_std", health.horizontal_std)?;
    fields.set_item("vertical_std", health.vertical_std)?;
    Ok(fields)
}

/// The columns of `footnav.Trajectory`, by name.
pub(super) fn columns(py: Python<'_>, trajectory: Trajectory) -> PyResult<Bound<'_, PyDict>> {
    let fields = PyDict::new(py);
    fields.set_item("t", PyArray1::from_vec(py, trajectory.time))?;
    fields.set_item("position", matrix(py, trajectory.position)?)?;
    fields.set_item("velocity", matrix(py, trajectory.velocity)?)?;
    fields.set_item("quaternion", matrix(py, trajectory.quaternion)?)?;
    fields.set_item("zero_velocity", PyArray1::from_vec(py, trajectory.zero_velocity))?;
    fields.set_item("position_std", matrix(py, trajectory.position_std)?)?;
    fields.set_item("gyro_bias", matrix(py, trajectory.gyro_bias)?)?;
    fields.set_item("accel_bias", matrix(py, trajectory.accel_bias)?)?;
    fields.set_item("flags", PyArray1::from_iter(py, trajectory.flags.iter().map(Flags::bits)))?;
    Ok(fields)
}

fn state_columns<'py>(py: Python<'py>, state: &NavState) -> PyResult<Bound<'py, PyDict>> {
    let fields = PyDict::new(py);
    fields.set_item("t", state.time)?;
    fields.set_item("position", PyArray1::from_slice(py, state.position.as_slice()))?;
    fields.set_item("velocity", PyArray1::from_slice(py, state.velocity.as_slice()))?;
    fields.set_item("quaternion", PyArray1::from_slice(py, state.attitude.coords.as_slice()))?;
    Ok(fields)
}
