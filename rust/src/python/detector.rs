//! A stance detector that is a Python object: `footnav.protocols.StanceDetector`.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;

use crate::detectors::detector::{Decision, Detector};
use crate::python::errors::ConfigError;
use crate::types::sample::ImuSample;

/// Most samples that a detector may be late by; they all wait in memory.
const LATENCY_LIMIT: usize = 1_000_000;

/// The first exception that a detector raised, shared with whoever hands it on to Python.
#[derive(Clone, Default)]
pub(super) struct Failure(Arc<Mutex<Option<PyErr>>>);

impl Failure {
    /// Raises the exception, again and again until it is cleared.
    pub(super) fn check(&self, py: Python<'_>) -> PyResult<()> {
        self.slot().as_ref().map_or(Ok(()), |error| Err(error.clone_ref(py)))
    }

    fn slot(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Bridges a Python object to the core.
///
/// The core cannot carry a Python exception, so the first one is kept in `failure` and no decision
/// is made any more until a reset.
pub(super) struct PyDetector {
    object: Py<PyAny>,
    latency: usize,
    seen: usize,
    answered: usize,
    failure: Failure,
}

impl PyDetector {
    /// Takes over `object` after a reset; the second value holds its exceptions.
    pub(super) fn new(object: &Bound<'_, PyAny>) -> PyResult<(Self, Failure)> {
        for attribute in ["latency", "push", "reset"] {
            if !object.hasattr(attribute)? {
                return Err(lacks(object, attribute)?);
            }
        }
        object.call_method0("reset")?;
        let failure = Failure::default();
        let latency = latency(object)?;
        let detector = Self {
            object: object.clone().unbind(),
            latency,
            seen: 0,
            answered: 0,
            failure: failure.clone(),
        };
        Ok((detector, failure))
    }

    fn ask(&self, py: Python<'_>, sample: &ImuSample) -> PyResult<Option<bool>> {
        let vector = |v: &nalgebra::Vector3<f64>| (v.x, v.y, v.z);
        let arguments = (sample.time, vector(&sample.specific_force), vector(&sample.angular_rate));
        let answer = self.object.bind(py).call_method1("push", arguments)?;
        let due = self.seen >= self.latency;
        match answer.extract::<Option<bool>>() {
            Ok(decision) if decision.is_some() == due => Ok(decision),
            _ => Err(self.misbehaves(&answer, if due { "a bool" } else { "None" })?),
        }
    }

    fn misbehaves(&self, answer: &Bound<'_, PyAny>, expected: &str) -> PyResult<PyErr> {
        Ok(ConfigError::new_err(format!(
            "sample {}: the detector's push returned {}; expected {expected}, \
             since its latency is {} samples",
            self.seen,
            answer.repr()?,
            self.latency
        )))
    }
}

impl Detector for PyDetector {
    fn latency(&self) -> usize {
        self.latency
    }

    fn push(&mut self, sample: &ImuSample) -> Option<Decision> {
        if self.failure.slot().is_some() {
            return None;
        }
        let answer = Python::attach(|py| self.ask(py, sample));
        self.seen += 1;
        match answer {
            Ok(decision) => {
                self.answered += usize::from(decision.is_some());
                decision.map(Decision::without_statistic)
            }
            Err(error) => {
                *self.failure.slot() = Some(error);
                None
            }
        }
    }

    fn drain(&mut self) -> Option<Decision> {
        let owes = self.answered < self.seen && self.failure.slot().is_none();
        self.answered += usize::from(owes);
        owes.then_some(Decision::UNKNOWN)
    }

    fn reset(&mut self) {
        (self.seen, self.answered) = (0, 0);
        let failure = Python::attach(|py| self.object.call_method0(py, "reset")).err();
        *self.failure.slot() = failure;
    }
}

fn latency(object: &Bound<'_, PyAny>) -> PyResult<usize> {
    let value = object.getattr("latency")?;
    match value.extract::<usize>() {
        Ok(latency) if latency <= LATENCY_LIMIT => Ok(latency),
        _ => Err(ConfigError::new_err(format!(
            "the detector's latency is {}; expected a whole number of samples between 0 and {LATENCY_LIMIT}",
            value.repr()?
        ))),
    }
}

fn lacks(object: &Bound<'_, PyAny>, attribute: &str) -> PyResult<PyErr> {
    Ok(ConfigError::new_err(format!(
        "detector is a {} and has no {attribute}; expected latency, push and reset as in \
         footnav.protocols.StanceDetector \
         (settings of footnav's own detectors go into Config(detector=...))",
        object.get_type().name()?
    )))
}
