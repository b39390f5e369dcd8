//! The bone's triangles in a tree of boxes: nearest points and blocked rays.

use std::path::Path;

use crate::Result;
use crate::algebra::{V3, add, cross, dot, mean, scale, sub, unit};
use crate::cloud::{is_ras, to_lps};
use crate::volume::Volume;
use bonebeam_files::file_error;
use bonebeam_simulate::{Surface, read_surface};

/// Largest number of triangles in a leaf.
const LEAF: usize = 4;
/// Least cosine between a point's normal and that of the surface it belongs to: 70°.
const FACING: f64 = 0.34;

/// Density at which bone begins in a CT volume, HU.
pub const THRESHOLD: f64 = 250.0;

/// A surface of triangles, mm, with normals outwards.
pub struct Bone {
    surface: Surface,
    /// Unit normals of the triangles.
    normals: Vec<V3>,
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
}

/// A box. Its first child follows it.
struct Node {
    low: V3,
    high: V3,
    /// Least and greatest components of its triangles' normals.
    normals: [V3; 2],
    /// Of a leaf the first in `order`, else the second child.
    link: u32,
    /// Number of triangles of a leaf, else 0.
    count: u32,
}

/// The nearest point of the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub triangle: usize,
    pub point: V3,
    /// Square of the distance, mm².
    pub square: f64,
}

impl Bone {
    /// Builds the tree. Triangles without area are left out of it.
    pub fn new(surface: Surface) -> Bone {
        let normal = |[a, b, c]: [V3; 3]| unit(cross(sub(b, a), sub(c, a)));
        let normals: Vec<V3> = surface.corners().map(normal).collect();
        let centres: Vec<V3> = surface.corners().map(mean).collect();
        let valid = |k: &u32| normals[*k as usize] != [0.0; 3];
        let mut bone = Bone {
            order: (0..normals.len() as u32).filter(valid).collect(),
            normals,
            nodes: Vec::new(),
            surface,
        };
        let mut order = std::mem::take(&mut bone.order);
        bone.grow(&mut order, 0, &centres);
        bone.order = order;
        bone
    }

    /// Reads a `.stl`, `.obj` or `.ply` mesh in mm, or a `.nii` volume, with warnings.
    ///
    /// A mesh that says `SPACE=RAS` near its beginning is turned to LPS. A volume needs `threshold`, HU.
    ///
    /// # Errors
    /// A file that cannot be read, or without triangles. A threshold for a mesh.
    pub fn read(path: &Path, threshold: Option<f64>) -> Result<(Bone, Vec<String>)> {
        let name = path.to_string_lossy().to_ascii_lowercase();
        if name.ends_with(".nii") || name.ends_with(".nii.gz") {
            let (volume, warning) = Volume::read_nifti(path)?;
            let warning = warning.map(|warning| format!("{}: {warning}", path.display()));
            let bone = Self::of_volume(path, volume, threshold)?;
            return Ok((bone, warning.into_iter().collect()));
        }
        if threshold.is_some() {
            let message = "has triangles: a threshold has no effect on it";
            return Err(file_error(path, message));
        }
        let (mut surface, warnings) = read_surface(path)?;
        if is_ras(path)? {
            surface = surface.mapped(to_lps);
        }
        Ok((Bone::new(surface), warnings))
    }

    /// The surface of the largest part of a volume above a threshold, HU.
    ///
    /// # Errors
    /// No voxel above it; `path` names the volume.
    pub fn of_volume(path: &Path, volume: Volume, threshold: Option<f64>) -> Result<Bone> {
        let surface = volume.surface(threshold.unwrap_or(THRESHOLD));
        let surface = surface.map_err(|e| file_error(path, e.to_string()))?;
        Ok(Bone::new(surface))
    }

