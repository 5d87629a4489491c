//! `footnav._core.allan`.

use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::allan::{Curve, averaging_factors};
use crate::python::conversion::matrix;

/// Channels of a sensor.
const AXES: usize = 3;

/// Averaging times in samples, with the Allan deviation and its degrees of freedom for each axis of
/// a sensor.
///
/// `progress` is called with the share of the work that is done; it, and an interrupt from the keyboard,
/// can end it.
#[pyfunction]
#[expect(clippy::needless_pass_by_value, reason = "an argument from Python is owned")]
pub(super) fn allan<'py>(
    py: Python<'py>,
    samples: PyReadonlyArray2<'py, f64>,
    progress: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let samples = samples.as_array();
    let factors = averaging_factors(samples.nrows());
    let mut deviation = vec![[f64::NAN; AXES]; factors.len()];
    let mut degrees_of_freedom = deviation.clone();
    let progress = progress.clone().unbind();
    for (axis, (done, column)) in [0.0, 1.0, 2.0].into_iter().zip(samples.columns()).enumerate() {
        let column = column.to_vec();
        let progress = |share: f64| {
            Python::attach(|py| {
                py.check_signals()?;
                progress.call1(py, ((done + share) / 3.0,)).map(drop)
            })
        };
        let curve = py.detach(|| Curve::of(&column, progress))?;
        for k in 0..factors.len() {
            deviation[k][axis] = curve.deviation[k];
            degrees_of_freedom[k][axis] = curve.degrees_of_freedom[k];
        }
    }
    let fields = PyDict::new(py);
    fields.set_item(
        "factors",
        PyArray1::from_iter(py, factors.iter().map(|&factor| factor as u64)),
    )?;
    fields.set_item("deviation", matrix(py, deviation)?)?;
    fields.set_item("degrees_of_freedom", matrix(py, degrees_of_freedom)?)?;
    Ok(fields)
}
