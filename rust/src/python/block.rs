//! Blocks of samples, as `NumPy` hands them over.

use std::ops::Range;

use numpy::ndarray::{ArrayView1, ArrayView2, s};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArray};
use pyo3::prelude::*;

use crate::error::Error;
use crate::python::DataError;
use crate::sample::{ImuSample, MagSample};

/// Stamps, specific force and angular rate.
pub(super) type Columns<'py> = (PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>);

/// Arrays as columns; none if one of them has still to be made an array of numbers of so many dimensions.
///
/// That goes for an instance of a subclass, too: some entries of a masked array do not count.
pub(super) fn columns<'py>(
    t: &Bound<'py, PyAny>,
    accel: &Bound<'py, PyAny>,
    gyro: &Bound<'py, PyAny>,
) -> Option<Columns<'py>> {
    let exact = [t, accel, gyro].into_iter().all(PyAnyMethods::is_exact_instance_of::<PyUntypedArray>);
    if exact { Some((t.extract().ok()?, accel.extract().ok()?, gyro.extract().ok()?)) } else { None }
}

/// Columns of equal length in `NumPy`'s memory.
pub(super) struct Block<'a> {
    t: ArrayView1<'a, f64>,
    accel: ArrayView2<'a, f64>,
    gyro: ArrayView2<'a, f64>,
}

impl<'a> Block<'a> {
    pub(super) fn of((t, accel, gyro): &'a Columns<'_>) -> PyResult<Self> {
        let block = Self { t: t.as_array(), accel: accel.as_array(), gyro: gyro.as_array() };
        let shape = [block.len(), 3];
        if block.accel.shape() == shape && block.gyro.shape() == shape {
            return Ok(block);
        }
        Err(DataError::new_err(format!(
            "{} stamps need accel and gyro of shape ({}, 3); got {:?} and {:?}",
            block.len(),
            block.len(),
            block.accel.shape(),
            block.gyro.shape()
        )))
    }

    pub(super) fn len(&self) -> usize {
        self.t.len()
    }

    /// Some of its rows.
    pub(super) fn part(&self, rows: Range<usize>) -> Block<'_> {
        Block {
            t: self.t.slice(s![rows.clone()]),
            accel: self.accel.slice(s![rows.clone(), ..]),
            gyro: self.gyro.slice(s![rows, ..]),
        }
    }

    /// Appends a copy of the samples.
    pub(super) fn copy_to(&self, samples: &mut Vec<ImuSample>) {
        if let (Some(t), Some(accel), Some(gyro)) = (self.t.as_slice(), self.accel.as_slice(), self.gyro.as_slice()) {
            let vectors = accel.as_chunks::<3>().0.iter().zip(gyro.as_chunks::<3>().0);
            samples.extend(t.iter().zip(vectors).map(|(&t, (&accel, &gyro))| ImuSample::new(t, accel, gyro)));
            return;
        }
        let row = |k: usize| {
            let at = |m: &ArrayView2<'_, f64>| [m[(k, 0)], m[(k, 1)], m[(k, 2)]];
            ImuSample::new(self.t[k], at(&self.accel), at(&self.gyro))
        };
        samples.extend((0..self.len()).map(row));
    }

    /// The readings of a magnetometer beside the samples; none where a row is NaN.
    pub(super) fn fields(&self, mag: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<MagSample>> {
        let mag = mag.as_array();
        let (n, shape) = (self.len(), mag.shape());
        if shape != [n, 3] {
            return Err(DataError::new_err(format!("{n} stamps need mag of shape ({n}, 3); got {shape:?}")));
        }
        let rows = self.t.iter().zip(mag.rows()).map(|(&t, row)| (t, [row[0], row[1], row[2]]));
        let read = rows.filter(|(_, field)| !field.iter().all(|component| component.is_nan()));
        Ok(read.map(|(t, field)| MagSample::new(t, field)).collect::<Result<_, _>>().map_err(Error::from)?)
    }
}

/// Copies a block of samples out of `NumPy`'s memory, so that the interpreter can be released while it is worked on.
pub(super) fn rows(columns: &Columns<'_>) -> PyResult<Vec<ImuSample>> {
    let block = Block::of(columns)?;
    let mut samples = Vec::with_capacity(block.len());
    block.copy_to(&mut samples);
    Ok(samples)
}
