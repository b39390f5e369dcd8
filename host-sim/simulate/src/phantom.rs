//! Phantoms: point scatterers, and the bone that hides some of them.

use std::hash::Hasher;
use std::path::Path;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::{Error, Result};

use super::bone_surface::{BoneSurface, SurfaceDensity};
use super::layers::{Layers, layer};
use super::mesh::slice_mesh;
use super::outline::Outline;
use super::scatterer::{PointSource, Scatterer};
use super::settings::Settings;
use super::shadow::Shadow;
use super::surface::Surface;
use super::vertebra::slice_vertebra;

/// Distance between the scatterers along a bone's outline, m.
///
/// The paper has 200 per mm² of surface; times a slice thickness of 0.5 mm, its elevation step. At a thirtieth of
/// the wavelength the scatterers act as a smooth surface.
const BONE_SPACING: f64 = 10e-6;

/// Length of the facets of the bone's surface, m.
///
/// It is the pixel of the paper's CT, from which its surface was triangulated.
const FACET: f64 = 0.19e-3;

/// Standard deviation of the facets' corners from the smooth outline, m (assumed).
///
/// It is a twentieth of that pixel. A perfectly smooth outline would show as a few specular glints.
const ROUGHNESS: f64 = 10e-6;

/// Longest outline of a bone, m.
///
/// The scatterers on it need memory and time.
const LONGEST_OUTLINE: f64 = 5.0;

/// Soft tissue: scatterers at random positions, uniform over a rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tissue {
    /// Scatterers per m².
    ///
    /// The paper's 10⁶ in 30 × 6 × 25 mm³, times the slice thickness of 0.5 mm, make 111 per mm².
    pub density: f64,
    /// Reflected amplitude of each; that of a bone scatterer is 1.
    pub amplitude: f64,
    /// Layers that change the amplitude.
    pub layers: Layers,
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
            layers: Layers::Uniform,
            x: [-15e-3, 15e-3],
            z: [12e-3, 37e-3],
            seed: 1,
        }
    }
}

/// Scatterers, and the bone that hides some of them from some elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Phantom {
    /// The scatterers: first those on the bone.
    pub scatterers: Vec<Scatterer>,
    /// Number of scatterers on the bone.
    pub on_bone: usize,
    /// Points that must be visible for the scatterers on the bone.
    ///
    /// They lie on the smooth surface that casts shadows. Empty if the scatterers lie on it.
    pub seen_at: Vec<[f64; 3]>,
    /// The bone's outline in the image plane.
    ///
    /// It casts shadows unless `surface` does.
    pub bone: Option<Outline>,
    /// The bone's surface, if there is one; it casts shadows.
    pub surface: Option<Surface>,
    /// Scatterers that no bone hides: clutter that arrives on various paths.
    pub clutter: Vec<Scatterer>,
    /// Coherence length of the clutter's echoes over the aperture, m.
    ///
    /// Infinite for clutter that focuses perfectly.
    pub clutter_coherence: f64,
    /// Amplitude of the bone's reverberation, its image at twice its depth; 0 for none.
    ///
    /// The array reflects a part of the bone's echo, which echoes from the bone again.
    pub reverberation: f64,
}

impl Default for Phantom {
    fn default() -> Self {
        Phantom {
            scatterers: Vec::new(),
            on_bone: 0,
            seen_at: Vec::new(),
            bone: None,
            surface: None,
            clutter: Vec::new(),
            clutter_coherence: f64::INFINITY,
            reverberation: 0.0,
        }
    }
}

impl Phantom {
    /// The phantom without its clutter, and the clutter.
    ///
    /// `None` if the clutter is coherent over the whole aperture.
    pub(super) fn without_incoherent_clutter(&self) -> Option<[Phantom; 2]> {
        if self.clutter_coherence.is_infinite() || self.clutter.is_empty() {
            return None;
        }
        let mut rest = self.clone();
        let clutter = Phantom {
            clutter: std::mem::take(&mut rest.clutter),
            ..Phantom::default()
        };
        Some([rest, clutter])
    }

    /// One scatterer of amplitude 1 at the transmit focus (the paper's Fig. 2).
    ///
    /// It is `offset` m to the right of element `elements/2`, which is on a beam's axis if there is one beam per
    /// element.
    pub fn point(settings: &Settings, offset: f64) -> Self {
        let x = settings.array().x((settings.elements / 2) as f64) + offset;
        let point = Scatterer::new([x, 0.0, settings.focus], 1.0);
        Phantom {
            scatterers: vec![point],
            ..Phantom::default()
        }
    }

