//! A bone's surface of triangles: checks, cuts, scatterers, and its inside.

use std::collections::BTreeMap;

use crate::Result;

use super::chain::{Segment, closed_loops};
use super::outline::Outline;
use super::scatterer::{Scatterer, SurfacePoint};
use super::vector::{cross, dot, sub};

/// A surface of triangles, in metres along the array's axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// Result of the check of a closed surface.
pub(super) struct Found {
    /// The normals point inwards.
    pub inverted: bool,
    /// Edges at which two triangles have opposite winding.
    pub mixed: usize,
}

impl Surface {
    /// The surface with these corners, m, and triangles as indices of corners.
    pub fn new(vertices: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Surface {
            vertices,
            triangles,
        }
    }

    /// The corners, m.
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// Triangles as indices of corners, anticlockwise as seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The corners of every triangle, m.
    pub fn corners(&self) -> impl Iterator<Item = [[f64; 3]; 3]> + '_ {
        let corner = |index: u32| self.vertices[index as usize];
        self.triangles.iter().map(move |t| t.map(corner))
    }

    /// The surface moved by `by` along each axis, m.
    pub fn moved(mut self, by: [f64; 3]) -> Self {
        for vertex in &mut self.vertices {
            *vertex = [0, 1, 2].map(|k| vertex[k] + by[k]);
        }
        self
    }

    /// The surface with each corner moved by `map`.
    pub fn mapped(mut self, map: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        for vertex in &mut self.vertices {
            *vertex = map(*vertex);
        }
        self
    }

    /// Both surfaces as one.
    pub fn joined(mut self, other: &Surface) -> Self {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        let shifted = other.triangles.iter().map(|t| t.map(|k| k + first));
        self.triangles.extend(shifted);
        self
    }

    /// Shallowest point of the surface at (x, y), and its outward unit normal.
    pub fn shallowest(&self, x: f64, y: f64) -> Option<([f64; 3], [f64; 3])> {
        let hits = self.corners().filter_map(|triangle| {
            let (z, _) = crossing(&triangle, [x, y], [0, 1, 2])?;
            let normal = cross(sub(triangle[1], triangle[0]), sub(triangle[2], triangle[0]));
            let length = dot(normal, normal).sqrt();
            Some(([x, y, z], normal.map(|n| n / length)))
        });
        hits.min_by(|a, b| a.0[2].total_cmp(&b.0[2]))
    }

    /// The surface with every triangle reversed.
    pub(super) fn inside_out(mut self) -> Self {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self
    }

    /// Enclosed volume, m³; negative for a surface that is inside out.
    pub fn volume(&self) -> f64 {
        let six = self.corners().map(|[a, b, c]| dot(a, cross(b, c)));
        six.sum::<f64>() / 6.0
    }

    /// Checks that the surface is closed.
    ///
    /// Every edge must belong to two triangles, or to another even number.
    pub(super) fn check(&self) -> std::result::Result<Found, String> {
        // Of every edge, how often it is passed either way.
        let mut edges: BTreeMap<[u32; 2], [u32; 2]> = BTreeMap::new();
        for t in &self.triangles {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                let way = usize::from(a > b);
                edges.entry([a.min(b), a.max(b)]).or_default()[way] += 1;
            }
        }
        let open: Vec<_> = edges
            .iter()
            .filter(|(_, n)| (n[0] + n[1]) % 2 == 1)
            .collect();
        if let Some(([a, _], _)) = open.first() {
            let [x, y, z] = self.vertices[*a as usize].map(|v| 1e3 * v);
            return Err(format!(
                "the surface is open: {} edges belong to one triangle only, the first at {x:.3} mm across, \
                 {y:.3} mm of elevation, {z:.3} mm of depth; expected a closed surface",
                open.len()
            ));
        }
        Ok(Found {
            inverted: self.volume() < 0.0,
            mixed: edges.values().filter(|n| n[0] != n[1]).count(),
        })
    }

    /// Least z of the corners within `across` of x = 0 and `beside` of y = 0, m.
    pub fn top(&self, across: f64, beside: f64) -> Option<f64> {
        let near = |v: &&[f64; 3]| v[0].abs() <= across && v[1].abs() <= beside;
        let depths = self.vertices.iter().filter(near).map(|v| v[2]);
        depths.min_by(f64::total_cmp)
    }

    /// Outline in which the image plane y = 0 cuts the surface; `None` if it does not.
    ///
    /// # Errors
    /// A message that the surface is open there.
    pub fn outline(&self) -> std::result::Result<Option<Outline>, String> {
        let mut segments = Vec::new();
        for triangle in &self.triangles {
            let mut cut = Vec::with_capacity(2);
            for k in 0..3 {
                // A corner on the plane counts as above it, so that every edge is cut or not, alike for the
                // triangles that share it; the order of its ends keeps the point's bits alike.
                let mut ends = [triangle[k] as usize, triangle[(k + 1) % 3] as usize];
                ends.sort_unstable();
                let [a, b] = ends.map(|end| self.vertices[end]);
                if (a[1] >= 0.0) == (b[1] >= 0.0) {
                    continue;
                }
                let w = a[1] / (a[1] - b[1]);
                let at = |axis: usize| a[axis] + w * (b[axis] - a[axis]);
                cut.push(((ends[0], ends[1]), [at(0), at(2)]));
            }
            if let [(edge_a, a), (edge_b, b)] = cut[..] {
                segments.push(Segment {
                    edges: [edge_a, edge_b],
                    ends: [a, b],
                });
            }
        }
        if segments.is_empty() {
            return Ok(None);
        }
        let loops = closed_loops(&segments)
            .ok_or_else(|| "the surface is not closed at the image plane".to_owned())?;
        Outline::new(loops)
            .map(Some)
            .map_err(|error| error.to_string())
    }

    /// Evenly spread scatterers of amplitude 1 on the surface.
    ///
    /// There are `density` per m² at positions for which `wanted` is true. The triangles share one sequence of
    /// points (the additive recurrence of the plastic number), so that small ones get their share.
    ///
    /// # Errors
    /// More scatterers than any machine can hold.
    pub fn scatterers(
        &self,
        density: f64,
        wanted: impl Fn([f64; 3]) -> bool,
    ) -> Result<Vec<Scatterer>> {
        let points = self.points_with_normals(density, wanted)?.into_iter();
        let scatterer = |([x, y, z], _): SurfacePoint| Scatterer::new([x, y, z], 1.0);
        Ok(points.map(scatterer).collect())
    }

    /// Points of [`Surface::scatterers`] with their outward unit normals.
    pub(super) fn points_with_normals(
        &self,
        density: f64,
        wanted: impl Fn([f64; 3]) -> bool,
    ) -> Result<Vec<SurfacePoint>> {
        // 1/p and 1/p² of the plastic number p.
        const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
        let mut points = Vec::new();
        let (mut owed, mut index) = (0.5, 0u64);
        for [a, b, c] in self.corners() {
            let (ab, ac) = (sub(b, a), sub(c, a));
            let normal = cross(ab, ac);
            let length = dot(normal, normal).sqrt();
            owed += 0.5 * length * density;
            while owed >= 1.0 {
                owed -= 1.0;
                index += 1;
                let fraction = |step: f64| {
                    let v = 0.5 + index as f64 * step;
                    v - v.floor()
                };
                let [mut u, mut v] = STEP.map(fraction);
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                let p = [0, 1, 2].map(|k| a[k] + u * ab[k] + v * ac[k]);
                if wanted(p) {
                    points.push((p, normal.map(|n| n / length)));
                }
            }
        }
        Ok(points)
    }
}

