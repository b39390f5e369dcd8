//! The built-in lumbar vertebra: a signed-distance function and its slices.
//!
//! Body, pedicles, laminae, spinous, transverse and articular processes are simple solids joined by a smooth
//! minimum; the vertebral canal is subtracted. Sizes follow common anatomical data for L3. Other vertebrae differ
//! by a [`VertebraShape`]. Lengths are in millimetres in this file: x to the right, y from the spinous process's
//! tip towards the front, z towards the head.

use libm::pow;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::Serialize;

use crate::{Error, Result};

use super::chain::closed_loops;
use super::marching_squares::{PlaneGrid, contour};
use super::outline::Outline;
use super::vector::{V3, dot, norm, sub};

/// Radius of the fillets between the parts, mm.
const FILLET: f64 = 3.0;
/// Beginning of the spinous process, mm.
const BASE: f64 = 16.0;

/// Outline at height `slice` in m, as seen from behind.
///
/// x is to the right, z grows towards the front, and the spinous process's tip is near z = 0. Slices from −20 to 16
/// mm cut the posterior parts.
pub fn slice_vertebra(slice: f64) -> Result<Outline> {
    VertebraShape::default().slice(slice)
}

/// Shape of a vertebra relative to the built-in one; lengths are factors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct VertebraShape {
    /// Size of the whole.
    pub scale: f64,
    /// Width.
    pub width: f64,
    /// Length of the spinous process, from its base to its tip.
    pub spinous_length: f64,
    /// Thickness of the spinous process.
    pub spinous_thickness: f64,
    /// Distance of its tip to the right of the middle, mm.
    pub spinous_deviation: f64,
    /// Fall of a lamina towards the front over 12.5 mm outwards, mm.
    ///
    /// It is 4 for the built-in one.
    pub lamina_fall: f64,
    /// Size of the articular processes.
    pub facets: f64,
    /// Excess width of the right side over the left.
    pub asymmetry: f64,
}

impl Default for VertebraShape {
    fn default() -> Self {
        VertebraShape {
            scale: 1.0,
            width: 1.0,
            spinous_length: 1.0,
            spinous_thickness: 1.0,
            spinous_deviation: 0.0,
            lamina_fall: 4.0,
            facets: 1.0,
            asymmetry: 0.0,
        }
    }
}

impl VertebraShape {
    /// A shape of a population, by its seed.
    ///
    /// The ranges are approximately those of adults' lumbar vertebrae.
    pub fn drawn(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut within = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        VertebraShape {
            scale: within(0.85, 1.1),
            width: within(0.9, 1.1),
            spinous_length: within(0.8, 1.2),
            spinous_thickness: within(0.8, 1.25),
            spinous_deviation: within(-2.0, 2.0),
            lamina_fall: within(1.5, 6.5),
            facets: within(0.8, 1.2),
            asymmetry: within(-0.12, 0.12),
        }
    }

    /// As [`slice_vertebra`], of this shape.
    ///
    /// # Errors
    /// A slice that does not cut the vertebra.
    pub fn slice(&self, slice: f64) -> Result<Outline> {
        let grid = PlaneGrid {
            corner: [-55e-3, -5e-3],
            step: 0.1e-3,
            nodes: [1101, 901],
        };
        let segments = contour(&grid, |[x, z]| {
            self.distance([1e3 * x, 1e3 * z, 1e3 * slice])
        });
        let loops = closed_loops(&segments)
            .filter(|loops| !loops.is_empty())
            .ok_or_else(|| {
                Error::Usage(format!(
                    "slice at {} mm does not cut the vertebra",
                    1e3 * slice
                ))
            })?;
        Outline::new(loops)
    }

