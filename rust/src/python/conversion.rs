//! Settings as JSON, rows as arrays, and interrupts.

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::python::errors::ConfigError;

/// Lets an interrupt end the work of the main thread.
#[expect(
    clippy::redundant_closure_for_method_calls,
    reason = "the method itself is not general enough"
)]
pub(super) fn check_signals() -> PyResult<()> {
    Python::attach(|py| py.check_signals())
}

pub(super) fn to_json(settings: &impl Serialize) -> PyResult<String> {
    serde_json::to_string(settings).map_err(|error| ConfigError::new_err(error.to_string()))
}

pub(super) fn from_json<T: DeserializeOwned>(text: &[u8]) -> PyResult<T> {
    let mut json = serde_json::Deserializer::from_slice(text);
    serde_path_to_error::deserialize(&mut json)
        .map_err(|error| ConfigError::new_err(format!("{}: {}", error.path(), error.inner())))
}

/// An (n, N) array that takes over the memory of `rows`.
pub(super) fn matrix<const N: usize>(
    py: Python<'_>,
    rows: Vec<[f64; N]>,
) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let shape = [rows.len(), N];
    PyArray1::from_vec(py, rows.into_flattened()).reshape(shape)
}
