//! Phantom → channel data.

use bonebeam_simulate::Simulate;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::refused;
use crate::files::channel_data;
use crate::threads::{Threads, interruptible, threads};

/// Simulates channel data from section `[simulate]`, given as JSON.
///
/// The result has the keys of a `.npz` recording, and the keys of its truth's file as `truth`.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    section: &str,
    threads: Option<Threads>,
) -> PyResult<Bound<'py, PyDict>> {
    let pool = self::threads(threads)?;
    let mut section: Simulate = serde_json::from_str(section).map_err(refused)?;
    section.validate().map_err(refused)?;
    let recorded = interruptible(py, &pool, move |progress| section.recorded(progress))?;
    let (data, truth) = recorded.map_err(refused)?;
    let values = PyDict::new(py);
    values.set_item("scatterers", truth.scatterers.into_pyarray(py))?;
    values.set_item("on_bone", truth.on_bone)?;
    values.set_item("outline", truth.outline.into_pyarray(py))?;
    if let Some((levels, place)) = truth.levels {
        values.set_item("level_db", levels.into_pyarray(py))?;
        for (name, value) in ["level_x0", "level_z0", "level_pixel"]
            .into_iter()
            .zip(place)
        {
            values.set_item(name, value)?;
        }
    }
    let keys = channel_data(py, data)?;
    keys.set_item("truth", values)?;
    Ok(keys)
}
