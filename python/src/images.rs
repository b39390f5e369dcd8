//! Lines → image → map.

use bonebeam_drive::image::image_of;
use bonebeam_drive::phase_symmetry::of_image;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2, PyReadwriteArray2};
use pyo3::prelude::*;

use crate::error::refused;
use crate::lines::LinesArrays;
use crate::parameters;
use crate::threads::{Threads, threads};

/// Pixels with their positions: `(pixels, x0, z0, pixel, angles)`.
type Pixels<'py> = (
    Bound<'py, PyArray2<f32>>,
    f64,
    f64,
    [f64; 2],
    Option<Bound<'py, PyArray1<f64>>>,
);

/// The B-mode image of lines, by the keys of section `[image]` as JSON.
#[pyfunction]
pub fn bmode<'py>(
    py: Python<'py>,
    lines: LinesArrays<'py>,
    section: &str,
    threads: Option<Threads>,
) -> PyResult<Pixels<'py>> {
    let section = parameters::image(section)?;
    let pool = self::threads(threads)?;
    let lines = lines.checked()?;
    let image = py
        .detach(|| pool.install(|| image_of(&lines, &section)))
        .map_err(refused)?;
    let pixels = image.pixels.into_pyarray(py);
    let angles = image.angles.map(|angles| {
        let angles: Vec<f64> = (0..angles.count).map(|k| angles.position(k)).collect();
        angles.into_pyarray(py)
    });
    Ok((pixels, image.x0, image.z0, image.pixel, angles))
}

/// Writes the phase symmetry of an image into `out`.
///
/// `section` has the keys of `[phase_symmetry]` as JSON.
#[pyfunction]
pub fn phase_symmetry(
    py: Python<'_>,
    image: PyReadonlyArray2<'_, f32>,
    pixel: Option<[f64; 2]>,
    section: &str,
    mut out: PyReadwriteArray2<'_, f32>,
    threads: Option<Threads>,
) -> PyResult<()> {
    let section = parameters::phase_symmetry(section)?;
    let pool = self::threads(threads)?;
    let (image, mut map) = (image.as_array(), out.as_array_mut());
    let run = || of_image(image.to_owned(), &section, pixel, &mut |_, _| {});
    let found = py.detach(|| pool.install(run)).map_err(refused)?;
    map.assign(&found);
    Ok(())
}
