//! Points on bone and a surface from CT → a pose and residuals.

use std::path::PathBuf;

use bonebeam_register::{
    Bone, Cloud, Parameters, Registration, Rigid, Stretch, V3, Volume, register,
};
use bonebeam_simulate::Surface;
use bonebeam_tracked::Voxels;
use numpy::{IntoPyArray, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::refused;

/// Rows of three numbers.
fn vectors(array: &PyReadonlyArray2<'_, f64>) -> Vec<V3> {
    let rows = array.as_array();
    let row = |row: ndarray::ArrayView1<f64>| [row[0], row[1], row[2]];
    rows.rows().into_iter().map(row).collect()
}

/// A mesh in a file, or vertices and faces that Python has checked.
#[derive(FromPyObject)]
pub enum Mesh<'py> {
    File(PathBuf),
    Arrays(PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, u32>),
}

/// Registers points, [point, 3] in mm, to a mesh.
///
/// Returns values by the names of Python's result. `columns` are normals, paths, confidence and frame; empty if there are none. `landmarks` are those of the points and of
/// the mesh. The least determined motions are JSON.
#[pyfunction]
#[pyo3(name = "register")]
pub fn register_points<'py>(
    py: Python<'py>,
    points: PyReadonlyArray2<'py, f64>,
    columns: (
        PyReadonlyArray2<'py, f64>,
        PyReadonlyArray2<'py, f64>,
        Vec<f64>,
        Vec<i64>,
    ),
    mesh: Mesh<'py>,
    start: Option<Vec<f64>>,
    landmarks: Option<(PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>)>,
    fit: Option<&str>,
    both_sides: bool,
    threshold: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let (normals, paths, confidence, frame) = columns;
    let cloud = Cloud {
        points: vectors(&points),
        normals: vectors(&normals),
        paths: vectors(&paths),
        confidence,
        frame,
    };
    let start = match (start, landmarks) {
        (_, Some((from, to))) => {
            let pose = Rigid::of_landmarks(&vectors(&from), &vectors(&to));
            Some(pose.map_err(refused)?)
        }
        (Some(rows), None) => {
            let pose = Rigid::of_rows(&rows);
            Some(pose.map_err(|e| refused(format!("`start` {e}")))?)
        }
        (None, None) => None,
    };
    let parameters = Parameters {
        start,
        both_sides,
        stretch: match fit {
            None => Stretch::None,
            Some("scale") => Stretch::Scale,
            Some("sound_speed") => Stretch::SoundSpeed,
            Some(other) => {
                let message = format!("`fit` is {other}; expected \"scale\" or \"sound_speed\"");
                return Err(refused(message));
            }
        },
    };
    let read = || {
        let (vertices, faces) = match mesh {
            Mesh::File(path) if Voxels::recognizes(&path) => {
                let Voxels { sides, hu, to_lps } = Voxels::read(&path)?;
                return Bone::of_volume(&path, Volume { sides, hu, to_lps }, threshold);
            }
            Mesh::File(path) => return Ok(Bone::read(&path, threshold)?.0),
            Mesh::Arrays(vertices, faces) => (vertices, faces),
        };
        let face = |row: ndarray::ArrayView1<u32>| [row[0], row[1], row[2]];
        let faces = faces.as_array().rows().into_iter().map(face).collect();
        Ok::<_, bonebeam_register::Error>(Bone::new(Surface::new(vectors(&vertices), faces)))
    };
    let bone = read().map_err(refused)?;
    let found = py.detach(|| register(&cloud, &bone, &parameters));
    let found: Registration = found.map_err(refused)?;
    let matrix = |pose: &Rigid| ndarray::arr2(&pose.rows()).into_pyarray(py);
    let open = found.freedoms.iter().filter(|f| f.is_open());
    let open: Vec<String> = open.map(ToString::to_string).collect();
    let json = |text: serde_json::Result<String>| text.map_err(refused);
    let values = PyDict::new(py);
    values.set_item("pose", matrix(&found.pose))?;
    values.set_item("start", matrix(&found.start))?;
    values.set_item("factor", found.factor)?;
    values.set_item("points", ndarray::arr2(&found.points).into_pyarray(py))?;
    values.set_item("before", found.before.to_pyarray(py))?;
    values.set_item("after", found.after.to_pyarray(py))?;
    values.set_item("undetermined", open)?;
    values.set_item("motions", json(serde_json::to_string(&found.freedoms))?)?;
    values.set_item("other_pose", json(serde_json::to_string(&found.rival))?)?;
    Ok(values)
}
