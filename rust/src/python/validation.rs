//! `footnav._core.sample_flags`: what input validation finds in a recording.

use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::config::Config;
use crate::pipeline::validation::InputValidator;
use crate::python::block::Block;
use crate::python::conversion::from_json;

/// Flags of every sample, as bits of `footnav.health.Flag`: a gap before it, clipping.
///
/// The rate is rounded to whole hertz, as a navigator rounds it.
#[pyfunction]
pub(super) fn sample_flags<'py>(
    py: Python<'py>,
    config: &[u8],
    rate_hz: f64,
    t: PyReadonlyArray1<'py, f64>,
    accel: PyReadonlyArray2<'py, f64>,
    gyro: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<u16>>> {
    let config: Config = from_json(config)?;
    let samples = Block::of(&(t, accel, gyro))?.samples();
    let mut validator = InputValidator::new(&config, 1.0 / rate_hz.round().max(1.0));
    let flags = samples.iter().map(|sample| validator.ingest(sample).map(|flags| flags.bits()));
    let flags = flags.collect::<Result<Vec<_>, _>>().map_err(crate::error::Error::Data)?;
    Ok(PyArray1::from_vec(py, flags))
}
