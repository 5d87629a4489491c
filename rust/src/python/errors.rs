//! The exceptions of `footnav.errors`, and how the core's errors become them.

use pyo3::prelude::*;

use crate::error::{ConfigError as CoreConfigError, Error};

pyo3::import_exception!(footnav.errors, BusyError);
pyo3::import_exception!(footnav.errors, ConfigError);
pyo3::import_exception!(footnav.errors, DataError);
pyo3::import_exception!(footnav.errors, NumericalError);

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        match error {
            Error::Config(error) => ConfigError::new_err(error.to_string()),
            Error::Data(error) => DataError::new_err(error.to_string()),
            Error::Numerical(error) => NumericalError::new_err(error.to_string()),
        }
    }
}

impl From<CoreConfigError> for PyErr {
    fn from(error: CoreConfigError) -> Self {
        ConfigError::new_err(error.to_string())
    }
}
