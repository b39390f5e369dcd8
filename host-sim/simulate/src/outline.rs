//! Outline of a bone in the image plane: closed loops, distances, points.

use bonebeam::image::PixelGrid;
use ndarray::Array2;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use crate::{Error, Result};

use super::chain::Point;
use super::noise::complex_gaussian;
use super::scatterer::SurfacePoint;

/// Number of consecutive segments with one bounding circle, to skip far ones.
const CHUNK: usize = 24;

/// Distance beside an outline at which its inside is tested, m.
const PROBE: f64 = 1e-6;

/// Closed loops that bound bone by the even–odd rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    loops: Vec<Vec<Point>>,
    chunks: Vec<Chunk>,
}

#[derive(Clone, Debug, PartialEq)]
struct Chunk {
    segments: Vec<[Point; 2]>,
    centre: Point,
    radius: f64,
}

impl Outline {
    /// The outline with the given closed loops.
    ///
    /// The last point of a loop joins its first. It is an error if there is no loop, or one with fewer than three
    /// points or a non-finite one.
    pub fn new(loops: Vec<Vec<Point>>) -> Result<Self> {
        if loops.is_empty() {
            return Err(Error::Data("the slice does not cut the bone".into()));
        }
        for (index, points) in loops.iter().enumerate() {
            if points.len() < 3 || points.iter().flatten().any(|v| !v.is_finite()) {
                return Err(Error::Data(format!(
                    "outline loop {index} needs at least 3 points, all finite"
                )));
            }
        }
        let chunks = loops
            .iter()
            .flat_map(|points| {
                let segments: Vec<_> = segments_of(points).collect();
                segments.chunks(CHUNK).map(Chunk::new).collect::<Vec<_>>()
            })
            .collect();
        Ok(Outline { loops, chunks })
    }

    /// The closed loops, points in m.
    pub fn loops(&self) -> &[Vec<Point>] {
        &self.loops
    }

