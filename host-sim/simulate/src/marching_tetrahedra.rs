//! The closed surface on which a function of space is zero.
//!
//! Each cube of a grid is six tetrahedra around its diagonal, and each corner of the surface lies on an edge
//! between two nodes of opposite sign. Neighbouring cubes share their edges, so the surface is closed if the
//! function is positive on the boundary of the grid.

use std::collections::HashMap;
use std::hash::BuildHasherDefault;

use fnv::FnvHasher;
use rayon::prelude::*;

use super::surface::Surface;

/// A grid of nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeGrid {
    /// The first node, m.
    pub corner: [f64; 3],
    /// Distance of the nodes along each axis, m.
    pub step: [f64; 3],
    /// Nodes along each axis, at least 2.
    pub nodes: [usize; 3],
}

/// Corners of a cube's tetrahedra: bit k of a corner is a step along axis k.
const TETRAHEDRA: [[usize; 4]; 6] = [
    [0, 1, 3, 7],
    [0, 3, 2, 7],
    [0, 2, 6, 7],
    [0, 6, 4, 7],
    [0, 4, 5, 7],
    [0, 5, 1, 7],
];

impl VolumeGrid {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.iter().product()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position of a node; x grows fastest with its number, then y.
    pub fn position(&self, node: usize) -> [f64; 3] {
        let [nx, ny, _] = self.nodes;
        let index = [node % nx, node / nx % ny, node / nx / ny];
        [0, 1, 2].map(|k| self.corner[k] + index[k] as f64 * self.step[k])
    }
}

/// The surface on which `f` is zero.
///
/// Its triangles are anticlockwise as seen from the side where `f` is positive.
pub fn isosurface(grid: &VolumeGrid, f: impl Fn([f64; 3]) -> f64 + Sync) -> Surface {
    let values: Vec<f64> = (0..grid.len())
        .into_par_iter()
        .map(|node| f(grid.position(node)))
        .collect();
    isosurface_of_values(grid, |node| values[node])
}

/// Surface of a ball; its corners are on the sphere to a hundredth of the radius.
pub fn ball(centre: [f64; 3], radius: f64) -> Surface {
    let step = radius / 10.0;
    let grid = VolumeGrid {
        corner: centre.map(|c| c - radius - 2.03 * step),
        step: [step; 3],
        nodes: [25; 3],
    };
    isosurface(&grid, |p| {
        let d = [0, 1, 2].map(|k| p[k] - centre[k]);
        (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt() - radius
    })
}

/// The surface of a function that is given at the nodes, by their number.
pub fn isosurface_of_values(grid: &VolumeGrid, value: impl Fn(usize) -> f64) -> Surface {
    let [nx, ny, nz] = grid.nodes;
    let position = |node: usize| grid.position(node);
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let mut known: HashMap<(usize, usize), u32, BuildHasherDefault<FnvHasher>> = HashMap::default();
    for cube in 0..grid.len() {
        let [x, y, z] = [cube % nx, cube / nx % ny, cube / nx / ny];
        if x + 1 == nx || y + 1 == ny || z + 1 == nz {
            continue;
        }
        let node = |corner: usize| {
            cube + (corner & 1) + (corner >> 1 & 1) * nx + (corner >> 2 & 1) * nx * ny
        };
        let inside = (0..8).filter(|&corner| value(node(corner)) < 0.0).count();
        if inside == 0 || inside == 8 {
            continue;
        }
        let mut on_edge = |a: usize, b: usize| {
            let (a, b) = (a.min(b), a.max(b));
            *known.entry((a, b)).or_insert_with(|| {
                let w = value(a) / (value(a) - value(b));
                let (p, q) = (position(a), position(b));
                vertices.push([0, 1, 2].map(|k| p[k] + w * (q[k] - p[k])));
                (vertices.len() - 1) as u32
            })
        };
        for corners in TETRAHEDRA {
            let nodes = corners.map(node);
            let within = nodes.map(|node| value(node) < 0.0);
            let (inner, outer): (Vec<usize>, Vec<usize>) = (0..4).partition(|&k| within[k]);
            // The tetrahedron's own winding, turned by each exchange of corners.
            match (&inner[..], &outer[..]) {
                (&[i], &[a, b, c]) => {
                    let mut t = [a, b, c].map(|o| on_edge(nodes[i], nodes[o]));
                    if even([i, a, b, c]) {
                        t.swap(1, 2);
                    }
                    triangles.push(t);
                }
                (&[a, b, c], &[o]) => {
                    let mut t = [a, b, c].map(|i| on_edge(nodes[i], nodes[o]));
                    if !even([o, a, b, c]) {
                        t.swap(1, 2);
                    }
                    triangles.push(t);
                }
                (&[a, b], &[c, d]) => {
                    let corner = [(a, c), (a, d), (b, d), (b, c)];
                    let q = corner.map(|(i, o)| on_edge(nodes[i], nodes[o]));
                    let two = match even([a, b, c, d]) {
                        true => [[q[0], q[2], q[1]], [q[0], q[3], q[2]]],
                        false => [[q[0], q[1], q[2]], [q[0], q[2], q[3]]],
                    };
                    triangles.extend(two);
                }
                _ => {}
            }
        }
    }
    // A corner of the surface on a node belongs to several edges; such slivers do no harm.
    let surface = Surface::new(vertices, triangles);
    match surface.volume() < 0.0 {
        true => surface.inside_out(),
        false => surface,
    }
}

/// Whether an even number of exchanges sorts the four.
fn even(order: [usize; 4]) -> bool {
    let pairs = (0..4).flat_map(|a| (a + 1..4).map(move |b| (a, b)));
    pairs.filter(|&(a, b)| order[a] > order[b]).count() % 2 == 0
}
