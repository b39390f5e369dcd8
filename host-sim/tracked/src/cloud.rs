//! Points on bone in space: duplicates, normals.

use std::collections::HashMap;

/// Side of the cubes of normals, mm, and their number to either side.
const CUBE: f64 = 0.5;
const AROUND: i32 = 2;
/// Weight of level ground against the points' slope, as a variance in mm².
const LEVEL: f64 = 1e-3;

/// A point on bone. Positions in the target's frame, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudPoint {
    /// Position, mm.
    pub position: [f64; 3],
    /// Unit normal of the surface, towards the probe.
    pub normal: [f64; 3],
    /// The way of the sound from the picture's top or the array to the point, mm.
    pub path: [f64; 3],
    /// Confidence, 0 to 1.
    pub confidence: f32,
    /// Index of the frame.
    pub frame: usize,
    /// Index of the column, or of the fan's beam.
    pub line: usize,
    /// Whether it is of a sure piece; others need neighbours.
    pub(crate) sure: bool,
}

impl CloudPoint {
    /// A point without a normal, whose sound came from `start`.
    pub(crate) fn new(
        position: [f64; 3],
        start: [f64; 3],
        confidence: f32,
        [frame, line]: [usize; 2],
    ) -> Self {
        Self {
            position,
            normal: [0.0; 3],
            path: sub(position, start),
            confidence,
            frame,
            line,
            sure: true,
        }
    }
}

/// Directions of a frame's picture, unit vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes {
    /// Along the columns' index.
    pub across: [f64; 3],
    /// Away from the probe.
    pub down: [f64; 3],
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

/// The unit vector; 0 of 0.
pub(crate) fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    if length > 0.0 {
        a.map(|part| part / length)
    } else {
        a
    }
}

/// The cube of a position.
pub(crate) fn cell(position: [f64; 3], side: f64) -> [i32; 3] {
    // The cast saturates.
    position.map(|x| (x / side).floor() as i32)
}

pub(crate) fn neighbours(cell: [i32; 3], around: i32) -> impl Iterator<Item = [i32; 3]> {
    let range = move || -around..=around;
    range()
        .flat_map(move |x| range().flat_map(move |y| range().map(move |z| [x, y, z])))
        .map(move |step| std::array::from_fn(|k| cell[k].saturating_add(step[k])))
}

/// Joins near points of different frames; returns how many were joined.
///
/// Points within `distance` mm are joined, the surest first. A joined point lies at the mean weighted by confidence, and keeps the frame and line of the surest.
pub(crate) fn join(points: &mut Vec<CloudPoint>, distance: f64) -> usize {
    if distance <= 0.0 {
        return 0;
    }
    let before = points.len();
    let mut order: Vec<usize> = (0..before).collect();
    order.sort_by(|&a, &b| points[b].confidence.total_cmp(&points[a].confidence));
    let mut kept: Vec<(CloudPoint, f64, [f64; 3])> = Vec::new();
    let mut cells: HashMap<[i32; 3], Vec<usize>> = HashMap::new();
    for k in order {
        let point = points[k];
        // Cubes of twice the distance: the ball reaches into one neighbour along each axis.
        let side = 2.0 * distance;
        let [x, y, z] = point.position.map(|x| {
            [
                ((x - distance) / side).floor() as i32,
                ((x + distance) / side).floor() as i32,
            ]
        });
        let near = |&at: &usize| {
            let off = sub(kept[at].0.position, point.position);
            let near = kept[at].0.frame != point.frame && dot(off, off) < distance * distance;
            near.then_some((at, dot(off, off)))
        };
        let mut best: Option<(usize, f64)> = None;
        for x in x[0]..=x[1] {
            for y in y[0]..=y[1] {
                for z in z[0]..=z[1] {
                    let found = cells.get(&[x, y, z]).into_iter().flatten().filter_map(near);
                    best = found.chain(best).min_by(|a, b| a.1.total_cmp(&b.1));
                }
            }
        }
        let weight = f64::from(point.confidence).max(1e-3);
        let sum = point.position.map(|x| weight * x);
        match best {
            Some((at, _)) => {
                let (_, weights, sums) = &mut kept[at];
                *weights += weight;
                *sums = std::array::from_fn(|k| sums[k] + sum[k]);
            }
            None => {
                cells
                    .entry(cell(point.position, side))
                    .or_default()
                    .push(kept.len());
                kept.push((point, weight, sum));
            }
        }
    }
    let mean = |(point, weight, sum): (CloudPoint, f64, [f64; 3])| CloudPoint {
        position: sum.map(|x| x / weight),
        ..point
    };
    *points = kept.into_iter().map(mean).collect();
    points.sort_by_key(|point| (point.frame, point.line));
    before - points.len()
}

/// A cube's points: their number, mean position and mean axes.
#[derive(Clone, Copy, Default)]
struct Cube {
    count: f64,
    position: [f64; 3],
    across: [f64; 3],
    down: [f64; 3],
}