    /// Every segment of every loop.
    pub fn segments(&self) -> impl Iterator<Item = [Point; 2]> + '_ {
        self.loops.iter().flat_map(|points| segments_of(points))
    }

    /// The length of all loops, m.
    pub fn length(&self) -> f64 {
        self.segments().map(|segment| length(&segment)).sum()
    }

    /// The outline moved in depth so that its shallowest point is at `depth`, m.
    pub fn at_depth(&self, depth: f64) -> Result<Self> {
        let top = self
            .loops
            .iter()
            .flatten()
            .map(|p| p[1])
            .fold(f64::INFINITY, f64::min);
        let moved = |p: &Point| [p[0], p[1] - top + depth];
        Outline::new(
            self.loops
                .iter()
                .map(|points| points.iter().map(moved).collect())
                .collect(),
        )
    }

    /// The outline without loops within others: the vertebral canal counts as bone.
    ///
    /// An ultrasound image shows only the outer surface.
    pub fn without_holes(&self) -> Result<Self> {
        let outer = |index: usize| {
            let probe = self.loops[index][0];
            !(0..self.loops.len()).any(|other| {
                other != index && crossings(segments_of(&self.loops[other]), probe) % 2 == 1
            })
        };
        Outline::new(
            (0..self.loops.len())
                .filter(|&index| outer(index))
                .map(|index| self.loops[index].clone())
                .collect(),
        )
    }

    /// Distance from (x, z) to the outline, m; positive inside the bone.
    pub fn signed_distance(&self, x: f64, z: f64) -> f64 {
        self.distance_within([x, z], f64::INFINITY)
    }

    /// The signed distance, given a `bound` on its magnitude.
    fn distance_within(&self, p: Point, bound: f64) -> f64 {
        let mut nearest = bound;
        let mut crossed = 0;
        for chunk in &self.chunks {
            let d = [p[0] - chunk.centre[0], p[1] - chunk.centre[1]];
            if d[1].abs() <= chunk.radius && d[0] <= chunk.radius {
                crossed += crossings(chunk.segments.iter().copied(), p);
            }
            let reach = nearest + chunk.radius;
            if d[0] * d[0] + d[1] * d[1] < reach * reach {
                for segment in &chunk.segments {
                    nearest = nearest.min(distance_to_segment(p, segment));
                }
            }
        }
        if crossed % 2 == 1 { nearest } else { -nearest }
    }

    /// Depth at which a line straight down at `x` first meets the outline, m, if any.
    pub fn first_hit(&self, x: f64) -> Option<f64> {
        let near = |chunk: &&Chunk| (x - chunk.centre[0]).abs() <= chunk.radius;
        let segments = self.chunks.iter().filter(near).flat_map(|c| &c.segments);
        let depths = segments.filter_map(|[a, b]| {
            let crosses = (a[0] <= x) != (b[0] <= x);
            crosses.then(|| a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]))
        });
        depths.min_by(f64::total_cmp)
    }

    /// Signed distance at the pixels of an image, `[row, column]`, m.
    pub fn distance_map(&self, grid: &PixelGrid) -> Array2<f64> {
        let PixelGrid {
            x0,
            z0,
            pixel,
            rows,
            columns,
        } = *grid;
        let mut values = vec![0.0; rows * columns];
        // An image without columns has no rows to fill.
        values
            .par_chunks_mut(columns.max(1))
            .enumerate()
            .for_each(|(row, line)| {
                let z = z0 + row as f64 * pixel;
                let mut bound = f64::INFINITY;
                for (column, value) in line.iter_mut().enumerate() {
                    *value = self.distance_within([x0 + column as f64 * pixel, z], bound);
                    // The next pixel's distance differs by no more than the step, rounding included.
                    bound = value.abs() + 1.001 * pixel;
                }
            });
        Array2::from_shape_vec((rows, columns), values).expect("one value per pixel")
    }

    /// Equally spaced points along every loop.
    ///
    /// The distance is as close to `spacing` as divides the loop into a whole number of steps.
    pub fn equally_spaced(&self, spacing: f64) -> Vec<Point> {
        self.loops
            .iter()
            .flat_map(|points| resample(points, spacing))
            .collect()
    }

    /// Equally spaced points with their outward unit normals.
    pub(super) fn points_with_normals(&self, spacing: f64) -> Vec<SurfacePoint> {
        let mut all = Vec::new();
        for points in &self.loops {
            let points = resample(points, spacing);
            let n = points.len();
            let Some(&p) = points.first() else { continue };
            let normal = |k: usize| {
                let (before, after) = (points[(k + n - 1) % n], points[(k + 1) % n]);
                let chord = [after[0] - before[0], after[1] - before[1]];
                let length = libm::hypot(chord[0], chord[1]).max(f64::MIN_POSITIVE);
                [chord[1] / length, -chord[0] / length]
            };
            // Which way the loop goes.
            let out = normal(0);
            let inside =
                |step: f64| self.signed_distance(p[0] + step * out[0], p[1] + step * out[1]);
            let sign = if inside(PROBE) > inside(-PROBE) {
                -1.0
            } else {
                1.0
            };
            all.extend((0..n).map(|k| {
                let [x, z] = normal(k).map(|v| sign * v);
                ([points[k][0], 0.0, points[k][1]], [x, 0.0, z])
            }));
        }
        all
    }

    /// The outline as straight facets between corners about `edge` apart.
    ///
    /// Each corner is moved off the outline by a Gaussian distance of standard deviation `roughness`, m.
    pub fn faceted(&self, edge: f64, roughness: f64, seed: u64) -> Result<Self> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut facet = |points: &Vec<Point>| -> Vec<Point> {
            let corners = resample(points, edge);
            let n = corners.len();
            (0..n)
                .map(|k| {
                    let (before, after) = (corners[(k + n - 1) % n], corners[(k + 1) % n]);
                    let chord = [after[0] - before[0], after[1] - before[1]];
                    let length = libm::hypot(chord[0], chord[1]).max(f64::MIN_POSITIVE);
                    let offset = roughness * complex_gaussian(&mut random).re / length;
                    [
                        corners[k][0] + offset * chord[1],
                        corners[k][1] - offset * chord[0],
                    ]
                })
                .collect()
        };
        // A loop of fewer than three facets has no inside left.
        Outline::new(
            self.loops
                .iter()
                .map(&mut facet)
                .filter(|f| f.len() > 2)
                .collect(),
        )
    }
}

impl Chunk {
    fn new(segments: &[[Point; 2]]) -> Self {
        let n = 2.0 * segments.len() as f64;
        let mut centre = [0.0; 2];
        for p in segments.iter().flatten() {
            centre = [centre[0] + p[0] / n, centre[1] + p[1] / n];
        }
        let radius = segments
            .iter()
            .flatten()
            .map(|p| libm::hypot(p[0] - centre[0], p[1] - centre[1]))
            .fold(0.0, f64::max);
        Chunk {
            segments: segments.to_vec(),
            centre,
            radius,
        }
    }
}