    /// A bone in a water bath.
    ///
    /// Its surface has facets of 0.19 mm with a roughness of 10 µm, and scatterers of amplitude 1 about 10 µm
    /// apart.
    ///
    /// # Errors
    /// An outline longer than that of any bone.
    pub fn bone(outline: &Outline) -> Result<Self> {
        check_length(outline)?;
        let surface = outline.faceted(FACET, ROUGHNESS, 1)?;
        let scatterers: Vec<Scatterer> = surface
            .equally_spaced(BONE_SPACING)
            .into_iter()
            .map(|[x, z]| Scatterer::new([x, 0.0, z], 1.0))
            .collect();
        Ok(Phantom {
            on_bone: scatterers.len(),
            scatterers,
            bone: Some(surface),
            ..Phantom::default()
        })
    }

    /// A bone in a water bath, with a scattering surface and the relief of a seed.
    ///
    /// Shadows are those of the smooth outline.
    ///
    /// # Errors
    /// An outline longer than that of any bone.
    pub fn rough_bone(outline: &Outline, surface: &BoneSurface, seed: u64) -> Result<Self> {
        check_length(outline)?;
        let smooth = outline.faceted(FACET, 0.0, 1)?;
        let points = smooth.points_with_normals(BONE_SPACING);
        let density = SurfaceDensity::Line(1.0 / BONE_SPACING);
        let (scatterers, seen_at) = surface.scatterers(&points, density, seed);
        Ok(Phantom {
            on_bone: scatterers.len(),
            scatterers,
            seen_at,
            bone: Some(smooth),
            ..Phantom::default()
        })
    }

    /// The bone of a mesh or the built-in vertebra.
    ///
    /// For meshes see [`slice_mesh`](super::slice_mesh). The bone is in a water bath, cut at height `slice` in m, with
    /// its shallowest point at `depth` in m. Its surface is given with a seed, or is that of [`Phantom::bone`].
    pub fn slice(
        mesh: Option<&Path>,
        slice: f64,
        depth: f64,
        surface: Option<(&BoneSurface, u64)>,
    ) -> Result<Self> {
        let outline = match mesh {
            None => slice_vertebra(slice)?,
            Some(path) => slice_mesh(path, slice)?,
        };
        let outline = outline.at_depth(depth)?;
        match surface {
            None => Phantom::bone(&outline),
            Some((surface, seed)) => Phantom::rough_bone(&outline, surface, seed),
        }
    }

    /// The built-in vertebra in a water bath.
    ///
    /// It is cut at height `slice` in m, with its shallowest point at `depth` in m.
    pub fn vertebra(slice: f64, depth: f64) -> Result<Self> {
        Phantom::bone(&slice_vertebra(slice)?.at_depth(depth)?)
    }

    /// The phantom, moved so that the elevation `y`, m, is in the image plane.
    ///
    /// Only scatterers within a slab of `thickness` around the plane are kept.
    ///
    /// # Errors
    /// A surface that is not closed there.
    pub(super) fn at_elevation(&self, y: f64, thickness: f64) -> Result<Self> {
        let near = |s: &Scatterer| (s.y - y).abs() <= 0.5 * thickness;
        let moved = |s: &Scatterer| Scatterer { y: s.y - y, ..*s };
        let kept = |all: &[Scatterer]| all.iter().filter(|s| near(s)).map(moved).collect();
        let seen_at = self.seen_at.iter().zip(&self.scatterers);
        let seen_at = seen_at.filter(|(_, s)| near(s));
        let surface = self.surface.clone().map(|all| all.moved([0.0, -y, 0.0]));
        let outline = surface.as_ref().map(Surface::outline).transpose();
        let on_bone = self.scatterers.iter().take(self.on_bone);
        Ok(Phantom {
            scatterers: kept(&self.scatterers),
            on_bone: on_bone.filter(|s| near(s)).count(),
            seen_at: seen_at.map(|([x, at, z], _)| [*x, at - y, *z]).collect(),
            bone: outline.map_err(Error::Data)?.flatten(),
            surface,
            clutter: kept(&self.clutter),
            ..*self
        })
    }

    /// Refuses scatterers that are not in front of the array.
    pub(super) fn check_in_front(&self) -> Result<()> {
        let scatterers = self.scatterers.iter().chain(&self.clutter);
        let numbers = |s: &Scatterer| [s.x, s.y, s.z, s.amplitude].iter().all(|v| v.is_finite());
        let in_front = |z: f64| z.is_finite() && z > 0.0;
        let outline = self.bone.iter().flat_map(|bone| bone.loops()).flatten();
        let mut surface = self.surface.iter().flat_map(Surface::vertices);
        if scatterers.into_iter().all(|s| numbers(s) && in_front(s.z))
            && outline.into_iter().all(|p| in_front(p[1]))
            && surface.all(|v| in_front(v[2]))
            && self.seen_at.iter().flatten().all(|v| v.is_finite())
            && self.reverberation.is_finite()
        {
            return Ok(());
        }
        Err(Error::Data(
            "the phantom must have finite positions at depths above 0".into(),
        ))
    }

