//! The two bones: the built-in vertebra and a mesh, in the pose of a seed.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::Result;
use crate::experiments::outcome::Attachment;
use bonebeam_files::ply;
use bonebeam_simulate::{Bone, Outline, slice_mesh, slice_ply, slice_vertebra};

use super::parameters::{Claims, GEOMETRIES};

/// How far a seed moves the bone laterally and in depth at the most, m.
const SHIFT: f64 = 1e-3;

/// The bones, at x = 0 and any depth.
pub struct Geometries {
    outlines: [Outline; 2],
    mesh: Option<Vec<u8>>,
}

impl Geometries {
    /// The built-in vertebra's slice, and that of the mesh. Without one a mesh is made: the built-in vertebra
    /// at another height, wider and turned in the image plane.
    pub fn new(claims: &Claims) -> Result<Self> {
        let built_in = slice_vertebra(claims.slice)?;
        let (mesh, bytes) = match &claims.mesh {
            Some(path) => (slice_mesh(path, claims.mesh_slice)?, None),
            None => {
                let bytes = mesh()?;
                (slice_ply(&bytes, claims.mesh_slice)?, Some(bytes))
            }
        };
        Ok(Geometries {
            outlines: [built_in, mesh],
            mesh: bytes,
        })
    }

    /// The mesh, where it was made here.
    pub fn attachment(self) -> Option<Attachment> {
        self.mesh.map(|bytes| Attachment {
            file: "claims-mesh.ply".into(),
            description: "the second geometry, mm".into(),
            bytes,
        })
    }

    /// A bone in the pose of a seed.
    pub fn posed(&self, claims: &Claims, geometry: &str, seed: u64) -> Result<Outline> {
        let index = usize::from(geometry != GEOMETRIES[0]);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(1 + index as u64);
        let mut shift = || SHIFT * (2.0 * random.random::<f64>() - 1.0);
        let (across, down) = (shift(), shift());
        let placed = self.outlines[index].at_depth(claims.depth + down)?;
        let loops = placed.loops().iter();
        let moved = loops.map(|points| points.iter().map(|p| [p[0] + across, p[1]]).collect());
        Outline::new(moved.collect())
    }
}

/// The built-in vertebra's surface 4 mm lower, 8 % wider and turned by 7° in the image plane, as a
/// mesh in a PLY file.
fn mesh() -> Result<Vec<u8>> {
    let bone = Bone::Vertebra {
        mesh: None,
        slice: -8e-3,
    };
    let (surface, _) = bone.surface(15e-3, 4e-3)?;
    let (sin, cos) = libm::sincos(7f64.to_radians());
    // A mesh has +x towards the front, +y across, +z towards the head.
    let vertices: Vec<[f64; 3]> = surface
        .vertices()
        .iter()
        .map(|[x, y, z]| {
            let (x, z) = (1.08 * x, z - 25e-3);
            [sin * x + cos * z, cos * x - sin * z, *y]
        })
        .collect();
    ply(&vertices, surface.triangles())
}
