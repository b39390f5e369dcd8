//! The population: bones of different shape, slice, tilt, depth and roughness.

use crate::experiments::study::*;
use bonebeam_simulate::{VertebraShape, slice_mesh};

use super::parameters::Claims;

/// Steps of the low-discrepancy sequence: 1/p to 1/p⁴ of the root p of p⁵ = p + 1.
///
/// Slices, tilts, depths and tissue levels fill their ranges by it.
const STEPS: [f64; 4] = [
    0.856_674_883_854_502_9,
    0.733_891_856_627_126,
    0.628_706_721_037_808_6,
    0.538_597_257_223_61,
];

/// A bone of the population.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bone {
    /// Number: the seed of its shape, roughness, tissue, clutter and noise.
    pub number: u64,
    /// Its shape; `None` for a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<VertebraShape>,
    /// Height of the slice through it, m.
    pub slice: f64,
    /// Its tilt in the image plane, degrees.
    pub tilt: f64,
    /// Depth of its shallowest point, m.
    pub depth: f64,
    /// Amplitude of the tissue's scatterers, dB relative to the bone's.
    pub tissue_level: f64,
    #[serde(skip)]
    pub outline: Outline,
}

impl Bone {
    /// Makes the bone of a number.
    ///
    /// # Errors
    /// A mesh that cannot be read, or a slice that does not cut the bone.
    pub fn new(claims: &Claims, number: u64) -> Result<Self> {
        let within = |[low, high]: [f64; 2], step: f64| {
            let position = 0.5 + (number % (1 << 32)) as f64 * step;
            low + (high - low) * (position - position.floor())
        };
        let slice = within(claims.slices, STEPS[0]);
        let tilt = claims.tilt * within([-1.0, 1.0], STEPS[1]);
        let depth = within(claims.depths, STEPS[2]);
        let tissue_level = within(claims.tissue_levels, STEPS[3]);
        let shape = VertebraShape::drawn(number);
        let (shape, slice, outline) = match &claims.mesh {
            Some(path) => (
                None,
                claims.mesh_slice,
                slice_mesh(path, claims.mesh_slice)?,
            ),
            None => (Some(shape), slice, shape.slice(slice)?),
        };
        Ok(Bone {
            number,
            shape,
            slice,
            tilt,
            depth,
            tissue_level,
            outline: turned(&outline, tilt)?.at_depth(depth)?,
        })
    }
}

/// Rotates an outline about its shallowest point by `angle` degrees.
///
/// That point moves to x = 0.
fn turned(outline: &Outline, angle: f64) -> Result<Outline> {
    let points = || outline.loops().iter().flatten();
    let near = points().filter(|p| p[0].abs() < 10e-3);
    let Some(top) = near.min_by(|a, b| a[1].total_cmp(&b[1])).copied() else {
        return Ok(outline.clone());
    };
    let (sin, cos) = libm::sincos(angle.to_radians());
    let turn = |p: &[f64; 2]| {
        let [x, z] = [p[0] - top[0], p[1] - top[1]];
        [cos * x - sin * z, sin * x + cos * z]
    };
    let loops = outline.loops().iter();
    Outline::new(
        loops
            .map(|points| points.iter().map(turn).collect())
            .collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bones_fill_their_ranges() {
        let claims = Claims::default();
        let position = |k: u64| {
            let within = |step: f64| (0.5 + k as f64 * step).fract();
            STEPS.map(within)
        };
        // Of twelve in a row each third of a range has some.
        for axis in 0..STEPS.len() {
            for third in 0..3 {
                let inside = (1..=12).filter(|&k| (3.0 * position(k)[axis]) as usize == third);
                assert!(inside.count() >= 2, "{axis} {third}");
            }
        }
        let bone = Bone::new(&claims, 5).unwrap();
        assert!((10e-3..=30e-3).contains(&bone.depth) && bone.tilt.abs() <= 15.0);
        let points = bone.outline.loops().iter().flatten();
        let top = points.map(|p| p[1]).fold(f64::INFINITY, f64::min);
        assert!((top - bone.depth).abs() < 1e-9);
    }

    #[test]
    fn a_turned_outline_keeps_its_length() {
        let outline = VertebraShape::default().slice(-4e-3).unwrap();
        let found = turned(&outline, 12.0).unwrap();
        assert!((found.length() / outline.length() - 1.0).abs() < 1e-9);
    }
}
