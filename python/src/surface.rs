//! Lines or a picture → the bone surface.

use std::path::PathBuf;

use bonebeam_drive::config::Surface;
use bonebeam_drive::surface::{
    FrameSurface, Picture, PictureFan, SurfacePoint, add_surfaces_to, of_lines,
    of_lines_with_coherence, of_picture,
};
use bonebeam_files::atomic::Outputs;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::error::refused;
use crate::lines::LinesArrays;
use crate::parameters;

/// Points from the first line to the last: `(line, x, z, confidence, piece)`, lengths in m.
type Points<'py> = (
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<i64>>,
);

/// The apex, both radii in m and both angles in rad: `(x, z, begin, end, first, last)`.
type Fan = (f64, f64, f64, f64, f64, f64);

/// The surface in lines, by the keys of the section `[surface]` as JSON.
#[pyfunction]
pub fn surface_of_lines<'py>(
    py: Python<'py>,
    lines: LinesArrays<'py>,
    coherence: Option<PyReadonlyArray2<'py, f32>>,
    section: &str,
) -> PyResult<Points<'py>> {
    let section = parameters::surface(section)?;
    let lines = lines.checked()?;
    let coherence = coherence.as_ref().map(|map| map.as_array());
    let found = py.detach(|| match coherence {
        Some(map) => of_lines_with_coherence(&lines, map, &section),
        None => of_lines(&lines, &section),
    });
    Ok(arrays(py, &found.map_err(refused)?))
}

/// The surface in a picture: points, number of searched lines, fan, and verdict.
///
/// The beams of the fan are the lines.
#[pyfunction]
pub fn surface_of_picture<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArray2<'py, f32>,
    pixel: [f64; 2],
    x0: f64,
    z0: f64,
    depth: f64,
    fan: Option<Fan>,
    section: &str,
) -> PyResult<(Points<'py>, usize, Option<Fan>, String)> {
    let given = fan.map(|(x, z, begin, end, first, last)| PictureFan {
        x,
        z,
        radii: [begin, end],
        angles: [first, last],
    });
    let section = Surface {
        fan: given,
        ..parameters::surface(section)?
    };
    section.validate().map_err(refused)?;
    let picture = Picture {
        pixels: pixels.as_array(),
        pixel,
        x0,
        z0,
        depth,
    };
    let found = py.detach(|| of_picture(&picture, &section));
    let found = found.map_err(refused)?;
    let fan = found.fan.map(|fan| {
        let ([begin, end], [first, last]) = (fan.radii, fan.angles);
        (fan.x, fan.z, begin, end, first, last)
    });
    let verdict = found.verdict.to_string();
    Ok((arrays(py, &found.points), found.lines, fan, verdict))
}

/// Writes points as the command does; the file's ending sets the format.
///
/// Indices are [line, piece], values [x, z, confidence].
#[pyfunction]
pub fn save_surface(
    path: PathBuf,
    indices: Vec<[usize; 2]>,
    values: Vec<[f64; 3]>,
    lines: usize,
    verdict: Option<String>,
) -> PyResult<()> {
    let points = indices.iter().zip(&values);
    let points = points.map(|(&[line, piece], &[x, z, confidence])| SurfacePoint {
        line,
        x,
        z,
        confidence: confidence as f32,
        piece,
    });
    let frame = FrameSurface {
        frame: 0,
        points: points.collect(),
        verdict,
    };
    let mut outputs = Outputs::new();
    add_surfaces_to(&[frame], lines, None, &path, &mut outputs)
        .and_then(|()| outputs.commit())
        .map_err(refused)
}

fn arrays<'py>(py: Python<'py>, points: &[SurfacePoint]) -> Points<'py> {
    let of = |value: fn(&SurfacePoint) -> f64| {
        let values: Vec<f64> = points.iter().map(value).collect();
        values.into_pyarray(py)
    };
    let count = |value: fn(&SurfacePoint) -> usize| {
        let values: Vec<i64> = points.iter().map(|point| value(point) as i64).collect();
        values.into_pyarray(py)
    };
    let sure: Vec<f32> = points.iter().map(|point| point.confidence).collect();
    (
        count(|point| point.line),
        of(|point| point.x),
        of(|point| point.z),
        sure.into_pyarray(py),
        count(|point| point.piece),
    )
}
