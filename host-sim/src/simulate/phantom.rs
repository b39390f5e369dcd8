//! What is imaged: point scatterers, and the bone that hides some of them.

use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{Error, Result};

use super::mesh::slice_mesh;
use super::outline::Outline;
use super::settings::Settings;
use super::vertebra::slice_vertebra;

/// Distance between the scatterers along a bone's outline, m: the paper's 200 per mm² of surface
/// times a slice thickness of 0.5 mm, its elevation step. At a thirtieth of the wavelength the
/// scatterers act as a smooth surface.
const BONE_SPACING: f64 = 10e-6;

/// Length of the facets of the bone's surface, m: the pixel of the paper's CT, from which its
/// surface was triangulated.
const FACET: f64 = 0.19e-3;

/// Standard deviation of the facets' corners from the smooth outline, m (assumed): a twentieth of
/// that pixel. A perfectly smooth outline would show as a few specular glints.
const ROUGHNESS: f64 = 10e-6;

/// The longest outline of a bone, m: the scatterers on it take memory and time.
const LONGEST_OUTLINE: f64 = 5.0;

/// A point scatterer in the image plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer {
    /// Lateral position, m.
    pub x: f64,
    /// Depth, m.
    pub z: f64,
    /// Reflected amplitude.
    pub amplitude: f64,
}

/// Soft tissue: scatterers at random positions, uniform over a rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tissue {
    /// Scatterers per m². The paper's 10⁶ in 30 × 6 × 25 mm³, times the slice thickness of
    /// 0.5 mm, make 111 per mm².
    pub density: f64,
    /// Reflected amplitude of each; that of a bone scatterer is 1.
    pub amplitude: f64,
    /// Lateral range, m.
    pub x: [f64; 2],
    /// Depth range, m.
    pub z: [f64; 2],
    /// Seed of the positions.
    pub seed: u64,
}

impl Default for Tissue {
    fn default() -> Self {
        Tissue {
            density: 1e6 / (30e-3 * 6e-3 * 25e-3) * 0.5e-3,
            amplitude: 1.0,
            x: [-15e-3, 15e-3],
            z: [12e-3, 37e-3],
            seed: 1,
        }
    }
}

/// Scatterers, and the outline of the bone that hides some of them from some elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Phantom {
    /// The scatterers.
    pub scatterers: Vec<Scatterer>,
    /// The bone.
    pub bone: Option<Outline>,
}

impl Phantom {
    /// One scatterer of amplitude 1 at the transmit focus (the paper's Fig. 2), `offset` in m to
    /// the right of element `elements/2`, which with one beam per element is a beam's axis.
    pub fn point(settings: &Settings, offset: f64) -> Self {
        let x = settings.array().x((settings.elements / 2) as f64) + offset;
        let point = Scatterer {
            x,
            z: settings.focus,
            amplitude: 1.0,
        };
        Phantom {
            scatterers: vec![point],
            bone: None,
        }
    }

    /// A bone in a water bath: its surface in facets of 0.19 mm with a roughness of 10 µm, and
    /// on them scatterers of amplitude 1, equally spaced by about 10 µm.
    ///
    /// # Errors
    /// An outline longer than any bone's.
    pub fn bone(outline: &Outline) -> Result<Self> {
        let length = outline.length();
        if length.is_nan() || length > LONGEST_OUTLINE {
            return Err(Error::Data(format!(
                "the bone's outline is {length:.1} m long; expected at most {LONGEST_OUTLINE} m, about \
                 ten times a vertebra's"
            )));
        }
        let surface = outline.faceted(FACET, ROUGHNESS, 1)?;
        let scatterers = surface
            .equally_spaced(BONE_SPACING)
            .into_iter()
            .map(|[x, z]| Scatterer {
                x,
                z,
                amplitude: 1.0,
            })
            .collect();
        Ok(Phantom {
            scatterers,
            bone: Some(surface),
        })
    }

    /// The bone of a mesh (see [`slice_mesh`](super::slice_mesh)), or without one the built-in
    /// vertebra, cut at height `slice` in m, its shallowest point at `depth` in m, in a water bath.
    pub fn slice(mesh: Option<&Path>, slice: f64, depth: f64) -> Result<Self> {
        match mesh {
            None => Phantom::vertebra(slice, depth),
            Some(path) => Phantom::bone(&slice_mesh(path, slice)?.at_depth(depth)?),
        }
    }

    /// The built-in vertebra cut at height `slice` in m, its shallowest point at `depth` in m, in
    /// a water bath.
    pub fn vertebra(slice: f64, depth: f64) -> Result<Self> {
        Phantom::bone(&slice_vertebra(slice)?.at_depth(depth)?)
    }

    /// Refuses a phantom of which nothing can be seen: a length in millimetres where metres are
    /// expected, most likely.
    ///
    /// # Errors
    /// No scatterer lies below the array, within the record's depths.
    pub fn check_within(&self, settings: &Settings) -> Result<()> {
        let array = settings.array();
        let width = array.x(0.0)..=array.x((settings.elements - 1) as f64);
        let depths = settings.depth_start..=settings.depth_end;
        let seen = |s: &Scatterer| width.contains(&s.x) && depths.contains(&s.z);
        if self.scatterers.iter().any(seen) {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "nothing of the phantom lies below the array, {} to {} m across and {} to {} m deep",
            width.start(),
            width.end(),
            depths.start(),
            depths.end()
        )))
    }

    /// The phantom with soft tissue around the bone.
    pub fn with_tissue(mut self, tissue: &Tissue) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(tissue.seed);
        let [width, height] = [tissue.x[1] - tissue.x[0], tissue.z[1] - tissue.z[0]];
        let count = (tissue.density * width * height).round() as usize;
        for _ in 0..count {
            let x = tissue.x[0] + width * random.random::<f64>();
            let z = tissue.z[0] + height * random.random::<f64>();
            if self
                .bone
                .as_ref()
                .is_none_or(|bone| bone.signed_distance(x, z) < 0.0)
            {
                self.scatterers.push(Scatterer {
                    x,
                    z,
                    amplitude: tissue.amplitude,
                });
            }
        }
        self
    }
}
