//! Lines → image → map.

use std::num::NonZeroUsize;

use bonebeam::simd::InstructionSet;
use bonebeam_drive::image::image_of;
use bonebeam_drive::phase_symmetry::{Parameters, Plan};
use bonebeam_files::{BeamRays, Lines};
use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use numpy::{Complex32, IntoPyArray, PyArray2, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::prelude::*;

use crate::error::refused;
use crate::parameters;
use crate::threads::threads;

/// Pixels with where they are: `(pixels, x0, z0, pixel)`.
type Pixels<'py> = (Bound<'py, PyArray2<f32>>, f64, f64, f64);

/// The B-mode image of lines.
#[pyfunction]
pub fn bmode<'py>(
    py: Python<'py>,
    z: PyReadonlyArray2<'py, Complex32>,
    fs: f64,
    t0: f64,
    beam_x: Vec<f64>,
    rays: Option<(Vec<f64>, Vec<f64>)>,
    c: f64,
    dynamic_range: f64,
    rows: Option<usize>,
    columns: Option<usize>,
    depth: Option<f64>,
    width: Option<f64>,
    median: bool,
    threads: Option<NonZeroUsize>,
) -> PyResult<Pixels<'py>> {
    let section = parameters::image(dynamic_range, rows, columns, depth, width, median)?;
    let pool = self::threads(threads)?;
    let lines = Lines {
        z: z.as_array(),
        fs,
        t0,
        beam_x,
        rays: rays.map(|(z, angle)| BeamRays { z, angle }),
        c,
    };
    let image = py
        .detach(|| pool.install(|| image_of(&lines.checked()?, &section)))
        .map_err(refused)?;
    let pixels = image.pixels.into_pyarray(py);
    Ok((pixels, image.x0, image.z0, image.pixel))
}

/// The phase symmetry of an image, into `out`.
#[pyfunction]
pub fn phase_symmetry(
    py: Python<'_>,
    image: PyReadonlyArray2<'_, f32>,
    scales: Vec<f64>,
    threshold: f64,
    strip: usize,
    pad: bool,
    mut out: PyReadwriteArray2<'_, f32>,
    threads: Option<NonZeroUsize>,
) -> PyResult<()> {
    let section = parameters::phase_symmetry(scales, threshold, strip, pad)?;
    let pool = self::threads(threads)?;
    let (image, map) = (image.as_array(), out.as_array_mut());
    let padded = section.padded(image.dim());
    let parameters = Parameters {
        scales: section.scales,
        threshold: section.threshold as f32,
        strip: section.strip,
    };
    let run = || match padded {
        Some(sides) => filter_padded(image, sides, &parameters, map),
        None => filter(image, &parameters, map),
    };
    py.detach(|| pool.install(run)).map_err(refused)
}

fn filter(
    image: ArrayView2<'_, f32>,
    parameters: &Parameters,
    map: ArrayViewMut2<'_, f32>,
) -> bonebeam_files::Result<()> {
    let mut plan = Plan::new(image.dim(), parameters)?;
    plan.run_into(image, InstructionSet::detect(), &mut |_, _| {}, map)
}

/// In a black image of larger sides; what is beside the image is cut off the map.
fn filter_padded(
    image: ArrayView2<'_, f32>,
    sides: (usize, usize),
    parameters: &Parameters,
    mut map: ArrayViewMut2<'_, f32>,
) -> bonebeam_files::Result<()> {
    let level = |at: (usize, usize)| image.get(at).copied().unwrap_or(0.0);
    let larger = Array2::from_shape_fn(sides, level);
    let mut whole = Array2::zeros(sides);
    filter(larger.view(), parameters, whole.view_mut())?;
    for (at, symmetry) in map.indexed_iter_mut() {
        *symmetry = whole[at];
    }
    Ok(())
}
