//! Errors as Python's `ValueError`, in the command's words.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

/// The command's error.
pub fn refused(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}