    /// Signed distance to its surface, mm, negative inside.
    ///
    /// It is exact only on the surface of the built-in one.
    pub(super) fn distance(&self, p: V3) -> f64 {
        let p = p.map(|v| v / self.scale);
        let side = if p[0] < 0.0 { -1.0 } else { 1.0 };
        let across = p[0] / (self.width * (1.0 + side * self.asymmetry));
        // The spinous process leans to a side the more the nearer its tip.
        let lean = self.spinous_deviation * ((BASE - p[1]) / BASE).max(0.0);
        let spinous = [
            (across - lean) / self.spinous_thickness,
            p[1] + (BASE - p[1]) * (1.0 - 1.0 / self.spinous_length),
            p[2],
        ];
        // One side is described.
        let p = [across.abs(), p[1], p[2]];
        let mut bone = body(p);
        for part in [
            pedicle(p),
            lamina(p, self.lamina_fall),
            spinous_process(spinous),
            transverse_process(p),
            articular_processes(p, self.facets),
        ] {
            bone = smooth_min(bone, part, FILLET);
        }
        -smooth_min(-bone, canal(p), 1.5)
    }
}

/// Signed distance to the built-in vertebra's surface, mm, negative inside.
///
/// It is exact only on the surface.
pub(super) fn distance(p: V3) -> f64 {
    VertebraShape::default().distance(p)
}

/// A superellipsoid with flat end plates, drawn in at the waist and at the back.
fn body([x, y, z]: V3) -> f64 {
    let waist = 1.0 - 0.10 * (1.0 - (z / 14.0) * (z / 14.0)).max(0.0);
    let hollow = 2.5 * libm::exp(-(x / 9.0) * (x / 9.0));
    let y = y - 49.5;
    let y = if y < 0.0 {
        y * 17.0 / (17.0 - hollow)
    } else {
        y
    };
    let q = [x / (23.0 * waist), y / (17.0 * waist), z / 14.0];
    let across = pow(pow(q[0].abs(), 2.3) + pow(q[1].abs(), 2.3), 1.0 / 2.3);
    let sixth = |v: f64| v * v * v * v * v * v;
    let level = pow(sixth(across) + sixth(q[2]), 1.0 / 6.0);
    (level - 1.0) * 14.0
}

fn pedicle(p: V3) -> f64 {
    capsule(
        [p[0], p[1], 0.75 * (p[2] - 5.0)],
        [13.5, 20.0, 0.0],
        [14.5, 38.0, 0.0],
        4.2,
        4.6,
    )
}

/// A slab from the spinous process's base outwards, its lower edge further back.
fn lamina(p: V3, fall: f64) -> f64 {
    let y = p[1] + 0.22 * (p[2] + 2.0);
    let (dx, dy) = (12.5f64, fall);
    let length = (dx * dx + dy * dy).sqrt();
    let (u, v) = (
        (p[0] * dx + (y - 12.5) * dy) / length,
        ((y - 12.5) * dx - p[0] * dy) / length,
    );
    rounded_box([u - 5.0, v, p[2] + 3.0], [9.0, 3.2, 10.0], 2.2)
}

/// A plate that becomes thinner from its base and ends in a thicker tip.
///
/// It slopes towards the feet.
fn spinous_process(p: V3) -> f64 {
    let z = p[2] + 6.0 - 0.12 * (p[1] - 6.0);
    let half = 2.2 + 0.06 * (p[1] - 4.0).max(0.0);
    let plate = rounded_box([p[0], p[1] - 9.0, z], [half, 7.0, 8.5], 1.6);
    let tip = capsule([p[0], p[1], z], [0.0, 3.6, -7.0], [0.0, 3.2, 5.0], 3.8, 3.0);
    smooth_min(plate, tip, 2.0)
}

fn transverse_process(p: V3) -> f64 {
    let slim = [p[0], p[1], 0.7 * p[2]];
    capsule(slim, [15.0, 23.0, 3.5], [42.0, 18.5, 5.5], 4.0, 2.6)
}

