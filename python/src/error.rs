//! Errors as Python's `ValueError`, with Python's keywords.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

use crate::words::in_python;

/// Converts an error of the host.
pub fn refused(error: impl Display) -> PyErr {
    PyValueError::new_err(in_python(&error.to_string()))
}