    /// The shadow of the bone.
    pub(super) fn shadow(&self) -> Shadow {
        match (&self.surface, &self.bone) {
            (Some(surface), _) => Shadow::of_surface(surface),
            (None, Some(outline)) => Shadow::of_outline(outline),
            (None, None) => Shadow::None,
        }
    }

    /// All sources of echoes: scatterers, clutter, and reverberation of the bone.
    pub(super) fn sources(&self) -> Vec<PointSource> {
        let at = |s: &Scatterer| PointSource::at([s.x, s.y, s.z], s.amplitude);
        let seen = |(k, s): (usize, &Scatterer)| PointSource {
            seen_at: self.seen_at.get(k).copied().unwrap_or([s.x, s.y, s.z]),
            ..at(s)
        };
        let scatterers = self.scatterers.iter().enumerate().map(seen);
        let clutter = self.clutter.iter().map(|s| PointSource {
            unhidden: true,
            ..at(s)
        });
        let bone = match self.reverberation == 0.0 {
            true => 0,
            false => self.on_bone.min(self.scatterers.len()),
        };
        let image = self.scatterers[..bone].iter().enumerate();
        let image = image.map(|(k, s)| PointSource {
            z: 2.0 * s.z,
            amplitude: self.reverberation * s.amplitude,
            ..seen((k, s))
        });
        scatterers.chain(clutter).chain(image).collect()
    }

    /// Hashes what distinguishes bones.
    pub(super) fn hash_bone(&self, hasher: &mut impl Hasher) {
        let outline = self.bone.iter().flat_map(|bone| bone.loops()).flatten();
        let surface = self.surface.iter().flat_map(Surface::corners).flatten();
        for value in outline.flatten().copied().chain(surface.flatten()) {
            hasher.write_u64(value.to_bits());
        }
    }

    /// Refuses a phantom outside the record.
    ///
    /// Most likely a length is in millimetres instead of metres.
    ///
    /// # Errors
    /// No scatterer is below the array and within the record's depths.
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
                self.scatterers.push(Scatterer::new(
                    [x, 0.0, z],
                    tissue.amplitude * layer(tissue.layers, [1e3 * x, 0.0, 1e3 * z]),
                ));
            }
        }
        self
    }
}

/// Refuses an outline longer than that of any bone.
fn check_length(outline: &Outline) -> Result<()> {
    let length = outline.length();
    if length.is_nan() || length > LONGEST_OUTLINE {
        return Err(Error::Data(format!(
            "the bone's outline is {length:.1} m long; expected at most {LONGEST_OUTLINE} m, about \
             ten times a vertebra's"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_another_elevation_the_plane_cuts_the_bone_there() {
        let at = |y: f64| Scatterer::new([1e-3, y, 20e-3], 1.0);
        let phantom = Phantom {
            scatterers: vec![at(0.0), at(2.9e-3), at(3.5e-3), at(3.6e-3)],
            on_bone: 3,
            seen_at: vec![
                [1e-3, 0.1e-3, 20e-3],
                [1e-3, 2.8e-3, 20e-3],
                [1e-3, 3.4e-3, 20e-3],
            ],
            surface: Some(crate::ball([0.0, 0.0, 20e-3], 5e-3)),
            clutter: vec![at(0.0), at(3e-3)],
            ..Phantom::default()
        };
        let found = phantom.at_elevation(3e-3, 1e-3).unwrap();
        let elevations =
            |all: &[Scatterer]| -> Vec<f64> { all.iter().map(|s| (1e4 * s.y).round()).collect() };
        assert_eq!(elevations(&found.scatterers), [-1.0, 5.0]);
        assert_eq!(elevations(&found.clutter), [0.0]);
        assert_eq!((found.on_bone, found.seen_at.len()), (2, 2));
        assert!((found.seen_at[0][1] + 0.2e-3).abs() < 1e-12);
        // 3 mm beside its middle, a ball of 5 mm is a circle of 4 mm.
        let outline = found.bone.unwrap();
        for [x, z] in outline.loops().iter().flatten() {
            assert!((x.hypot(z - 20e-3) - 4e-3).abs() < 0.1e-3, "{x} {z}");
        }
        assert!(phantom.at_elevation(9e-3, 1e-3).unwrap().bone.is_none());
    }
}
