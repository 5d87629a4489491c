//! One call at a time.

use std::sync::{Mutex, MutexGuard, TryLockError};

use pyo3::prelude::*;

use crate::python::errors::BusyError;

/// A value for one call at a time; a second call raises instead of waiting, since the state that it
/// would find depends on the order of the calls.
///
/// Boxed, because Python aligns its objects to 16 bytes and the covariance wants 32.
pub(super) struct Exclusive<T>(Mutex<Box<T>>);

const _: () = assert!(
    align_of::<Exclusive<crate::pipeline::navigator::Navigator>>() <= 16,
    "Python would misplace it"
);

impl<T> Exclusive<T> {
    pub(super) fn new(value: T) -> Self {
        Self(Mutex::new(Box::new(value)))
    }

    /// Raises `BusyError` while another call is at work.
    #[inline]
    pub(super) fn lock(&self) -> PyResult<MutexGuard<'_, Box<T>>> {
        match self.0.try_lock() {
            Ok(guard) => Ok(guard),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(busy()),
        }
    }
}

#[cold]
fn busy() -> PyErr {
    BusyError::new_err(
        "another call is at work on this object, in another thread or around a detector of your own: \
         give each foot its own navigator, and hold a lock where threads share one",
    )
}