fn segments_of(points: &[Point]) -> impl Iterator<Item = [Point; 2]> + '_ {
    (0..points.len()).map(move |k| [points[k], points[(k + 1) % points.len()]])
}

fn length(segment: &[Point; 2]) -> f64 {
    libm::hypot(segment[1][0] - segment[0][0], segment[1][1] - segment[0][1])
}

fn resample(path: &[Point], spacing: f64) -> Vec<Point> {
    let total: f64 = segments_of(path).map(|s| length(&s)).sum();
    let step = total / (total / spacing).round().max(1.0);
    let mut points = Vec::new();
    let mut travelled = 0.0;
    for segment in segments_of(path) {
        let along = length_or_tiny(&segment);
        let [a, b] = segment;
        loop {
            let next = points.len() as f64 * step;
            // The closing half step is the first point again.
            if next >= travelled + along || next >= total - 0.5 * step {
                break;
            }
            let w = (next - travelled) / along;
            points.push([a[0] + w * (b[0] - a[0]), a[1] + w * (b[1] - a[1])]);
        }
        travelled += along;
    }
    points
}

/// Length of a segment, never 0, so that divisions by it are finite.
fn length_or_tiny(segment: &[Point; 2]) -> f64 {
    length(segment).max(f64::MIN_POSITIVE)
}

/// Number of segments that a ray from `p` towards growing x crosses.
fn crossings(segments: impl Iterator<Item = [Point; 2]>, p: Point) -> usize {
    segments
        .filter(|[a, b]| {
            (a[1] > p[1]) != (b[1] > p[1])
                && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        })
        .count()
}

fn distance_to_segment(p: Point, [a, b]: &[Point; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let q = [p[0] - a[0], p[1] - a[1]];
    let square = d[0] * d[0] + d[1] * d[1];
    let along = if square > 0.0 {
        ((q[0] * d[0] + q[1] * d[1]) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    libm::hypot(q[0] - along * d[0], q[1] - along * d[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square_with_hole() -> Outline {
        let square = |r: f64| vec![[-r, 10.0 - r], [r, 10.0 - r], [r, 10.0 + r], [-r, 10.0 + r]];
        Outline::new(vec![square(4.0), square(1.0)]).unwrap()
    }

    #[test]
    fn signed_distance_of_a_square_with_a_hole() {
        let outline = square_with_hole();
        for (x, z, expected) in [
            (0.0, 5.0, -1.0),
            (0.0, 6.5, 0.5),
            (0.0, 10.0, -1.0),
            (2.5, 10.0, 1.5),
            (7.0, 2.0, -5.0),
            (-7.0, 18.0, -5.0),
        ] {
            let found = outline.signed_distance(x, z);
            assert!((found - expected).abs() < 1e-12, "({x}, {z}): {found}");
        }
        assert!((outline.without_holes().unwrap().signed_distance(0.0, 10.0) - 4.0).abs() < 1e-12);
        assert!((outline.at_depth(15.0).unwrap().signed_distance(0.0, 14.0) + 1.0).abs() < 1e-12);
        let map = outline.distance_map(&PixelGrid::new([0.0, 5.0], 1.5, [3, 2]));
        assert!(
            (map[[1, 0]] - 0.5).abs() < 1e-12
                && (map[[2, 1]] - outline.signed_distance(1.5, 8.0)).abs() < 1e-12
        );
    }

    #[test]
    fn normals_point_away_from_the_bone() {
        let outline = square_with_hole();
        for ([x, _, z], [nx, _, nz]) in outline.points_with_normals(0.5) {
            assert!((libm::hypot(nx, nz) - 1.0).abs() < 1e-12);
            assert!(
                outline.signed_distance(x + 0.1 * nx, z + 0.1 * nz) < 0.0,
                "({x}, {z})"
            );
        }
    }

    #[test]
    fn points_are_equally_spaced_and_complete() {
        // Perimeters 32 and 8 at a spacing of 0.5.
        let points = square_with_hole().equally_spaced(0.5);
        assert_eq!(points.len(), 64 + 16);
        for pair in points[..64].windows(2) {
            assert!((length(&[pair[0], pair[1]]) - 0.5).abs() < 1e-12);
        }
        assert!((length(&[points[63], points[0]]) - 0.5).abs() < 1e-12);
    }
}