    /// The triangles.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    pub(crate) fn normal(&self, triangle: usize) -> V3 {
        self.normals[triangle]
    }

    pub(crate) fn corners(&self, triangle: usize) -> [V3; 3] {
        let corner = |k: u32| self.surface.vertices()[k as usize];
        self.surface.triangles()[triangle].map(corner)
    }

    /// Least and greatest coordinates, mm.
    pub(crate) fn extent(&self) -> [V3; 2] {
        let root = self.nodes.first();
        root.map_or([[0.0; 3]; 2], |root| [root.low, root.high])
    }

    fn grow(&mut self, order: &mut [u32], first: usize, centres: &[V3]) {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let (mut least, mut most) = (low, high);
        let mut normals = [low, high];
        for &k in order.iter() {
            let normal = self.normal(k as usize);
            for axis in 0..3 {
                normals[0][axis] = normals[0][axis].min(normal[axis]);
                normals[1][axis] = normals[1][axis].max(normal[axis]);
            }
            for p in self.corners(k as usize) {
                for axis in 0..3 {
                    low[axis] = low[axis].min(p[axis]);
                    high[axis] = high[axis].max(p[axis]);
                }
            }
            let centre = centres[k as usize];
            for axis in 0..3 {
                least[axis] = least[axis].min(centre[axis]);
                most[axis] = most[axis].max(centre[axis]);
            }
        }
        let at = self.nodes.len();
        self.nodes.push(Node {
            low,
            high,
            normals,
            link: first as u32,
            count: order.len() as u32,
        });
        if order.len() <= LEAF {
            return;
        }
        let spread = sub(most, least);
        let axis = (0..3).fold(0, |best, k| if spread[k] > spread[best] { k } else { best });
        let half = order.len() / 2;
        let along = |k: &u32| centres[*k as usize][axis];
        order.select_nth_unstable_by(half, |a, b| along(a).total_cmp(&along(b)));
        let (left, right) = order.split_at_mut(half);
        self.grow(left, first, centres);
        self.nodes[at].link = self.nodes.len() as u32;
        self.nodes[at].count = 0;
        self.grow(right, first + half, centres);
    }

    /// The nearest point within `reach` mm on triangles that `accept` admits.
    ///
    /// The triangles are at most 70° from `normal`; all are if it is zero.
    pub(crate) fn nearest(
        &self,
        point: V3,
        reach: f64,
        normal: V3,
        accept: &impl Fn(usize) -> bool,
    ) -> Option<Hit> {
        let mut best = Hit {
            triangle: usize::MAX,
            point,
            square: reach * reach,
        };
        if !self.order.is_empty() {
            self.search(0, &mut best, point, normal, accept);
        }
        (best.triangle != usize::MAX).then_some(best)
    }

    fn search(
        &self,
        at: usize,
        best: &mut Hit,
        p: V3,
        normal: V3,
        accept: &impl Fn(usize) -> bool,
    ) {
        let node = &self.nodes[at];
        let [least, most] = node.normals;
        let facing = (0..3).map(|k| (normal[k] * least[k]).max(normal[k] * most[k]));
        if normal != [0.0; 3] && facing.sum::<f64>() <= FACING {
            return;
        }
        if node.count > 0 {
            for &k in &self.order[node.link as usize..][..node.count as usize] {
                let triangle = k as usize;
                let point = closest(self.corners(triangle), p);
                let off = sub(p, point);
                let square = dot(off, off);
                let faces = || normal == [0.0; 3] || dot(normal, self.normal(triangle)) > FACING;
                if square < best.square && faces() && accept(triangle) {
                    *best = Hit {
                        triangle,
                        point,
                        square,
                    };
                }
            }
            return;
        }
        let children = [at + 1, node.link as usize];
        let [a, b] = children.map(|k| self.nodes[k].square_distance(p));
        let ordered = if a <= b {
            [(children[0], a), (children[1], b)]
        } else {
            [(children[1], b), (children[0], a)]
        };
        for (child, square) in ordered {
            if square < best.square {
                self.search(child, best, p, normal, accept);
            }
        }
    }

    /// Whether a ray meets the surface.
    pub(crate) fn blocked(&self, origin: V3, direction: V3) -> bool {
        let inverse = direction.map(|v| 1.0 / v);
        let mut stack = vec![0];
        while let Some(at) = stack.pop() {
            let Some(node) = self.nodes.get(at) else {
                return false;
            };
            if !node.is_met(origin, inverse) {
                continue;
            }
            if node.count == 0 {
                stack.extend([at + 1, node.link as usize]);
                continue;
            }
            let leaf = &self.order[node.link as usize..][..node.count as usize];
            if leaf
                .iter()
                .any(|&k| is_crossed(self.corners(k as usize), origin, direction))
            {
                return true;
            }
        }
        false
    }
}

