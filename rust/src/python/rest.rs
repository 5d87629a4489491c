//! `footnav._core.RestDetector`: rest detection, and its limits in the alignment.

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::config::Config;
use crate::ins::rest::{BlockState, RestDetector, RestLimits};
use crate::ins::sample_statistics::SampleStatistics;
use crate::python::block::Block;
use crate::python::conversion::{from_json, matrix};
use crate::python::exclusive::Exclusive;
use crate::types::sample::ImuSample;

/// The fields of `footnav.rest_detection.RestLimits`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Limits {
    block: f64,
    max_span: f64,
    min_duration: f64,
    accel_std: f64,
    gyro_std: f64,
    accel_drift: f64,
    gyro_drift: f64,
}

impl From<Limits> for RestLimits {
    fn from(limits: Limits) -> Self {
        let Limits { block, max_span, min_duration, accel_std, gyro_std, accel_drift, gyro_drift } =
            limits;
        Self { block, max_span, min_duration, accel_std, gyro_std, accel_drift, gyro_drift }
    }
}

/// The limits of the rest at the start, by name.
#[pyfunction]
pub(super) fn alignment_rest_limits<'py>(
    py: Python<'py>,
    config: &[u8],
) -> PyResult<Bound<'py, PyDict>> {
    let limits = from_json::<Config>(config)?.alignment.rest_limits();
    let fields = PyDict::new(py);
    fields.set_item("block", limits.block)?;
    fields.set_item("max_span", limits.max_span)?;
    fields.set_item("min_duration", limits.min_duration)?;
    fields.set_item("accel_std", limits.accel_std)?;
    fields.set_item("gyro_std", limits.gyro_std)?;
    fields.set_item("accel_drift", limits.accel_drift)?;
    fields.set_item("gyro_drift", limits.gyro_drift)?;
    Ok(fields)
}

/// Decides block by block whether a sensor is at rest; the samples come in pieces of any length.
#[pyclass(name = "RestDetector", module = "footnav._core", frozen)]
pub(super) struct PyRestDetector {
    inner: Exclusive<IndexedDetector>,
}

#[pymethods]
impl PyRestDetector {
    /// The rate is rounded to whole hertz, as a navigator rounds it.
    #[new]
    fn new(limits: Limits, rate_hz: f64) -> Self {
        let nominal_interval = 1.0 / rate_hz.round().max(1.0);
        let detector = RestDetector::new(limits.into(), nominal_interval);
        Self { inner: Exclusive::new(IndexedDetector { detector, samples: 0, anchor: 0 }) }
    }

    /// Adds the next samples; returns the blocks that they complete, column by column.
    fn push_block<'py>(
        &self,
        py: Python<'py>,
        t: PyReadonlyArray1<'py, f64>,
        accel: PyReadonlyArray2<'py, f64>,
        gyro: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let samples = Block::of(&(t, accel, gyro))?.samples();
        let mut inner = self.inner.lock()?;
        let blocks: Vec<_> = samples.iter().filter_map(|sample| inner.push(sample)).collect();
        columns(py, &blocks)
    }

    /// The incomplete block at the end, if it has a sample.
    fn finish<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let inner = self.inner.lock()?;
        let incomplete = !inner.detector.block().is_empty();
        let blocks: Vec<_> = incomplete
            .then(|| inner.block(inner.detector.block_is_at_rest()))
            .into_iter()
            .collect();
        columns(py, &blocks)
    }
}

/// A detector that counts the samples.
struct IndexedDetector {
    detector: RestDetector,
    samples: usize,
    /// Index of the sample that ended the last block.
    anchor: usize,
}

/// A block, from the sample that ended the one before to its own last sample.
struct RestBlock {
    first: usize,
    last: usize,
    at_rest: bool,
    statistics: SampleStatistics,
    accel_drift: [f64; 3],
    gyro_drift: [f64; 3],
}

impl IndexedDetector {
    /// Adds a sample; returns the block that it completes.
    fn push(&mut self, sample: &ImuSample) -> Option<RestBlock> {
        self.samples += 1;
        let at_rest = match self.detector.push(sample) {
            BlockState::Part => return None,
            BlockState::Rest => true,
            BlockState::Moving => false,
        };
        let block = self.block(at_rest);
        if at_rest {
            self.detector.extend_rest();
        } else {
            self.detector.restart();
        }
        self.anchor = block.last;
        Some(block)
    }

    /// The samples since the anchor.
    fn block(&self, at_rest: bool) -> RestBlock {
        let statistics = self.detector.block_statistics();
        let (accel_drift, gyro_drift) = self.detector.drift(&statistics);
        RestBlock {
            first: self.anchor,
            last: self.samples - 1,
            at_rest,
            statistics,
            accel_drift: accel_drift.into(),
            gyro_drift: gyro_drift.into(),
        }
    }
}

/// The fields of `footnav.rest_detection.RestBlocks`, by name.
fn columns<'py>(py: Python<'py>, blocks: &[RestBlock]) -> PyResult<Bound<'py, PyDict>> {
    let rows = |row: fn(&RestBlock) -> usize| {
        PyArray1::from_iter(py, blocks.iter().map(|block| row(block).cast_signed()))
    };
    let vectors =
        |vector: fn(&RestBlock) -> [f64; 3]| matrix(py, blocks.iter().map(vector).collect());
    let fields = PyDict::new(py);
    fields.set_item("first", rows(|block| block.first))?;
    fields.set_item("last", rows(|block| block.last))?;
    fields
        .set_item("at_rest", PyArray1::from_iter(py, blocks.iter().map(|block| block.at_rest)))?;
    fields.set_item("accel", vectors(|block| block.statistics.specific_force().into())?)?;
    fields.set_item("gyro", vectors(|block| block.statistics.angular_rate().into())?)?;
    fields.set_item("accel_std", vectors(|block| block.statistics.accel_std().into())?)?;
    fields.set_item("gyro_std", vectors(|block| block.statistics.gyro_std().into())?)?;
    fields.set_item("accel_drift", vectors(|block| block.accel_drift)?)?;
    fields.set_item("gyro_drift", vectors(|block| block.gyro_drift)?)?;
    Ok(fields)
}