/// Lower pair beside the laminae, upper pair further out.
///
/// The upper pair has a mammillary process.
fn articular_processes([x, y, z]: V3, size: f64) -> f64 {
    let sized = |axes: V3| axes.map(|v| size * v);
    let lower = ellipsoid([x - 11.5, y - 14.0, z + 11.0], sized([5.0, 5.4, 11.0]));
    let upper = ellipsoid([x - 17.5, y - 16.0, z - 9.0], sized([4.6, 6.8, 9.5]));
    smooth_min(lower, upper, 2.0)
}

/// A triangle with rounded corners, positive outside.
///
/// Its apex is towards the spinous process.
fn canal([x, y, _]: V3) -> f64 {
    let v = (y - 25.0) / 8.0;
    let half = 11.5 * (1.0 + 0.25 * v);
    let q = pow((x / half).abs(), 2.2) + pow(v.abs(), 2.2);
    (pow(q, 1.0 / 2.2) - 1.0) * 8.0
}

fn smooth_min(a: f64, b: f64, k: f64) -> f64 {
    let h = (1.0 - (a - b).abs() / k).max(0.0);
    a.min(b) - 0.25 * k * h * h
}

/// A capsule from `a` to `b` with radii `ra` and `rb` at its ends.
fn capsule(p: V3, a: V3, b: V3, ra: f64, rb: f64) -> f64 {
    let axis = sub(b, a);
    let along = (dot(sub(p, a), axis) / dot(axis, axis)).clamp(0.0, 1.0);
    let nearest: V3 = std::array::from_fn(|k| a[k] + along * axis[k]);
    norm(sub(p, nearest)) - (ra + along * (rb - ra))
}

/// A box with half sizes `half` and edges of radius `r`.
fn rounded_box(p: V3, half: V3, r: f64) -> f64 {
    let q: V3 = std::array::from_fn(|k| p[k].abs() - half[k] + r);
    let outside = norm(q.map(|v| v.max(0.0)));
    outside + q[0].max(q[1]).max(q[2]).min(0.0) - r
}

fn ellipsoid(p: V3, axes: V3) -> f64 {
    let k0 = norm(std::array::from_fn(|k| p[k] / axes[k]));
    let k1 = norm(std::array::from_fn(|k| p[k] / (axes[k] * axes[k])));
    if k1 == 0.0 {
        -axes[0].min(axes[1]).min(axes[2])
    } else {
        k0 * (k0 - 1.0) / k1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirrored_shape_is_the_shape_from_the_other_side() {
        let shape = VertebraShape::drawn(3);
        let mirrored = VertebraShape {
            spinous_deviation: -shape.spinous_deviation,
            asymmetry: -shape.asymmetry,
            ..shape
        };
        for p in [[3.0, 1.0, -4.0], [-11.0, 14.0, 2.0], [0.5, 6.0, 0.0]] {
            let q = [-p[0], p[1], p[2]];
            assert_eq!(shape.distance(p), mirrored.distance(q));
        }
    }

    #[test]
    fn a_longer_spinous_process_ends_further_back() {
        // The tip: least depth of the outline near the middle, m; the base stays at 16 mm.
        let tip = |spinous_length: f64| {
            let shape = VertebraShape {
                spinous_length,
                ..VertebraShape::default()
            };
            shape.slice(-4e-3).unwrap().first_hit(0.0).unwrap()
        };
        let built_in = BASE * 1e-3 - tip(1.0);
        for length in [0.8, 1.2] {
            let found = BASE * 1e-3 - tip(length);
            assert!(
                (found / built_in - length).abs() < 0.03,
                "{length}: {found}"
            );
        }
    }

    #[test]
    fn drawn_shapes_differ_and_are_cut() {
        let mut lengths = Vec::new();
        for seed in 1..=4 {
            let outline = VertebraShape::drawn(seed).slice(-8e-3).unwrap();
            lengths.push(1e9 * outline.length());
        }
        lengths.sort_by(f64::total_cmp);
        assert!(lengths.windows(2).all(|pair| pair[1] - pair[0] > 1.0));
    }
}