impl Node {
    fn square_distance(&self, p: V3) -> f64 {
        let off = |k: usize| (self.low[k] - p[k]).max(p[k] - self.high[k]).max(0.0);
        let off = [off(0), off(1), off(2)];
        dot(off, off)
    }

    fn is_met(&self, origin: V3, inverse: V3) -> bool {
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for k in 0..3 {
            let [a, b] = [self.low[k], self.high[k]].map(|side| (side - origin[k]) * inverse[k]);
            // NaN of 0 · ∞ changes neither.
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        enter <= leave
    }
}

/// The point of a triangle closest to `p` (C. Ericson, Real-Time Collision Detection, section 5.1.5).
fn closest([a, b, c]: [V3; 3], p: V3) -> V3 {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let [(d1, d2), (d3, d4), (d5, d6)] = [a, b, c].map(|corner| {
        let from = sub(p, corner);
        (dot(ab, from), dot(ac, from))
    });
    let along = |from: V3, edge: V3, by: f64| add(from, scale(edge, by));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return along(a, ab, d1 / (d1 - d3));
    }
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return along(a, ac, d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    let (u, v) = (d4 - d3, d5 - d6);
    if va <= 0.0 && u >= 0.0 && v >= 0.0 {
        return along(b, sub(c, b), u / (u + v));
    }
    let sum = va + vb + vc;
    along(along(a, ab, vb / sum), ac, vc / sum)
}

/// Whether a ray crosses a triangle (T. Möller, B. Trumbore, J. Graphics Tools 2, 21–28, 1997).
fn is_crossed([a, b, c]: [V3; 3], origin: V3, direction: V3) -> bool {
    let (ab, ac, from) = (sub(b, a), sub(c, a), sub(origin, a));
    let (across, beside) = (cross(direction, ac), cross(from, ab));
    let determinant = dot(ab, across);
    let [u, v, t] = [dot(from, across), dot(direction, beside), dot(ac, beside)]
        .map(|value| value / determinant);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    /// Triangles at random, compared with all of them one by one and with a dense sampling.
    #[test]
    fn the_tree_finds_what_all_triangles_hold() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut point = |size: f64| [0, 1, 2].map(|_| size * (random.random::<f64>() - 0.5));
        let mut vertices = Vec::new();
        for _ in 0..300 {
            let centre = point(100.0);
            vertices.extend([0, 1, 2].map(|_| add(centre, point(20.0))));
        }
        let triangles: Vec<[u32; 3]> = (0..300).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let bone = Bone::new(Surface::new(vertices, triangles));
        let (mut within, mut met) = (0, 0);
        for _ in 0..300 {
            let p = point(120.0);
            let even = |k: usize| k.is_multiple_of(2);
            let normal = if p[0] > 0.0 {
                unit(point(1.0))
            } else {
                [0.0; 3]
            };
            let faces = |k: usize| p[0] <= 0.0 || dot(normal, bone.normal(k)) > FACING;
            let valid = |k: &usize| even(*k) && faces(*k);
            let squares = (0..300).filter(valid).map(|k| {
                let off = sub(closest(bone.corners(k), p), p);
                dot(off, off)
            });
            let least = squares.fold(f64::INFINITY, f64::min);
            let hit = bone.nearest(p, 9.0, normal, &even);
            assert_eq!(hit.is_some(), least < 81.0);
            if let Some(hit) = hit {
                within += 1;
                assert_eq!(hit.square, least);
                assert!(valid(&hit.triangle));
                let [a, b, c] = bone.corners(hit.triangle);
                for (u, v) in (0..21).flat_map(|u| (0..21 - u).map(move |v| (u, v))) {
                    let [u, v] = [u, v].map(|share| f64::from(share) / 20.0);
                    let q = add(a, add(scale(sub(b, a), u), scale(sub(c, a), v)));
                    assert!(dot(sub(p, q), sub(p, q)) >= hit.square - 1e-9);
                }
            }
            let direction = unit(point(1.0));
            let crossed = (0..300).any(|k| is_crossed(bone.corners(k), p, direction));
            met += usize::from(crossed);
            assert_eq!(bone.blocked(p, direction), crossed);
        }
        assert!(within > 60 && met > 60, "{within} {met}");
    }
}