/// Sets the normals: those of a plane through the points around.
///
/// Where the points give no slope across the pictures, as in a single frame, the normal lies in the picture.
pub(crate) fn set_normals(points: &mut [CloudPoint], axes: impl Fn(usize) -> Axes) {
    let mut cubes: HashMap<[i32; 3], Cube> = HashMap::new();
    for point in points.iter() {
        let own = axes(point.frame);
        let cube = cubes.entry(cell(point.position, CUBE)).or_default();
        cube.count += 1.0;
        for k in 0..3 {
            cube.position[k] += point.position[k];
            cube.across[k] += own.across[k];
            cube.down[k] += own.down[k];
        }
    }
    for cube in cubes.values_mut() {
        cube.position = cube.position.map(|x| x / cube.count);
    }
    let normals: HashMap<[i32; 3], [f64; 3]> = cubes
        .iter()
        .map(|(&at, cube)| {
            let down = unit(cube.down);
            let tilt = dot(cube.across, down);
            let across = unit(std::array::from_fn(|k| cube.across[k] - tilt * down[k]));
            let out = [
                across[1] * down[2] - across[2] * down[1],
                across[2] * down[0] - across[0] * down[2],
                across[0] * down[1] - across[1] * down[0],
            ];
            let near: Vec<[f64; 4]> = neighbours(at, AROUND)
                .filter_map(|at| cubes.get(&at))
                .map(|other| {
                    let off = sub(other.position, cube.position);
                    [
                        dot(off, across),
                        dot(off, out),
                        dot(off, down),
                        other.count.min(20.0),
                    ]
                })
                .collect();
            let all: f64 = near.iter().map(|near| near[3]).sum();
            let mean: [f64; 3] = std::array::from_fn(|k| {
                near.iter().map(|near| near[3] * near[k]).sum::<f64>() / all
            });
            let product = |a: usize, b: usize| {
                let of = |near: &[f64; 4]| near[3] * (near[a] - mean[a]) * (near[b] - mean[b]);
                near.iter().map(of).sum::<f64>() / all
            };
            let [uu, vv, uv] = [product(0, 0) + LEVEL, product(1, 1) + LEVEL, product(0, 1)];
            let [uw, vw] = [product(0, 2), product(1, 2)];
            let determinant = uu * vv - uv * uv;
            let slope = [
                (uw * vv - vw * uv) / determinant,
                (vw * uu - uw * uv) / determinant,
            ];
            let normal =
                std::array::from_fn(|k| slope[0] * across[k] + slope[1] * out[k] - down[k]);
            (at, unit(normal))
        })
        .collect();
    for point in points {
        let normal = normals.get(&cell(point.position, CUBE));
        point.normal = normal.copied().unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(position: [f64; 3], confidence: f32, frame: usize) -> CloudPoint {
        CloudPoint {
            position,
            normal: [0.0; 3],
            path: [0.0; 3],
            confidence,
            frame,
            line: 0,
            sure: true,
        }
    }

    #[test]
    fn near_points_of_different_frames_are_joined_at_their_weighted_mean() {
        let at = |x: f64, confidence, frame| point([x, -0.01, 0.01], confidence, frame);
        let mut points = vec![
            at(0.0, 0.25, 0),
            at(0.08, 0.75, 1),
            at(0.04, 0.5, 1),
            at(0.3, 1.0, 2),
            at(0.41, 1.0, 3),
        ];
        assert_eq!(join(&mut points.clone(), 0.0), 0);
        assert_eq!(join(&mut points, 0.1), 1);
        // The first joins the nearest within reach; points of one frame stay apart.
        let found: Vec<(usize, f64)> = points.iter().map(|p| (p.frame, p.position[0])).collect();
        assert_eq!(found.len(), 4);
        let x = |frame: usize, at: f64| {
            found
                .iter()
                .any(|(f, x)| *f == frame && (x - at).abs() < 1e-12)
        };
        assert!(
            x(1, 0.08) && x(1, 0.02 / 0.75) && x(2, 0.3) && x(3, 0.41),
            "{found:?}"
        );
    }

    #[test]
    fn normals_are_those_of_a_slanted_plane_and_lie_in_a_single_picture() {
        // Frames along y, pictures in x and −z; the plane's height is −0.3·x + 0.4·y.
        let axes = |_| Axes {
            across: [1.0, 0.0, 0.0],
            down: [0.0, 0.0, -1.0],
        };
        let plane = |x: f64, y: f64| [x, y, -0.3 * x + 0.4 * y];
        let many = |frames: usize| -> Vec<CloudPoint> {
            let of = |k: usize| {
                (0..100).map(move |c| point(plane(0.1 * c as f64, 0.2 * k as f64), 1.0, k))
            };
            (0..frames).flat_map(of).collect()
        };
        let mut points = many(40);
        set_normals(&mut points, axes);
        let expected = unit([0.3, -0.4, 1.0]);
        let inside = points
            .iter()
            .filter(|p| (2.0..8.0).contains(&p.position[0]) && (2.0..6.0).contains(&p.position[1]));
        for point in inside {
            assert!(dot(point.normal, expected) > 0.9995, "{point:?}");
        }
        let mut single = many(1);
        set_normals(&mut single, axes);
        assert!(
            dot(single[50].normal, unit([0.3, 0.0, 1.0])) > 0.9995,
            "{:?}",
            single[50]
        );
    }
}
