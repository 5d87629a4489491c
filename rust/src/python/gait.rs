//! `footnav._core.strides`, `footnav._core.stances`, and strides column by column.

use nalgebra::UnitQuaternion;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::gait::stance::stances as find_stances;
use crate::gait::stride::Stride;
use crate::gait::strides::strides as find_strides;
use crate::python::conversion::matrix;
use crate::types::nav_state::NavState;

/// The strides of a track, given its columns, which the caller has checked; without covariance.
#[pyfunction]
#[expect(clippy::needless_pass_by_value, reason = "what PyO3 hands over is owned")]
pub(super) fn strides<'py>(
    py: Python<'py>,
    t: PyReadonlyArray1<'py, f64>,
    position: PyReadonlyArray2<'py, f64>,
    quaternion: PyReadonlyArray2<'py, f64>,
    zero_velocity: PyReadonlyArray1<'py, bool>,
) -> PyResult<Bound<'py, PyDict>> {
    let (t, p, q) = (t.as_array(), position.as_array(), quaternion.as_array());
    let state = |k: usize| NavState {
        time: t[k],
        position: [p[(k, 0)], p[(k, 1)], p[(k, 2)]].into(),
        velocity: [0.0; 3].into(),
        attitude: UnitQuaternion::new_unchecked(
            [q[(k, 0)], q[(k, 1)], q[(k, 2)], q[(k, 3)]].into(),
        ),
    };
    let rests = zero_velocity.as_array();
    columns(py, &find_strides((0..t.len()).map(|k| (state(k), rests[k]))))
}

/// First and last row of each stance.
#[pyfunction]
#[expect(clippy::needless_pass_by_value, reason = "what PyO3 hands over is owned")]
pub(super) fn stances<'py>(
    py: Python<'py>,
    t: PyReadonlyArray1<'py, f64>,
    zero_velocity: PyReadonlyArray1<'py, bool>,
) -> (Bound<'py, PyArray1<isize>>, Bound<'py, PyArray1<isize>>) {
    let (t, rests) = (t.as_array(), zero_velocity.as_array());
    let stances = find_stances(t.iter().copied().zip(rests.iter().copied()));
    let rows = |row: fn(&std::ops::RangeInclusive<usize>) -> usize| {
        PyArray1::from_iter(py, stances.iter().map(|stance| row(stance).cast_signed()))
    };
    (rows(|stance| *stance.start()), rows(|stance| *stance.end()))
}

/// The fields of `footnav.strides.Strides` without the covariance, by name.
fn columns<'py>(py: Python<'py>, strides: &[Stride]) -> PyResult<Bound<'py, PyDict>> {
    let rows = |row: fn(&Stride) -> usize| {
        PyArray1::from_iter(py, strides.iter().map(|s| row(s).cast_signed()))
    };
    let numbers = |number: fn(&Stride) -> f64| PyArray1::from_iter(py, strides.iter().map(number));
    let fields = PyDict::new(py);
    fields.set_item("start_index", rows(|stride| stride.start_row))?;
    fields.set_item("end_index", rows(|stride| stride.end_row))?;
    fields.set_item("start", numbers(|stride| stride.start))?;
    fields.set_item("end", numbers(|stride| stride.end))?;
    fields.set_item(
        "displacement",
        matrix(py, strides.iter().map(|stride| stride.displacement.into()).collect())?,
    )?;
    fields.set_item("start_heading", numbers(|stride| stride.start_heading))?;
    fields.set_item("heading_change", numbers(|stride| stride.heading_change))?;
    Ok(fields)
}

/// The fields of `footnav.strides.Strides` for strides that the filter found, by name.
pub(super) fn columns_with_covariance<'py>(
    py: Python<'py>,
    strides: &[Stride],
) -> PyResult<Bound<'py, PyDict>> {
    let fields = columns(py, strides)?;
    let numbers = strides
        .iter()
        .filter_map(|stride| stride.covariance)
        .flat_map(|covariance| covariance.data.0);
    let flat = PyArray1::from_iter(py, numbers.flatten());
    fields.set_item("covariance", flat.reshape([strides.len(), 4, 4])?)?;
    Ok(fields)
}
