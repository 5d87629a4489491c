//! `footnav._core.calibrate`: one sensor's correction, over arrays.

use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::calibration::TriadCalibration;
use crate::python::conversion::{from_json, matrix, to_json};
use crate::python::errors::DataError;

/// The corrected readings of one sensor, shape (n, 3).
#[pyfunction]
#[pyo3(signature = (calibration, raw, temperature=None))]
pub(super) fn calibrate<'py>(
    py: Python<'py>,
    calibration: &[u8],
    raw: &Bound<'py, PyArray2<f64>>,
    temperature: Option<PyReadonlyArray1<'py, f64>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let calibration: TriadCalibration = from_json(calibration)?;
    let raw = raw.readonly();
    let raw = raw.as_array();
    if raw.ncols() != 3 {
        return Err(DataError::new_err(format!(
            "readings have shape {:?}; expected (n, 3)",
            raw.shape()
        )));
    }
    let readings: Vec<[f64; 3]> =
        raw.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect();
    let temperatures = temperature.map_or_else(Vec::new, |column| column.as_array().to_vec());
    let corrected = py.detach(|| calibration.apply(&readings, &temperatures))?;
    matrix(py, corrected)
}

/// The correction at one temperature as JSON.
#[pyfunction]
#[pyo3(signature = (calibration, temperature=None))]
pub(super) fn calibration_at(calibration: &[u8], temperature: Option<f64>) -> PyResult<String> {
    to_json(&from_json::<TriadCalibration>(calibration)?.at(temperature)?)
}
