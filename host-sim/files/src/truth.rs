//! The ground truth of a simulated recording.
//!
//! Scatterers, the bone's outline and surface, levels of brightness.

use std::io::{self, Write};
use std::path::Path;

use ndarray::{Array2, Array3, arr0};

use super::atomic::Outputs;
use super::npz_writer;
use crate::{Error, Result};

/// The ground truth of a recording; lengths in m along the array's axes.
pub struct Truth {
    /// x, y, z and amplitude, `[scatterer, 4]`; those on the bone first.
    pub scatterers: Array2<f32>,
    /// Number of scatterers on the bone.
    pub on_bone: usize,
    /// The bone's outline in the image plane, `[segment, end, 2]`.
    ///
    /// Each end has x and z.
    pub outline: Array3<f64>,
    /// Level at every pixel, dB, if the phantom has known levels.
    ///
    /// With x and z of the first pixel and the distance between pixels, m.
    pub levels: Option<(Array2<f32>, [f64; 3])>,
}

impl Truth {
    /// Stages the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_to(&self, path: &Path, outputs: &mut Outputs) -> Result<()> {
        outputs.add(path, |sink| {
            let mut npz = npz_writer::Writer::new(sink, self.scatterers.len() * 4);
            npz.add("scatterers", &self.scatterers)?;
            npz.add("on_bone", &arr0(self.on_bone as i64))?;
            npz.add("outline", &self.outline)?;
            if let Some((levels, origin)) = &self.levels {
                npz.add("level_db", levels)?;
                npz.add("level_x0", &arr0(origin[0]))?;
                npz.add("level_z0", &arr0(origin[1]))?;
                npz.add("level_pixel", &arr0(origin[2]))?;
            }
            npz.finish()?;
            Ok(())
        })
    }
}

/// Stages a surface as a binary PLY file in mm, corners in m.
///
/// # Errors
/// The file cannot be written.
pub fn add_surface_to(
    path: &Path,
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
    outputs: &mut Outputs,
) -> Result<()> {
    outputs.add(path, |sink| Ok(write_ply(sink, vertices, triangles)?))
}

/// The bytes of the PLY file.
///
/// # Errors
/// It cannot be written.
pub fn ply(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_ply(&mut bytes, vertices, triangles)
        .map_err(|e| Error::Data(format!("the surface cannot be written: {e}")))?;
    Ok(bytes)
}

fn write_ply<W: Write>(
    sink: &mut W,
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
) -> io::Result<()> {
    write!(
        sink,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    )?;
    for vertex in vertices {
        let millimetres = vertex.map(|v| (1e3 * v) as f32);
        sink.write_all(millimetres.map(f32::to_le_bytes).as_flattened())?;
    }
    for triangle in triangles {
        sink.write_all(&[3])?;
        sink.write_all(triangle.map(u32::to_le_bytes).as_flattened())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_is_binary_ply_in_millimetres() {
        let bytes = ply(&[[1e-3, -2e-3, 0.5e-3], [0.0; 3]], &[[1, 0, 258]]).unwrap();
        let mut expected = b"ply\nformat binary_little_endian 1.0\nelement vertex 2\n\
            property float x\nproperty float y\nproperty float z\nelement face 1\n\
            property list uchar int vertex_indices\nend_header\n"
            .to_vec();
        expected.extend(
            [1.0f32, -2.0, 0.5, 0.0, 0.0, 0.0]
                .map(f32::to_le_bytes)
                .as_flattened(),
        );
        expected.extend([3, 1, 0, 0, 0, 0, 0, 0, 0, 2, 1, 0, 0]);
        assert_eq!(bytes, expected);
    }
}