/// A closed surface along lines straight down: inside, and first intersection.
pub(super) struct StraightDown {
    corner: [f64; 2],
    columns: usize,
    rows: usize,
    /// The triangles over each square of x and y.
    squares: Vec<Vec<[[f64; 3]; 3]>>,
}

/// Side of the squares, m.
const SQUARE: f64 = 0.25e-3;
/// Largest number of squares along each side.
const MOST_SQUARES: usize = 4000;

impl StraightDown {
    pub fn new(surface: &Surface) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for v in &surface.vertices {
            for axis in 0..2 {
                low[axis] = low[axis].min(v[axis]);
                high[axis] = high[axis].max(v[axis]);
            }
        }
        let count =
            |axis: usize| (((high[axis] - low[axis]) / SQUARE) as usize + 1).clamp(1, MOST_SQUARES);
        let mut lines = StraightDown {
            corner: low,
            columns: count(0),
            rows: count(1),
            squares: Vec::new(),
        };
        lines.squares.resize(lines.columns * lines.rows, Vec::new());
        for triangle in surface.corners() {
            let range = |axis: usize, most: usize| {
                let squares = triangle.map(|v| lines.square(v[axis], axis));
                let first = squares.into_iter().fold(f64::INFINITY, f64::min);
                let last = squares.into_iter().fold(0.0, f64::max);
                (first as usize).min(most - 1)..=(last as usize).min(most - 1)
            };
            let (columns, rows) = (range(0, lines.columns), range(1, lines.rows));
            for row in rows {
                for column in columns.clone() {
                    lines.squares[row * lines.columns + column].push(triangle);
                }
            }
        }
        lines
    }

    fn square(&self, value: f64, axis: usize) -> f64 {
        (value - self.corner[axis]) / SQUARE
    }

    /// Depths at which the line down at (x, y) crosses the surface, unordered.
    fn depths(&self, x: f64, y: f64) -> impl Iterator<Item = f64> + '_ {
        let (column, row) = (self.square(x, 0), self.square(y, 1));
        let within = column >= 0.0 && row >= 0.0;
        let (column, row) = (column as usize, row as usize);
        let within = within && column < self.columns && row < self.rows;
        let triangles = within.then(|| &self.squares[row * self.columns + column]);
        let crossed = move |t: &[[f64; 3]; 3]| Some(crossing(t, [x, y], [0, 1, 2])?.0);
        triangles.into_iter().flatten().filter_map(crossed)
    }

    /// Whether the point is inside: an odd number of triangles is above it.
    pub fn holds(&self, [x, y, z]: [f64; 3]) -> bool {
        self.depths(x, y).filter(|&depth| depth < z).count() % 2 == 1
    }

    /// Depth at which the line down at (x, y) first meets the surface, m, if it does.
    pub fn first_hit(&self, x: f64, y: f64) -> Option<f64> {
        self.depths(x, y).min_by(f64::total_cmp)
    }
}

