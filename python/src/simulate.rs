//! Phantom → channel data.

use bonebeam_simulate::Simulate;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::refused;
use crate::files::channel_data;
use crate::threads::{Threads, interruptible, threads};

/// Simulates channel data from section `[simulate]`, given as JSON.
///
/// The result has the keys of a `.npz` recording.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    section: &str,
    threads: Option<Threads>,
) -> PyResult<Bound<'py, PyDict>> {
    let pool = self::threads(threads)?;
    let mut section: Simulate = serde_json::from_str(section).map_err(refused)?;
    section.validate().map_err(refused)?;
    let data = interruptible(py, &pool, move |progress| section.recorded(progress))?;
    channel_data(py, data.map_err(refused)?)
}
