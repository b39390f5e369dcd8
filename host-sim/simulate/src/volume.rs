//! Phantoms of a volume: bone surfaces, layers of tissue, levels of brightness.
//!
//! A lumbar spine is copies of the built-in vertebra, one above the other. Tissue is point scatterers at random
//! positions with the amplitude of their layer. Lengths are in millimetres in this file.

use std::cell::Cell;
use std::path::Path;

use ndarray::Array2;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::{Error, Result};
use bonebeam_files::memory::{self, product};

use super::bone_surface::BoneSurface;
use super::layers::{Layers, layer};
use super::marching_tetrahedra::{self, VolumeGrid};
use super::mesh::read_mesh;
use super::phantom::Phantom;
use super::scatterer::Scatterer;
use super::surface::{StraightDown, Surface};
use super::vertebra::{self, VertebraShape};

/// Distance between vertebrae, mm: a lumbar vertebra with its disc.
const LEVEL: f64 = 34.0;
/// Gap of a facet joint, mm.
const JOINT: f64 = 1.6;
/// Lateral position of the laminae, mm from the middle.
const LAMINA: f64 = 11.0;
/// Distance of the surface's nodes, mm: about the paper's CT.
const STEP: f64 = 0.35;
/// Scatterers on bone, per m²: the paper's 200 per mm².
const ON_BONE: f64 = 200e6;
/// The paper's density of tissue, per m³: 10⁶ in 30 × 6 × 25 mm³.
pub const PAPER_DENSITY: f64 = 1e6 / (30e-3 * 6e-3 * 25e-3);

/// A bone, as the array sees it.
#[derive(Clone, Debug, PartialEq)]
pub enum Bone<'a> {
    /// One vertebra from behind, at the height `slice`, m.
    Vertebra {
        /// Mesh in place of the built-in vertebra.
        mesh: Option<&'a Path>,
        /// Height of the image plane, m.
        slice: f64,
    },
    /// One vertebra of another shape, tilted in the image plane.
    Shape {
        /// The shape.
        shape: &'a VertebraShape,
        /// Height of the image plane, m.
        slice: f64,
        /// Its tilt, degrees.
        tilt: f64,
    },
    /// The spine's spinous processes along it (the paper's Fig. 11).
    SpinousProcesses,
    /// The spine's laminae along it (Fig. 10).
    Laminae,
    /// Laminae and a facet joint across it (Fig. 12).
    FacetJoint,
}

/// Block of soft tissue, m, and its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Lateral range.
    pub x: [f64; 2],
    /// Thickness of the slab around the image plane.
    pub thickness: f64,
    /// Depth range.
    pub z: [f64; 2],
    /// Scatterers per m³.
    pub density: f64,
    /// Seed of the positions.
    pub seed: u64,
}

impl Bone<'_> {
    /// The surface, placed at a depth; with warnings.
    ///
    /// Its shallowest point below the array and in the slab is at `depth`, m. Warnings name values that are
    /// probably a mistake.
    ///
    /// # Errors
    /// A mesh that cannot be read or is not closed, or no bone below the array.
    pub fn surface(&self, depth: f64, thickness: f64) -> Result<(Surface, Vec<String>)> {
        let (surface, warnings) = match self {
            Bone::Vertebra {
                mesh: Some(path),
                slice,
            } => read_mesh(path, *slice)?,
            Bone::Vertebra { mesh: None, slice } => {
                let slice = 1e3 * slice;
                let one = |[x, y, z]: [f64; 3]| vertebra::distance([x, z, y + slice]);
                (cut(thickness, one), Vec::new())
            }
            Bone::Shape { shape, slice, tilt } => {
                let slice = 1e3 * slice;
                let (sin, cos) = libm::sincos(tilt.to_radians());
                let one = |[x, y, z]: [f64; 3]| {
                    shape.distance([cos * x + sin * z, cos * z - sin * x, y + slice])
                };
                (cut(thickness, one), Vec::new())
            }
            Bone::SpinousProcesses => {
                let spine = |[x, y, z]: [f64; 3]| spine([y, z, x]);
                (cut(thickness, spine), Vec::new())
            }
            Bone::Laminae => {
                let spine = |[x, y, z]: [f64; 3]| spine([y + LAMINA, z, x]);
                (cut(thickness, spine), Vec::new())
            }
            Bone::FacetJoint => {
                // Through the lower articular processes of one vertebra and the upper ones of the next.
                let spine = |[x, y, z]: [f64; 3]| spine([x, z, y - 13.0]);
                (cut(thickness, spine), Vec::new())
            }
        };
        let top = surface
            .top(20e-3, 0.5 * thickness)
            .ok_or_else(|| Error::Usage("no bone lies below the array in this slice".into()))?;
        Ok((surface.moved([0.0, 0.0, depth - top]), warnings))
    }

    /// Phantom of this bone in water.
    ///
    /// Scatterers are on its surface within the slab, with the amplitudes of `rough` and its seed, or of amplitude
    /// 1.
    ///
    /// # Errors
    /// As [`Bone::surface`].
    pub fn phantom(
        &self,
        depth: f64,
        thickness: f64,
        rough: Option<(&BoneSurface, u64)>,
    ) -> Result<(Phantom, Vec<String>)> {
        let (surface, warnings) = self.surface(depth, thickness)?;
        let [half, across] = [0.5 * thickness, 25e-3];
        let near = |[x, y, _]: [f64; 3]| x.abs() <= across && y.abs() <= half;
        let mut phantom = Phantom {
            bone: surface.outline().map_err(Error::Data)?,
            ..Phantom::default()
        };
        match rough {
            None => phantom.scatterers = surface.scatterers(ON_BONE, near)?,
            Some((rough, seed)) => {
                (phantom.scatterers, phantom.seen_at) =
                    rough.cover(&surface, ON_BONE, near, seed)?;
            }
        }
        phantom.on_bone = phantom.scatterers.len();
        phantom.surface = Some(surface);
        Ok((phantom, warnings))
    }
}