/// Intersection of a triangle with a line along the last of the `axes`.
///
/// Also returns whether the triangle turns left there in the plane of the first two axes. `p` is the line's
/// position in that plane. If triangles share an edge or a corner, only one of them gets the line.
pub(super) fn crossing(
    triangle: &[[f64; 3]; 3],
    p: [f64; 2],
    [u, v, along]: [usize; 3],
) -> Option<(f64, bool)> {
    // Twice the signed areas that p makes with the edges. An edge has the same value for both its triangles,
    // whichever way they pass it.
    let area = |a: [f64; 3], b: [f64; 3]| {
        let (a, b, sign) = match (a[u], a[v]) <= (b[u], b[v]) {
            true => (a, b, 1.0),
            false => (b, a, -1.0),
        };
        sign * ((a[u] - p[0]) * (b[v] - p[1]) - (a[v] - p[1]) * (b[u] - p[0]))
    };
    let [a, b, c] = *triangle;
    let w = [area(b, c), area(c, a), area(a, b)];
    let left_turns = w.map(|w| w > 0.0);
    if left_turns[0] != left_turns[1] || left_turns[1] != left_turns[2] {
        return None;
    }
    let total = w[0] + w[1] + w[2];
    let at = (w[0] * a[along] + w[1] * b[along] + w[2] * c[along]) / total;
    (total != 0.0).then_some((at, left_turns[0]))
}
