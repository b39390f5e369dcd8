//! Measures of points, regions and surfaces.

use bonebeam_measure::contrast::{cnr, contrast_ratio, gcnr, speckle_snr};
use bonebeam_measure::point::PointSpread;
use bonebeam_measure::surface::{Known, judge};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::refused;
use crate::lines::LinesArrays;

/// Measures of the point with the largest envelope, by their names in Python.
#[pyfunction]
pub fn point_spread<'py>(
    py: Python<'py>,
    lines: LinesArrays<'py>,
    near: Option<[f64; 2]>,
    reach: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let spread = PointSpread::new(&lines.checked()?, near, reach).map_err(refused)?;
    let values = PyDict::new(py);
    values.set_item("x", spread.x)?;
    values.set_item("z", spread.z)?;
    values.set_item("envelope", spread.envelope)?;
    for (name, profile) in [("lateral", &spread.lateral), ("axial", &spread.axial)] {
        values.set_item(format!("{name}_6db"), profile.width(-6.0))?;
        values.set_item(format!("{name}_12db"), profile.width(-12.0))?;
        values.set_item(format!("{name}_spacing"), profile.spacing())?;
    }
    values.set_item("side_lobe", spread.lateral.side_lobe())?;
    Ok(values)
}

/// Least level below the largest envelope, as a factor.
const FLOOR: f64 = 1e-6;

/// gCNR of levels in dB, CNR and contrast of envelopes in two regions.
#[pyfunction]
pub fn contrast(
    inside: PyReadonlyArray1<'_, f64>,
    outside: PyReadonlyArray1<'_, f64>,
) -> PyResult<[Option<f64>; 3]> {
    let (a, b) = (inside.as_slice()?, outside.as_slice()?);
    let largest = a.iter().chain(b).copied().fold(0.0, f64::max);
    let level = |v: &f64| 20.0 * (v / largest).max(FLOOR).log10();
    let [of_a, of_b] = [a, b].map(|values| values.iter().map(level).collect::<Vec<_>>());
    Ok([gcnr(&of_a, &of_b), cnr(a, b), contrast_ratio(a, b)])
}

/// SNR of the speckle in envelopes.
#[pyfunction]
#[pyo3(name = "speckle_snr")]
pub fn speckle(envelope: PyReadonlyArray1<'_, f64>) -> PyResult<Option<f64>> {
    Ok(speckle_snr(envelope.as_slice()?))
}

/// Scores of the depths of a surface, by their names in Python.
///
/// `depths` has columns for the lateral positions, the found depths and the known ones, m; NaN is none.
#[pyfunction]
pub fn surface_scores<'py>(
    py: Python<'py>,
    depths: PyReadonlyArray2<'py, f64>,
    tolerance: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let column = |k: usize| depths.as_array().column(k).to_vec();
    let [found, known] = [1, 2].map(|k| {
        let finite = |depth: f64| depth.is_finite().then_some(depth);
        column(k).into_iter().map(finite).collect::<Vec<_>>()
    });
    let known = Known {
        x: &column(0),
        depths: &known,
    };
    let judged = judge(&found, known, tolerance);
    let values = PyDict::new(py);
    values.set_item("found", judged.answers)?;
    values.set_item("known", judged.surfaces)?;
    values.set_item("hits", judged.hits_mm.len())?;
    values.set_item("precision", judged.precision())?;
    values.set_item("recall", judged.recall())?;
    values.set_item("f1", judged.f1())?;
    values.set_item("mean", judged.mean_mm().map(|mm| 1e-3 * mm))?;
    values.set_item("p95", judged.p95_mm().map(|mm| 1e-3 * mm))?;
    Ok(values)
}
