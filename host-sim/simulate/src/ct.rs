//! A CT scan of closed surfaces in air, and surfaces from the scan.
//!
//! A voxel holds the mean over its own volume, blurred by the scanner's Gaussian point spread. There is no noise
//! and no beam hardening, and each part has one density, so the only error is that of a threshold on a blurred
//! edge. For a step from air to bone blurred by σ, the level at a share s of the step lies σ·Φ⁻¹(1 − s) outside the
//! edge.

use rayon::prelude::*;

use crate::{Error, Result};
use bonebeam_files::memory::{self, product};

use super::marching_tetrahedra::{VolumeGrid, isosurface_of_values};
use super::surface::{Surface, crossing};

/// Lines through a voxel, along each side.
///
/// The inside is exact along them. Across them, a face parallel to the voxels is known to a tenth of a voxel.
const LINES: usize = 5;
/// Length of a Gaussian to either side, standard deviations.
const REACH: f64 = 4.0;

/// A scanner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CtScanner {
    /// Distance between voxels along each axis, m.
    pub voxel: [f64; 3],
    /// Full width at half maximum of the point spread, m, the same along all axes.
    pub blur: f64,
    /// Density around the specimen, HU.
    pub air: f64,
}

impl CtScanner {
    /// Standard deviation of the point spread, m.
    pub fn sigma(&self) -> f64 {
        self.blur / (8.0 * std::f64::consts::LN_2).sqrt()
    }
}

/// A scanned volume.
#[derive(Clone, Debug, PartialEq)]
pub struct CtVolume {
    /// The voxels' centres.
    pub grid: VolumeGrid,
    /// Hounsfield units, x growing fastest, then y.
    pub hu: Vec<i16>,
}

impl CtVolume {
    /// Scans closed surfaces, each filled with a density in HU.
    ///
    /// Where parts overlap, their contrasts add.
    ///
    /// # Errors
    /// Nothing to scan, or a volume larger than the memory.
    pub fn scan(parts: &[(&Surface, f64)], scanner: &CtScanner) -> Result<Self> {
        let grid = scanner.grid(parts)?;
        let [nx, ny, _] = grid.nodes;
        // Two volumes of f32, one of i16.
        memory::check(product(&[grid.len(), 10]), "the CT volume")?;
        let mut contrast = vec![0.0f32; grid.len()];
        for (surface, hu) in parts {
            let lines = LineCrossings::new(surface, &grid);
            contrast
                .par_chunks_mut(nx)
                .enumerate()
                .for_each(|(row, voxels)| {
                    lines.fill(
                        &grid,
                        [row % ny, row / ny],
                        (hu - scanner.air) as f32,
                        voxels,
                    );
                });
        }
        let mut other = vec![0.0f32; grid.len()];
        for axis in 0..3 {
            let kernel = gaussian(scanner.sigma() / grid.step[axis]);
            blur(&contrast, &mut other, grid.nodes, axis, &kernel);
            std::mem::swap(&mut contrast, &mut other);
        }
        let hu = contrast.par_iter().map(|&v| {
            let hu = f64::from(v) + scanner.air;
            hu.round().clamp(f64::from(i16::MIN), f64::from(i16::MAX)) as i16
        });
        Ok(CtVolume {
            grid,
            hu: hu.collect(),
        })
    }

    /// The surface at a level, HU, with the denser side inside.
    pub fn surface(&self, level: f64) -> Surface {
        isosurface_of_values(&self.grid, |node| level - f64::from(self.hu[node]))
    }
}

impl CtScanner {
    /// Voxels around the parts, with space for the blur.
    fn grid(&self, parts: &[(&Surface, f64)]) -> Result<VolumeGrid> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for vertex in parts.iter().flat_map(|(surface, _)| surface.vertices()) {
            for axis in 0..3 {
                low[axis] = low[axis].min(vertex[axis]);
                high[axis] = high[axis].max(vertex[axis]);
            }
        }
        if (0..3).any(|axis| !(high[axis] - low[axis]).is_finite()) {
            return Err(Error::Data("there is nothing to scan".into()));
        }
        let margin = [0, 1, 2].map(|axis| REACH * self.sigma() + 2.0 * self.voxel[axis]);
        let nodes = [0, 1, 2].map(|axis| {
            let length = high[axis] - low[axis] + 2.0 * margin[axis];
            (length / self.voxel[axis]).ceil() as usize + 1
        });
        Ok(VolumeGrid {
            corner: [0, 1, 2].map(|axis| low[axis] - margin[axis]),
            step: self.voxel,
            nodes,
        })
    }
}

