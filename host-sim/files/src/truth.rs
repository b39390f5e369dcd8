//! What a simulated recording is of: scatterers, the bone's outline and surface, levels of brightness.

use std::error::Error as StdError;
use std::io::Write;
use std::path::Path;

use ndarray::{Array2, Array3, arr0};
use ndarray_npy::NpzWriter;
use ply_rs_bw::ply::{
    Addable, ElementDef, Encoding, Ply, PropertyAccess, PropertyDef, PropertyType, ScalarType,
};
use ply_rs_bw::writer::Writer;

use super::atomic::Outputs;
use super::npz;
use crate::{Error, Result};

/// The truth of a recording, lengths in m along the array's axes.
pub struct Truth {
    /// x, y, z and amplitude, `[scatterer, 4]`; those on the bone first.
    pub scatterers: Array2<f32>,
    /// How many of them lie on the bone.
    pub on_bone: usize,
    /// The bone's outline in the image plane: x and z of both ends, `[segment, end, 2]`.
    pub outline: Array3<f64>,
    /// The level at every pixel, dB, where the phantom has known levels; x and z of the first pixel and the
    /// distance between pixels, m.
    pub levels: Option<(Array2<f32>, [f64; 3])>,
}

impl Truth {
    /// Stages the file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn stage(&self, path: &Path, outputs: &mut Outputs) -> Result<()> {
        outputs.stage(path, |sink| {
            let mut npz =
                NpzWriter::new_with_options(sink, npz::options(self.scatterers.len() * 4));
            npz.add_array("scatterers", &self.scatterers)?;
            npz.add_array("on_bone", &arr0(self.on_bone as i64))?;
            npz.add_array("outline", &self.outline)?;
            if let Some((levels, place)) = &self.levels {
                npz.add_array("level_db", levels)?;
                npz.add_array("level_x0", &arr0(place[0]))?;
                npz.add_array("level_z0", &arr0(place[1]))?;
                npz.add_array("level_pixel", &arr0(place[2]))?;
            }
            npz.finish()?;
            Ok(())
        })
    }
}

/// Stages a surface as a binary PLY file in mm, corners in m.
///
/// # Errors
/// It cannot be written.
pub fn stage_surface(
    path: &Path,
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
    outputs: &mut Outputs,
) -> Result<()> {
    outputs.stage(path, |sink| write_ply(sink, vertices, triangles))
}

/// The bytes of the same.
///
/// # Errors
/// It cannot be written.
pub fn ply(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_ply(&mut bytes, vertices, triangles)
        .map_err(|e| Error::Data(format!("the surface cannot be written: {e}")))?;
    Ok(bytes)
}

/// A line of the file: a surface may have millions, too many for the library's own maps.
enum Entry {
    Corner([f32; 3]),
    Face([i32; 3]),
}

impl PropertyAccess for Entry {
    fn new() -> Self {
        Entry::Corner([0.0; 3])
    }

    fn get_float(&self, name: &str) -> Option<f32> {
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == name)?;
        match self {
            Entry::Corner(corner) => Some(corner[axis]),
            Entry::Face(_) => None,
        }
    }

    fn get_list_int(&self, _: &str) -> Option<&[i32]> {
        match self {
            Entry::Corner(_) => None,
            Entry::Face(corners) => Some(corners),
        }
    }
}

fn write_ply<W: Write>(
    sink: &mut W,
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
) -> std::result::Result<(), Box<dyn StdError>> {
    let mut ply = Ply::<Entry>::new();
    ply.header.encoding = Encoding::BinaryLittleEndian;
    let mut vertex = ElementDef::new("vertex".into());
    for axis in ["x", "y", "z"] {
        vertex.properties.add(PropertyDef::new(
            axis.into(),
            PropertyType::Scalar(ScalarType::Float),
        ));
    }
    let mut face = ElementDef::new("face".into());
    face.properties.add(PropertyDef::new(
        "vertex_indices".into(),
        PropertyType::List(ScalarType::UChar, ScalarType::Int),
    ));
    ply.header.elements.add(vertex);
    ply.header.elements.add(face);
    let millimetres = |v: f64| (1e3 * v) as f32;
    let vertices = vertices.iter().map(|v| Entry::Corner(v.map(millimetres)));
    let faces = triangles.iter().map(|t| Entry::Face(t.map(|k| k as i32)));
    ply.payload.insert("vertex".into(), vertices.collect());
    ply.payload.insert("face".into(), faces.collect());
    ply.make_consistent()?;
    Writer::new().write_ply(sink, &mut ply)?;
    Ok(())
}
