//! Bones given as a triangle mesh in a PLY, STL or OBJ file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use crate::{Error, Result};
use bonebeam_files::input;
use bonebeam_files::terminal::short;

use super::outline::Outline;
use super::ply::{self, Columns, Raw};
use super::surface::Surface;

/// Outline of a mesh at height `slice` in m.
///
/// The file is in mm with +x towards the front, y across and +z towards the head. The outline's x is the mesh's y
/// and its z the mesh's x, so that the back faces the array. The surface must be closed at that height.
///
/// # Errors
/// A file that cannot be read, or a mesh that the plane does not cut or that is open there.
pub fn slice_mesh(path: &Path, slice: f64) -> Result<Outline> {
    let mesh = read(path, MAX_EXTENT)?;
    let outline = mesh.placed(slice).outline();
    if let Some(outline) = outline.map_err(|message| file_error(path, message))? {
        return Ok(outline);
    }
    let z = |f: fn(f64, f64) -> f64, start| mesh.vertices.iter().map(|v| v[2]).fold(start, f);
    Err(Error::Usage(format!(
        "slice at {} mm does not cut {}, which spans {} to {} mm",
        1e3 * slice,
        path.display(),
        z(f64::min, f64::INFINITY),
        z(f64::max, f64::NEG_INFINITY)
    )))
}

/// As [`slice_mesh`], from the bytes of a PLY file.
///
/// # Errors
/// As [`slice_mesh`].
pub fn slice_ply(bytes: &[u8], slice: f64) -> Result<Outline> {
    let raw = ply::read(bytes, bytes.len() as u64);
    let outline = raw
        .and_then(|raw| weld(raw, MAX_EXTENT))
        .and_then(|mesh| mesh.placed(slice).outline());
    let outline = outline.and_then(|outline| outline.ok_or_else(|| "is not cut".into()));
    outline.map_err(|message| Error::Data(format!("the mesh {message}")))
}

/// The whole surface of a mesh, placed as in [`slice_mesh`], with warnings.
///
/// The height `slice` is at elevation 0. Warnings are sentences on values that are probably a mistake.
///
/// # Errors
/// A file that cannot be read, or a surface that is not closed.
pub fn read_mesh(path: &Path, slice: f64) -> Result<(Surface, Vec<String>)> {
    let mesh = read(path, MAX_EXTENT)?;
    let mut surface = mesh.placed(slice);
    let mut warnings = Vec::new();
    let found = surface
        .check()
        .map_err(|message| file_error(path, message))?;
    if found.inverted {
        surface = surface.inside_out();
        warnings.push(inside_out(path));
    }
    if found.mixed > 0 {
        warnings.push(format!(
            "{}: at {} edges two triangles have opposite winding; the surface is used as it is",
            path.display(),
            found.mixed
        ));
    }
    Ok((surface, warnings))
}

fn inside_out(path: &Path) -> String {
    format!(
        "{}: the surface is inside out; its triangles are reversed",
        path.display()
    )
}

/// A mesh as it stands in its file, in mm, closed or not, with warnings.
///
/// # Errors
/// A file that cannot be read, or a mesh without triangles.
pub fn read_surface(path: &Path) -> Result<(Surface, Vec<String>)> {
    let mesh = read(path, MAX_DISTANCE)?;
    let index = |k: usize| k as u32;
    let triangles = mesh.triangles.iter().map(|t| t.map(index));
    let surface = Surface::new(mesh.vertices, triangles.collect());
    Ok(match surface.check() {
        Ok(found) if found.inverted => (surface.inside_out(), vec![inside_out(path)]),
        _ => (surface, Vec::new()),
    })
}

/// The values of a PLY file's vertices by their names; it needs no faces.
///
/// # Errors
/// A file that cannot be read.
pub fn read_vertices(path: &Path) -> Result<Columns> {
    let (reader, length) = open_ply(path)?;
    ply::read_columns(reader, length).map_err(|message| file_error(path, message))
}

fn file_error(path: &Path, message: String) -> Error {
    Error::File {
        path: path.to_path_buf(),
        message,
    }
}

/// A triangle mesh.
struct Mesh {
    /// Vertices in mm; no two are equal.
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// In m along the array's axes: lateral is the mesh's y, elevation z, depth x.
    fn placed(&self, slice: f64) -> Surface {
        let position = |[x, y, z]: &[f64; 3]| [1e-3 * y, 1e-3 * z - slice, 1e-3 * x];
        let index = |k: usize| k as u32;
        Surface::new(
            self.vertices.iter().map(position).collect(),
            self.triangles.iter().map(|t| t.map(index)).collect(),
        )
    }
}

/// Largest distance of a bone's surface from the origin, mm.
const MAX_EXTENT: f64 = 1000.0;
/// The same in a scanner's coordinates.
const MAX_DISTANCE: f64 = 10_000.0;
/// Smallest size of a bone, mm; a smaller mesh is in metres.
const MIN_EXTENT: f64 = 1.0;