/// The surface of a bone near the array, closed at the sides of a box around it.
fn cut(thickness: f64, distance: impl Fn([f64; 3]) -> f64 + Sync) -> Surface {
    let half = [30.0, 0.5e3 * thickness + 2.0, 30.0];
    let centre = [0.0, 0.0, 25.0];
    let bone = |p: [f64; 3]| {
        let beyond = (0..3).map(|k| (p[k] - centre[k]).abs() - half[k]);
        beyond.fold(distance(p), f64::max)
    };
    let nodes = half.map(|h| (2.0 * h / STEP).ceil() as usize + 5);
    let grid = VolumeGrid {
        corner: [0, 1, 2].map(|k| 1e-3 * (centre[k] - half[k] - 2.0 * STEP)),
        step: [1e-3 * STEP; 3],
        nodes,
    };
    marching_tetrahedra::isosurface(&grid, |p| bone(p.map(|v| 1e3 * v)))
}

/// Signed distance to the lumbar spine, mm.
///
/// It has three vertebrae, with a gap where they would touch. Anatomical axes are as in `vertebra`.
fn spine([x, y, z]: [f64; 3]) -> f64 {
    let one = |level: f64| vertebra::distance([x, y, z - level * LEVEL]);
    let (below, middle, above) = (one(-1.0), one(0.0), one(1.0));
    // Each vertebra keeps off the one above it.
    let middle = middle.max(JOINT - above);
    let below = below.max(JOINT - middle);
    below.min(middle).min(above)
}

impl Block {
    /// Adds soft tissue outside the bone.
    ///
    /// Calls `tick` now and then, which may unwind.
    ///
    /// # Errors
    /// More scatterers than the memory can hold.
    pub fn fill(&self, phantom: &mut Phantom, layers: Layers, tick: &dyn Fn()) -> Result<()> {
        let bone = phantom.surface.as_ref().map(StraightDown::new);
        let positions = Cell::new(0_u32);
        self.scatter(&mut phantom.scatterers, |p| {
            positions.set(positions.get().wrapping_add(1));
            if positions.get().is_multiple_of(4096) {
                tick();
            }
            let outside = bone.as_ref().is_none_or(|bone| !bone.holds(p));
            outside.then(|| layer(layers, p.map(|v| 1e3 * v)))
        })
    }

    /// Adds scatterers at random positions of the block.
    ///
    /// Only at positions that have an amplitude.
    ///
    /// # Errors
    /// More scatterers than the memory can hold.
    pub(super) fn scatter(
        &self,
        scatterers: &mut Vec<Scatterer>,
        amplitude: impl Fn([f64; 3]) -> Option<f64>,
    ) -> Result<()> {
        let half = 0.5 * self.thickness;
        let ranges = [self.x, [-half, half], self.z];
        let volume: f64 = ranges.iter().map(|[low, high]| high - low).product();
        let count = (self.density * volume).round();
        if !(0.0..=1e9).contains(&count) {
            return Err(Error::Usage(format!(
                "{count:.0} scatterers of tissue were requested; expected at most 1e9"
            )));
        }
        // A scatterer, and what the sum makes of it.
        memory::check(product(&[count as usize, 160]), "the tissue")?;
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        for _ in 0..count as usize {
            let p = ranges.map(|[low, high]| low + (high - low) * random.random::<f64>());
            if let Some(amplitude) = amplitude(p) {
                scatterers.push(Scatterer::new([p[0], p[1], p[2]], amplitude));
            }
        }
        Ok(())
    }
}

