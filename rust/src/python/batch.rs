//! `footnav._core.Batch`.

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::config::Config;
use crate::detectors::detector::Detector;
use crate::detectors::scripted::Scripted;
use crate::error::Error;
use crate::pipeline::batch::Batch;
use crate::python::block::Block;
use crate::python::conversion::from_json;
use crate::python::detector::{Failure, PyDetector};
use crate::python::errors::DataError;
use crate::python::exclusive::Exclusive;
use crate::python::gait::columns_with_covariance;
use crate::python::navigator::{columns, health_fields};

/// Samples that are copied out of `NumPy`'s memory at once, so that the copy stays near the
/// processor.
const PART: usize = 500;

/// Batch tracking; `footnav.track` makes a trajectory of the columns.
#[pyclass(frozen, name = "Batch", module = "footnav._core")]
pub(super) struct PyBatch {
    /// Absent once it was finished.
    inner: Exclusive<Option<Batch>>,
    /// What a detector of the user's raised; absent with one of the core's.
    failure: Option<Failure>,
    /// Whether strides are tracked.
    strides: bool,
}

type Finished<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>, Option<Bound<'py, PyDict>>);

#[pymethods]
impl PyBatch {
    #[new]
    #[pyo3(signature = (config, rate_hz, detector=None, stationary=None))]
    fn new(
        config: &[u8],
        rate_hz: f64,
        detector: Option<&Bound<'_, PyAny>>,
        stationary: Option<Vec<bool>>,
    ) -> PyResult<Self> {
        let config: Config = from_json(config)?;
        let strides = config.output.strides;
        let with =
            |detector: Box<dyn Detector>| Batch::with_detector(config.clone(), rate_hz, detector);
        let (inner, failure) = match (detector, stationary) {
            (Some(object), _) => {
                let (detector, failure) = PyDetector::new(object)?;
                (with(Box::new(detector))?, Some(failure))
            }
            (None, Some(decisions)) => (with(Box::new(Scripted::new(decisions)))?, None),
            (None, None) => (Batch::new(config, rate_hz)?, None),
        };
        Ok(Self { inner: Exclusive::new(Some(inner)), failure, strides })
    }

    /// Reads the arrays while the interpreter is left to others: they are a recording's, which
    /// nothing writes to.
    #[pyo3(signature = (t, accel, gyro, mag=None))]
    fn push_block(
        &self,
        py: Python<'_>,
        t: PyReadonlyArray1<'_, f64>,
        accel: PyReadonlyArray2<'_, f64>,
        gyro: PyReadonlyArray2<'_, f64>,
        mag: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<()> {
        let columns = (t, accel, gyro);
        let block = Block::of(&columns)?;
        let fields = mag.map(|mag| block.fields(&mag)).transpose()?;
        let mut inner = self.inner.lock()?;
        let batch = (**inner).as_mut().ok_or_else(finished)?;
        fields.iter().flatten().for_each(|reading| batch.push_reading(*reading));
        let pushed = py.detach(|| push_in_parts(batch, &block));
        self.check(py)?;
        Ok(pushed?)
    }

    /// Columns of the track, fields of its health, and columns of its strides if the settings ask
    /// for them.
    ///
    /// `progress` is called now and then; its exception, and an interrupt from the keyboard,
    /// ends the work.
    fn finish<'py>(
        &self,
        py: Python<'py>,
        progress: &Bound<'py, PyAny>,
    ) -> PyResult<Finished<'py>> {
        let batch = self.inner.lock()?.take().ok_or_else(finished)?;
        let progress = progress.clone().unbind();
        let progress = || {
            Python::attach(|py| {
                py.check_signals()?;
                progress.call0(py).map(drop)
            })
        };
        let track = py.detach(|| batch.finish_with_progress(progress));
        self.check(py)?;
        let (trajectory, health, strides) = track?;
        let strides = self.strides.then(|| columns_with_covariance(py, &strides)).transpose()?;
        Ok((columns(py, trajectory)?, health_fields(py, &health)?, strides))
    }
}

impl PyBatch {
    /// Raises what the user's detector raised.
    fn check(&self, py: Python<'_>) -> PyResult<()> {
        self.failure.as_ref().map_or(Ok(()), |failure| failure.check(py))
    }
}

fn push_in_parts(batch: &mut Batch, block: &Block<'_>) -> Result<(), Error> {
    batch.reserve(block.len());
    let mut samples = Vec::with_capacity(PART);
    for start in (0..block.len()).step_by(PART) {
        samples.clear();
        block.part(start..block.len().min(start + PART)).copy_to(&mut samples);
        batch.push_block(&samples)?;
    }
    Ok(())
}

fn finished() -> PyErr {
    DataError::new_err("the recording was finished; begin another one")
}
