//! Slices of a bone given as a triangle mesh in a PLY file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, Header, Property};

use crate::{Error, Result};

use super::chain::{Segment, closed_loops};
use super::outline::Outline;

/// The outline of a mesh at height `slice` in m. The file is in mm with +x towards the front, y
/// across and +z towards the head; the outline's x is the mesh's y and its z the mesh's x, so
/// that the back faces the array. The surface must be closed at that height.
pub fn slice_mesh(path: &Path, slice: f64) -> Result<Outline> {
    let fail = |message: String| Error::File {
        path: path.to_path_buf(),
        message,
    };
    let Mesh {
        vertices,
        triangles,
    } = read(path)?;
    let height = |v: usize| vertices[v][2] - 1e3 * slice;
    let mut segments = Vec::new();
    for triangle in &triangles {
        let mut cut = Vec::with_capacity(2);
        for k in 0..3 {
            // A vertex on the plane counts as above it, so that every edge is cut or not, alike
            // for the triangles that share it; the order of its ends keeps the point's bits alike.
            let mut ends = [triangle[k], triangle[(k + 1) % 3]];
            ends.sort_unstable();
            let [a, b] = ends;
            if (height(a) >= 0.0) == (height(b) >= 0.0) {
                continue;
            }
            let w = height(a) / (height(a) - height(b));
            let at = |axis: usize| {
                1e-3 * (vertices[a][axis] + w * (vertices[b][axis] - vertices[a][axis]))
            };
            cut.push(((a, b), [at(1), at(0)]));
        }
        if let [(edge_a, a), (edge_b, b)] = cut[..] {
            segments.push(Segment {
                edges: [edge_a, edge_b],
                ends: [a, b],
            });
        }
    }
    if segments.is_empty() {
        let z = |f: fn(f64, f64) -> f64, start| vertices.iter().map(|v| v[2]).fold(start, f);
        return Err(Error::Usage(format!(
            "slice at {} mm does not cut {}, which spans {} to {} mm",
            1e3 * slice,
            path.display(),
            z(f64::min, f64::INFINITY),
            z(f64::max, f64::NEG_INFINITY)
        )));
    }
    let loops = closed_loops(&segments)
        .ok_or_else(|| fail(format!("the surface is not closed at {} mm", 1e3 * slice)))?;
    Outline::new(loops).map_err(|error| fail(error.to_string()))
}

/// A triangle mesh.
struct Mesh {
    /// In mm; no two are equal.
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
}

/// How far from the origin a bone's surface may lie, mm.
const MAX_EXTENT: f64 = 1000.0;

/// Memory is made by the counts of the header, so it must not claim more than the file can hold: each
/// property of each entry takes a byte at least.
fn check_counts(header: &Header, length: u64) -> std::result::Result<(), String> {
    for (name, element) in &header.elements {
        let least = element.properties.len().max(1);
        let claimed = (element.count as u64).saturating_mul(least as u64);
        if claimed > length {
            return Err(format!(
                "the PLY header claims {} entries of \"{name}\", more than the file's {length} bytes can hold",
                element.count
            ));
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<Mesh> {
    let fail = |message: String| Error::File {
        path: path.to_path_buf(),
        message,
    };
    let open = |error: std::io::Error| fail(format!("cannot be opened: {}", error.kind()));
    let file = File::open(path).map_err(open)?;
    let length = file.metadata().map_err(open)?.len();
    let unreadable = |error: ParseError| {
        // The parser explains itself over several lines.
        let reason = error.to_string().replace('\n', " ");
        fail(format!("not a readable PLY file: {}", reason.trim_end()))
    };
    let parser = Parser::<DefaultElement>::new();
    let mut reader = Reader::new(BufReader::new(file));
    let header = parser.read_header(&mut reader).map_err(unreadable)?;
    check_counts(&header, length).map_err(fail)?;
    let payload = parser
        .read_payload(&mut reader, &header)
        .map_err(unreadable)?;
    let element = |name: &str| {
        payload
            .get(name)
            .filter(|list| !list.is_empty())
            .ok_or_else(|| fail(format!("the PLY file has no element \"{name}\"")))
    };
    let mut vertices = Vec::new();
    let mut known = BTreeMap::new();
    let mut merged = Vec::new();
    for (index, vertex) in element("vertex")?.iter().enumerate() {
        let mut position = [0.0; 3];
        for (value, key) in position.iter_mut().zip(["x", "y", "z"]) {
            *value = match vertex.get(key) {
                Some(Property::Float(v)) => f64::from(*v),
                Some(Property::Double(v)) => *v,
                _ => {
                    return Err(fail(format!(
                        "vertex {index} needs {key} as float or double"
                    )));
                }
            };
            if !value.is_finite() {
                return Err(fail(format!("vertex {index}: {key} is not finite")));
            }
            if value.abs() > MAX_EXTENT {
                return Err(fail(format!(
                    "vertex {index}: {key} is {value} mm; expected at most {MAX_EXTENT} mm either way"
                )));
            }
        }
        let fresh = vertices.len();
        let found = *known.entry(position.map(f64::to_bits)).or_insert(fresh);
        if found == fresh {
            vertices.push(position);
        }
        merged.push(found);
    }
    let mut triangles = Vec::new();
    for (index, face) in element("face")?.iter().enumerate() {
        let corners = face
            .get("vertex_indices")
            .or_else(|| face.get("vertex_index"))
            .and_then(indices)
            .ok_or_else(|| fail(format!("face {index} needs a list vertex_indices")))?;
        let corner = |k: usize| {
            merged.get(corners[k]).copied().ok_or_else(|| {
                fail(format!(
                    "face {index} names vertex {} of {}",
                    corners[k],
                    merged.len()
                ))
            })
        };
        // A polygon is a fan of triangles.
        for k in 1..corners.len().max(2) - 1 {
            triangles.push([corner(0)?, corner(k)?, corner(k + 1)?]);
        }
    }
    Ok(Mesh {
        vertices,
        triangles,
    })
}

/// A list property as indices; none for another kind or for a negative index.
fn indices(property: &Property) -> Option<Vec<usize>> {
    match property {
        Property::ListInt(list) => list.iter().map(|&v| usize::try_from(v).ok()).collect(),
        Property::ListUInt(list) => list.iter().map(|&v| usize::try_from(v).ok()).collect(),
        Property::ListUShort(list) => Some(list.iter().map(|&v| usize::from(v)).collect()),
        Property::ListUChar(list) => Some(list.iter().map(|&v| usize::from(v)).collect()),
        _ => None,
    }
}