/// Reads the mesh of a file, by the ending of its name: STL, OBJ, else PLY.
fn read(path: &Path, most: f64) -> Result<Mesh> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    let raw = match ending.to_ascii_lowercase().as_str() {
        "stl" => read_stl(path)?,
        "obj" => read_obj(path)?,
        _ => read_ply(path)?,
    };
    weld(raw, most).map_err(|message| file_error(path, message))
}

/// Joins corners at the same position, which STL repeats per triangle; checks them.
///
/// `most` is the largest distance from the origin, mm.
fn weld(raw: Raw, most: f64) -> std::result::Result<Mesh, String> {
    let mut vertices = Vec::new();
    let mut known = BTreeMap::new();
    let mut merged = Vec::new();
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (index, position) in raw.vertices.iter().enumerate() {
        for (axis, (&value, key)) in position.iter().zip(["x", "y", "z"]).enumerate() {
            if !value.is_finite() {
                return Err(format!("vertex {index}: {key} is not finite"));
            }
            if value.abs() > most {
                return Err(format!(
                    "vertex {index}: {key} is {} mm; expected at most {most} mm either way",
                    short(value)
                ));
            }
            low[axis] = low[axis].min(value);
            high[axis] = high[axis].max(value);
        }
        let fresh = vertices.len();
        // 0 and −0 are one position.
        let found = *known
            .entry(position.map(|v| (v + 0.0).to_bits()))
            .or_insert(fresh);
        if found == fresh {
            vertices.push(*position);
        }
        merged.push(found);
    }
    let triangles: Vec<[usize; 3]> = (raw.triangles.iter())
        .map(|t| t.map(|k| merged[k]))
        // A triangle without area has no part in the surface.
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    if triangles.is_empty() {
        return Err("has no triangles".into());
    }
    let extent = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    if extent < MIN_EXTENT {
        return Err(format!(
            "the mesh spans {extent} mm; expected millimetres, at least {MIN_EXTENT}; it is probably in metres"
        ));
    }
    Ok(Mesh {
        vertices,
        triangles,
    })
}

/// Largest number of triangles: some gigabytes of file.
const MAX_TRIANGLES: usize = 50_000_000;

fn read_stl(path: &Path) -> Result<Raw> {
    let fail = |message: String| file_error(path, message);
    let file = input::open(path).map_err(|e| fail(input::cannot_be_opened(&e)))?;
    let mut reader = BufReader::new(file);
    let unreadable = |error: std::io::Error| fail(format!("not a readable STL file: {error}"));
    let triangles = stl_io::create_stl_reader(&mut reader).map_err(unreadable)?;
    let mut raw = Raw::default();
    for triangle in triangles {
        let triangle = triangle.map_err(unreadable)?;
        let first = raw.vertices.len();
        for vertex in triangle.vertices {
            raw.vertices.push([0, 1, 2].map(|k| f64::from(vertex[k])));
        }
        raw.triangles.push([first, first + 1, first + 2]);
        if raw.triangles.len() > MAX_TRIANGLES {
            return Err(fail(format!("has more than {MAX_TRIANGLES} triangles")));
        }
    }
    Ok(raw)
}

fn read_obj(path: &Path) -> Result<Raw> {
    let fail = |message: String| file_error(path, message);
    let file = input::open(path).map_err(|e| fail(input::cannot_be_opened(&e)))?;
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: false,
        ..Default::default()
    };
    // Colours and textures are of no use here.
    let nothing = |_: &Path| Ok((Vec::new(), Default::default()));
    let (models, _) = tobj::load_obj_buf(&mut BufReader::new(file), &options, nothing)
        .map_err(|error| fail(format!("not a readable OBJ file: {error}")))?;
    let mut raw = Raw::default();
    for tobj::Model { mesh, .. } in models {
        let first = raw.vertices.len();
        let (positions, _) = mesh.positions.as_chunks::<3>();
        raw.vertices
            .extend(positions.iter().map(|p| p.map(f64::from)));
        for t in mesh.indices.as_chunks::<3>().0 {
            let corners = t.map(|index| first + index as usize);
            if let Some(wrong) = corners.iter().find(|&&k| k >= raw.vertices.len()) {
                return Err(fail(format!(
                    "a face names vertex {wrong}, which does not exist"
                )));
            }
            raw.triangles.push(corners);
        }
    }
    Ok(raw)
}

fn read_ply(path: &Path) -> Result<Raw> {
    let (reader, length) = open_ply(path)?;
    ply::read(reader, length).map_err(|message| file_error(path, message))
}

/// A file and its length, bytes.
fn open_ply(path: &Path) -> Result<(BufReader<File>, u64)> {
    let open = |error: std::io::Error| file_error(path, input::cannot_be_opened(&error));
    let file = input::open(path).map_err(open)?;
    let length = file.metadata().map_err(open)?.len();
    Ok((BufReader::new(file), length))
}
