//! Lines or a picture → the bone surface.

use bonebeam_drive::config::Surface;
use bonebeam_drive::surface::{
    Picture, PictureFan, SurfacePoint, of_lines, of_lines_with_coherence, of_picture,
};
use bonebeam_files::{BeamRays, BeamformedLines};
use numpy::{Complex32, IntoPyArray, PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::error::refused;
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
    z: PyReadonlyArray2<'py, Complex32>,
    fs: f64,
    t0: f64,
    beam_x: Vec<f64>,
    rays: Option<(Vec<f64>, Vec<f64>)>,
    sub_lines: usize,
    c: f64,
    coherence: Option<PyReadonlyArray2<'py, f32>>,
    section: &str,
) -> PyResult<Points<'py>> {
    let section = parameters::surface(section)?;
    let lines = BeamformedLines {
        z: z.as_array(),
        fs,
        t0,
        beam_x,
        rays: rays.map(|(z, angle)| BeamRays { z, angle }),
        sub_lines,
        c,
    };
    let coherence = coherence.as_ref().map(|map| map.as_array());
    let found = py.detach(|| match coherence {
        Some(map) => of_lines_with_coherence(&lines.checked()?, map, &section),
        None => of_lines(&lines.checked()?, &section),
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
