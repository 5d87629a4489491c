//! Blocks of samples in the memory of `NumPy`.

use std::ops::Range;

use numpy::ndarray::{ArrayView1, ArrayView2, s};
use numpy::{
    PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::error::Error;
use crate::python::errors::DataError;
use crate::types::sample::{ImuSample, MagSample};

/// Stamps, specific force and angular rate.
pub(super) type Columns<'py> =
    (PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>);

/// Samples, and readings of a magnetometer if there is one.
type Readings = (Vec<ImuSample>, Option<Vec<MagSample>>);

/// The arrays of a block, read at once.
///
/// They need no borrow flags, which take as long as two samples: see [`Columns`].
pub(super) struct Arrays<'a, 'py> {
    t: &'a Bound<'py, PyArray1<f64>>,
    accel: &'a Bound<'py, PyArray2<f64>>,
    gyro: &'a Bound<'py, PyArray2<f64>>,
}

impl<'a, 'py> Arrays<'a, 'py> {
    /// None if one of them needs conversion to an array of numbers of the right dimension.
    ///
    /// So do instances of a subclass, since a masked array may hide entries, and fields of packed
    /// records, whose numbers are not aligned.
    pub(super) fn of(
        t: &'a Bound<'py, PyAny>,
        accel: &'a Bound<'py, PyAny>,
        gyro: &'a Bound<'py, PyAny>,
    ) -> Option<Self> {
        if ![t, accel, gyro].into_iter().all(PyAnyMethods::is_exact_instance_of::<PyUntypedArray>) {
            return None;
        }
        let arrays = Self { t: t.cast().ok()?, accel: accel.cast().ok()?, gyro: gyro.cast().ok()? };
        let aligned =
            arrays.t.is_aligned() && arrays.accel.is_aligned() && arrays.gyro.is_aligned();
        aligned.then_some(arrays)
    }

    /// Copies of the samples, and of the readings of a magnetometer beside them.
    #[expect(unsafe_code, reason = "views of arrays without borrow flags")]
    pub(super) fn read(&self, mag: Option<PyReadonlyArray2<'_, f64>>) -> PyResult<Readings> {
        // SAFETY: the arrays are aligned; the views end with this call, which holds the interpreter
        // and runs no code of Python, and nothing in this library writes to an array of Python.
        let (t, accel, gyro) =
            unsafe { (self.t.as_array(), self.accel.as_array(), self.gyro.as_array()) };
        let block = Block { t, accel, gyro }.checked()?;
        Ok((block.samples(), mag.map(|mag| block.fields(&mag)).transpose()?))
    }
}

/// Columns of equal length in `NumPy`'s memory.
pub(super) struct Block<'a> {
    t: ArrayView1<'a, f64>,
    accel: ArrayView2<'a, f64>,
    gyro: ArrayView2<'a, f64>,
}

impl<'a> Block<'a> {
    pub(super) fn of((t, accel, gyro): &'a Columns<'_>) -> PyResult<Self> {
        Self { t: t.as_array(), accel: accel.as_array(), gyro: gyro.as_array() }.checked()
    }

    fn checked(self) -> PyResult<Self> {
        let shape = [self.len(), 3];
        if self.accel.shape() == shape && self.gyro.shape() == shape {
            return Ok(self);
        }
        Err(DataError::new_err(format!(
            "{} stamps need accel and gyro of shape ({}, 3); got {:?} and {:?}",
            self.len(),
            self.len(),
            self.accel.shape(),
            self.gyro.shape()
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

    /// A copy of the samples, so that the interpreter can be released while they are worked on.
    pub(super) fn samples(&self) -> Vec<ImuSample> {
        let mut samples = Vec::with_capacity(self.len());
        self.copy_to(&mut samples);
        samples
    }

    /// Appends a copy of the samples.
    pub(super) fn copy_to(&self, samples: &mut Vec<ImuSample>) {
        if let (Some(t), Some(accel), Some(gyro)) =
            (self.t.as_slice(), self.accel.as_slice(), self.gyro.as_slice())
        {
            let vectors = accel.as_chunks::<3>().0.iter().zip(gyro.as_chunks::<3>().0);
            samples.extend(
                t.iter().zip(vectors).map(|(&t, (&accel, &gyro))| ImuSample::new(t, accel, gyro)),
            );
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
            return Err(DataError::new_err(format!(
                "{n} stamps need mag of shape ({n}, 3); got {shape:?}"
            )));
        }
        let rows = self.t.iter().zip(mag.rows()).map(|(&t, row)| (t, [row[0], row[1], row[2]]));
        let read = rows.filter(|(_, field)| !field.iter().all(|component| component.is_nan()));
        Ok(read
            .map(|(t, field)| MagSample::new(t, field))
            .collect::<Result<_, _>>()
            .map_err(Error::from)?)
    }
}