/// Positions at which lines along x enter and leave a surface.
///
/// There are [`LINES`]² of them in each row of voxels.
struct LineCrossings {
    /// Crossings of each line: x, and +1 where it enters.
    crossings: Vec<Vec<(f64, i32)>>,
    /// Lines along y.
    across: usize,
}

impl LineCrossings {
    fn new(surface: &Surface, grid: &VolumeGrid) -> Self {
        let [across, down] = [1, 2].map(|axis| grid.nodes[axis] * LINES);
        let mut crossings = vec![Vec::new(); across * down];
        let position = |axis: usize, line: usize| {
            let voxels = (line as f64 + 0.5) / LINES as f64 - 0.5;
            grid.corner[axis] + voxels * grid.step[axis]
        };
        let range = |triangle: &[[f64; 3]; 3], axis: usize, count: usize| {
            let index = |v: f64| {
                let voxels = (v - grid.corner[axis]) / grid.step[axis];
                (voxels + 0.5) * LINES as f64 - 0.5
            };
            let positions = triangle.map(|v| index(v[axis]));
            let first = positions.into_iter().fold(f64::INFINITY, f64::min);
            let last = positions.into_iter().fold(f64::NEG_INFINITY, f64::max);
            // A cast of a negative value is 0; a line too many is harmless.
            first as usize..(last.ceil() as usize + 1).min(count)
        };
        for triangle in surface.corners() {
            for z in range(&triangle, 2, down) {
                for y in range(&triangle, 1, across) {
                    let p = [position(1, y), position(2, z)];
                    if let Some((x, left)) = crossing(&triangle, p, [1, 2, 0]) {
                        // The outer normal of a triangle that turns left in y and z points towards +x.
                        let step = if left { -1 } else { 1 };
                        crossings[z * across + y].push((x, step));
                    }
                }
            }
        }
        for line in &mut crossings {
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        LineCrossings { crossings, across }
    }

    /// Adds `contrast` times the share of each voxel of the row that is inside.
    fn fill(&self, grid: &VolumeGrid, [y, z]: [usize; 2], contrast: f32, voxels: &mut [f32]) {
        let fraction = contrast / (LINES * LINES) as f32;
        for line in 0..LINES * LINES {
            let [across, down] = [y * LINES + line % LINES, z * LINES + line / LINES];
            let mut inside = 0;
            let mut from = 0.0;
            for &(x, step) in &self.crossings[down * self.across + across] {
                // In voxels; voxel k reaches from k to k + 1.
                let at = (x - grid.corner[0]) / grid.step[0] + 0.5;
                if inside > 0 {
                    add(voxels, from, at, fraction);
                }
                inside += step;
                from = at;
            }
        }
    }
}

/// Adds `fraction` to the voxels between two positions; less to those at the ends.
fn add(voxels: &mut [f32], from: f64, to: f64, fraction: f32) {
    let last = voxels.len();
    let first = from.max(0.0) as usize;
    for (k, voxel) in voxels.iter_mut().enumerate().take(last).skip(first) {
        let part = to.min(k as f64 + 1.0) - from.max(k as f64);
        if part <= 0.0 {
            break;
        }
        *voxel += fraction * part as f32;
    }
}

/// A Gaussian of sum 1, from its middle outwards.
fn gaussian(sigma: f64) -> Vec<f32> {
    if sigma <= 0.0 {
        return vec![1.0];
    }
    let count = (REACH * sigma).ceil() as usize;
    let value = |k: usize| libm::exp(-0.5 * (k as f64 / sigma) * (k as f64 / sigma));
    let sum = 1.0 + 2.0 * (1..=count).map(value).sum::<f64>();
    (0..=count).map(|k| (value(k) / sum) as f32).collect()
}

/// Convolves along one axis; values outside the volume are 0.
fn blur(from: &[f32], to: &mut [f32], nodes: [usize; 3], axis: usize, kernel: &[f32]) {
    let stride: usize = nodes[..axis].iter().product();
    let count = nodes[axis];
    to.par_chunks_mut(nodes[0])
        .enumerate()
        .for_each(|(row, out)| {
            let first = row * nodes[0];
            for (k, out) in out.iter_mut().enumerate() {
                let node = first + k;
                let at = node / stride % count;
                let mut sum = kernel[0] * from[node];
                for (j, weight) in kernel.iter().enumerate().skip(1) {
                    if at >= j {
                        sum += weight * from[node - j * stride];
                    }
                    if at + j < count {
                        sum += weight * from[node + j * stride];
                    }
                }
                *out = sum;
            }
        });
}