/// Phantom of known levels, for true contrast.
///
/// A row of points at 8 mm, 10 dB apart from 0 to −50. Speckle from 12 mm on: at the left an axial gradient, in the
/// middle and at the right cysts of −∞, −20, −10 and +10 dB in speckle of −20 dB, below 38 mm a lateral gradient;
/// gradients fall by 50 dB. 0 dB is the brightest speckle.
pub struct DynamicRange;

/// Lateral positions of the points, mm, from 0 dB on.
const POINTS: [f64; 6] = [-15.0, -9.0, -3.0, 3.0, 9.0, 15.0];
/// Centres of the cysts, mm, and their levels, dB; radius 3 mm.
const CYSTS: [([f64; 2], f64); 4] = [
    ([-3.0, 19.0], f64::NEG_INFINITY),
    ([8.0, 19.0], -40.0),
    ([-3.0, 30.0], -30.0),
    ([8.0, 30.0], -10.0),
];
/// Ratio of a point's amplitude to that of a scatterer of speckle at 0 dB.
///
/// The point is about as bright as the sum of scatterers in a resolution cell.
const POINT: f64 = 30.0;

impl DynamicRange {
    /// Level at a position in the image plane, m, in dB; −∞ for no scatterers.
    pub fn level(x: f64, z: f64) -> f64 {
        let (x, z) = (1e3 * x, 1e3 * z);
        if x.abs() > 18.0 || !(12.0..=45.0).contains(&z) {
            return f64::NEG_INFINITY;
        }
        if z >= 38.0 {
            return -50.0 * (x + 18.0) / 36.0;
        }
        if x < -10.0 {
            return -50.0 * (z - 12.0) / 26.0;
        }
        let within = |[cx, cz]: [f64; 2]| (x - cx) * (x - cx) + (z - cz) * (z - cz) < 9.0;
        let cyst = CYSTS.iter().find(|(centre, _)| within(*centre));
        cyst.map_or(-20.0, |(_, level)| *level)
    }

    /// The phantom.
    ///
    /// # Errors
    /// As [`Block::fill`].
    pub fn phantom(block: &Block) -> Result<Phantom> {
        let mut phantom = Phantom::default();
        let mut add = |x: f64, z: f64, level: f64| {
            let amplitude = POINT * libm::pow(10.0, level / 20.0);
            phantom
                .scatterers
                .push(Scatterer::new([1e-3 * x, 0.0, 1e-3 * z], amplitude));
        };
        for (k, x) in POINTS.into_iter().enumerate() {
            add(x, 8.0, -10.0 * k as f64);
        }
        block.scatter(&mut phantom.scatterers, |[x, _, z]| {
            let level = Self::level(x, z);
            level.is_finite().then(|| libm::pow(10.0, level / 20.0))
        })?;
        Ok(phantom)
    }

    /// Level at pixels of 0.1 mm from (−18, 5) to (18, 46) mm: `[row, column]`, dB.
    pub fn levels() -> Array2<f32> {
        Array2::from_shape_fn((411, 361), |(row, column)| {
            Self::level(-18e-3 + 1e-4 * column as f64, 5e-3 + 1e-4 * row as f64) as f32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::outline::Outline;
    use super::*;

    #[test]
    fn a_turned_shape_has_the_outline_of_its_turned_slice() {
        let shape = VertebraShape::drawn(3);
        let (slice, tilt) = (-4e-3, 12.0);
        let bone = Bone::Shape {
            shape: &shape,
            slice,
            tilt,
        };
        let (surface, _) = bone.surface(15e-3, 4e-3).unwrap();
        let found = surface.outline().unwrap().unwrap();
        let (sin, cos) = libm::sincos(f64::to_radians(tilt));
        let turn = |[x, z]: [f64; 2]| [cos * x - sin * z, sin * x + cos * z];
        let expected = shape.slice(slice).unwrap();
        let loops = expected.loops().iter();
        let turned = loops.map(|points| points.iter().copied().map(turn).collect());
        let turned = Outline::new(turned.collect()).unwrap();
        // The shallowest point is at 15 mm in the slab of 4 mm, of which the slice is a part.
        let top = |outline: &Outline| {
            let points = outline.loops().iter().flatten();
            points.map(|p| p[1]).fold(f64::INFINITY, f64::min)
        };
        let down = top(&found) - top(&turned);
        assert!((top(&found) - 15e-3).abs() < 1e-3, "{}", top(&found));
        let mut near = 0;
        for [x, z] in found.loops().iter().flatten() {
            // Nodes are 0.35 mm apart; the box around the bone ends 55 mm deep and 30 mm beside the middle.
            if x.abs() < 25e-3 && *z - down < 40e-3 {
                let off = turned.signed_distance(*x, *z - down);
                assert!(off.abs() < 0.1e-3, "{x} {z} {off}");
                near += 1;
            }
        }
        assert!(near > 200, "{near}");
    }
}
