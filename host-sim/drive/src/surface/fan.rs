//! The fan of a picture of a curved array or a sector, found by its black corners.

use std::collections::VecDeque;

use ndarray::{Array2, ArrayView2};
use serde::{Deserialize, Serialize};

/// Geometry of a picture's beams, which fan out from an apex.
///
/// The beams are between two arcs and two angles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureFan {
    /// Lateral position of the apex, m, in the coordinates of the picture.
    pub x: f64,
    /// Depth of the apex, m, often above the picture.
    pub z: f64,
    /// Distances from the apex at which the beams begin and end, m.
    pub radii: [f64; 2],
    /// Angles of the first and the last beam, rad.
    ///
    /// Angles count from the z axis and are positive towards positive x.
    pub angles: [f64; 2],
}

/// Largest grey level that counts as black, of 255.
///
/// Compression leaves some grey beside letters and edges.
const BLACK: f32 = 8.0;
/// Side of the blocks in which connected parts are found, pixels.
///
/// Smaller gaps do not split the picture.
const BLOCK: usize = 4;
/// Largest deviation of a side from a straight line, pixels.
const STRAIGHT: f64 = 1.5;
/// Smallest height of a side of a fan, as a share of the picture's height.
const LEAST_SIDE: f64 = 0.25;
/// Smallest and largest angle between the sides, rad.
const TURNS: [f64; 2] = [0.15, 3.0];

impl PictureFan {
    /// The fan in pixels from the centre of the top left one; `None` if there is none.
    ///
    /// The largest connected part that is not black is the picture. The convex hull of a fan has two straight sides that
    /// meet above it. The arcs are at the distances at which most beams begin and end.
    pub(super) fn of(pixels: ArrayView2<f32>) -> Option<Self> {
        let lit = largest_part(pixels);
        let rows = lit.outer_iter().enumerate().filter_map(|(row, levels)| {
            let first = levels.iter().position(|&lit| lit)?;
            let last = levels.iter().rposition(|&lit| lit)?;
            Some([row as f64, first as f64, last as f64])
        });
        let rows: Vec<[f64; 3]> = rows.collect();
        let height = rows.last()?[0] - rows[0][0];
        let left = Side::of(rows.iter().map(|[z, first, _]| [*z, *first]))?;
        // Mirrored, the right side is a left one.
        let right = Side::of(rows.iter().map(|[z, _, last]| [*z, -last]))?;
        let turn = right.slope.atan() + left.slope.atan();
        let long = left.height.min(right.height) >= LEAST_SIDE * height;
        if !long || !(TURNS[0]..=TURNS[1]).contains(&-turn) {
            return None;
        }
        // x = a + b·z on the left, x = −(c + d·z) on the right.
        let z = -(left.at_0 + right.at_0) / (left.slope + right.slope);
        let x = left.at_0 + left.slope * z;
        let angles = [left.slope.atan(), -right.slope.atan()];
        let radii = radii(&lit, [x, z], angles)?;
        Some(Self {
            x,
            z,
            radii,
            angles,
        })
    }

    /// The fan for pixels of side `pixel`, the first of them at (x0, z0), m.
    pub(super) fn placed(self, pixel: f64, [x0, z0]: [f64; 2]) -> Self {
        Self {
            x: x0 + pixel * self.x,
            z: z0 + pixel * self.z,
            radii: self.radii.map(|radius| pixel * radius),
            angles: self.angles,
        }
    }

    /// The position at a distance from the apex and an angle, m.
    pub fn at(&self, radius: f64, angle: f64) -> [f64; 2] {
        [self.x + radius * angle.sin(), self.z + radius * angle.cos()]
    }
}

/// A straight left side: x = `at_0` + `slope`·z, pixels.
struct Side {
    at_0: f64,
    slope: f64,
    height: f64,
}

impl Side {
    /// The longest straight part of the hull of points (z, x) of ascending z.
    fn of(points: impl Iterator<Item = [f64; 2]>) -> Option<Self> {
        let points: Vec<[f64; 2]> = points.collect();
        let hull = hull(&points);
        let mut best: Option<[[f64; 2]; 2]> = None;
        let length = |[a, b]: [[f64; 2]; 2]| (b[0] - a[0]).hypot(b[1] - a[1]);
        for (i, &a) in hull.iter().enumerate() {
            for (j, &b) in hull.iter().enumerate().skip(i + 1) {
                let away = |p: &[f64; 2]| {
                    let cross = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
                    cross.abs() / length([a, b]).max(1.0)
                };
                if hull[i..=j].iter().any(|p| away(p) > STRAIGHT) {
                    break;
                }
                if best.is_none_or(|best| length([a, b]) > length(best)) {
                    best = Some([a, b]);
                }
            }
        }
        let [a, b] = best.filter(|[a, b]| b[0] > a[0])?;
        let slope = (b[1] - a[1]) / (b[0] - a[0]);
        // Over all rows that reach the side, by least squares.
        let near = points.iter().filter(|p| {
            let inside = (a[0]..=b[0]).contains(&p[0]);
            inside && (p[1] - a[1] - slope * (p[0] - a[0])).abs() <= 2.0 * STRAIGHT
        });
        let near: Vec<&[f64; 2]> = near.collect();
        let count = near.len() as f64;
        let [mean_z, mean_x] = [0, 1].map(|k| near.iter().map(|p| p[k]).sum::<f64>() / count);
        let spread: f64 = near.iter().map(|p| (p[0] - mean_z).powi(2)).sum();
        let product = |p: &&[f64; 2]| (p[0] - mean_z) * (p[1] - mean_x);
        let slope = near.iter().map(product).sum::<f64>() / spread;
        slope.is_finite().then(|| Self {
            at_0: mean_x - slope * mean_z,
            slope,
            height: b[0] - a[0],
        })
    }
}

/// The lower convex hull of points of ascending first coordinate.
fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut hull: Vec<[f64; 2]> = Vec::new();
    for &p in points {
        while let [.., a, b] = hull[..] {
            let cross = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
            if cross > 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(p);
    }
    hull
}

/// The largest connected part that is not black, without letters and rulers.
fn largest_part(pixels: ArrayView2<f32>) -> Array2<bool> {
    let (rows, columns) = pixels.dim();
    let mut blocks = Array2::from_elem((rows.div_ceil(BLOCK), columns.div_ceil(BLOCK)), 0usize);
    for ((row, column), level) in pixels.indexed_iter() {
        if *level > BLACK {
            blocks[[row / BLOCK, column / BLOCK]] = usize::MAX;
        }
    }
    let mut sizes = vec![0];
    let starts: Vec<[usize; 2]> = blocks.indexed_iter().map(|((a, b), _)| [a, b]).collect();
    for start in starts {
        if blocks[start] != usize::MAX {
            continue;
        }
        let name = sizes.len();
        let mut size = 0;
        blocks[start] = name;
        let mut left = VecDeque::from([start]);
        while let Some([row, column]) = left.pop_front() {
            size += 1;
            for beside in (row.saturating_sub(1)..=row + 1)
                .flat_map(|r| (column.saturating_sub(1)..=column + 1).map(move |c| [r, c]))
            {
                if blocks.get(beside) == Some(&usize::MAX) {
                    blocks[beside] = name;
                    left.push_back(beside);
                }
            }
        }
        sizes.push(size);
    }
    let largest = (1..sizes.len()).max_by_key(|&name| sizes[name]);
    Array2::from_shape_fn((rows, columns), |(row, column)| {
        let name = blocks[[row / BLOCK, column / BLOCK]];
        pixels[[row, column]] > BLACK && Some(name) == largest
    })
}

/// Number of bins of the angle in which the arcs are sought.
const BINS: usize = 128;

/// The radii at which most beams begin, and at which the longest end.
fn radii(lit: &Array2<bool>, [x, z]: [f64; 2], angles: [f64; 2]) -> Option<[f64; 2]> {
    let mut ends = vec![[f64::INFINITY, 0.0]; BINS];
    for ((row, column), _) in lit.indexed_iter().filter(|(_, lit)| **lit) {
        let (u, v) = (column as f64 - x, row as f64 - z);
        let fraction = (u.atan2(v) - angles[0]) / (angles[1] - angles[0]);
        if (0.0..1.0).contains(&fraction) {
            let [nearest, farthest] = &mut ends[(fraction * BINS as f64) as usize];
            let radius = u.hypot(v);
            (*nearest, *farthest) = (nearest.min(radius), farthest.max(radius));
        }
    }
    ends.retain(|[nearest, _]| nearest.is_finite());
    let nth = |k: usize, fraction: f64| {
        let mut sorted: Vec<f64> = ends.iter().map(|ends| ends[k]).collect();
        sorted.sort_by(f64::total_cmp);
        sorted
            .get((fraction * sorted.len() as f64) as usize)
            .copied()
    };
    // Dark tissue begins later and ends earlier; in a picture that is cut below, slanted beams end later.
    let radii = [nth(0, 0.2)?, nth(1, 0.95)?];
    (radii[1] > radii[0]).then_some(radii)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fan of even speckle, with a shadow in it and letters beside it.
    fn drawn(fan: &PictureFan, rows: usize, columns: usize) -> Array2<f32> {
        Array2::from_shape_fn((rows, columns), |(row, column)| {
            let (u, v) = (column as f64 - fan.x, row as f64 - fan.z);
            let (radius, angle) = (u.hypot(v), u.atan2(v));
            let inside = (fan.radii[0]..=fan.radii[1]).contains(&radius)
                && (fan.angles[0]..=fan.angles[1]).contains(&angle);
            let letters = (4..14).contains(&row) && (4..40).contains(&column) && column % 3 > 0;
            let shadow = (0.05..0.2).contains(&angle) && radius > fan.radii[0] + 80.0;
            // Every fifth pixel or so is black.
            let speckle = (row * 7919 + column * 104_729) % 1009 % 5;
            match (inside, letters) {
                (true, _) if shadow => 0.0,
                (true, _) => 40.0 * speckle as f32,
                (false, true) => 255.0,
                _ => 0.0,
            }
        })
    }

    #[test]
    fn fans_of_curved_arrays_and_sectors_are_found() {
        for fan in [
            // Curved, cut below; a sector from a point; aslant.
            PictureFan {
                x: 300.0,
                z: -200.0,
                radii: [260.0, 720.0],
                angles: [-0.5, 0.5],
            },
            PictureFan {
                x: 300.0,
                z: 20.0,
                radii: [0.0, 400.0],
                angles: [-0.7, 0.7],
            },
            PictureFan {
                x: 180.0,
                z: -100.0,
                radii: [150.0, 560.0],
                angles: [-0.2, 0.6],
            },
        ] {
            let found = PictureFan::of(drawn(&fan, 480, 620).view()).unwrap();
            let off = (found.x - fan.x).hypot(found.z - fan.z);
            assert!(off < 6.0, "{found:?}");
            for k in 0..2 {
                assert!((found.angles[k] - fan.angles[k]).abs() < 0.01, "{found:?}");
            }
            assert!((found.radii[0] - fan.radii[0]).abs() < 8.0, "{found:?}");
            assert!((found.radii[1] - fan.radii[1]).abs() < 10.0, "{found:?}");
        }
    }

    #[test]
    fn a_rectangle_is_none() {
        let picture = |dark: &dyn Fn(usize, usize) -> bool| {
            Array2::from_shape_fn((400, 500), |(row, column)| {
                let inside = (20..380).contains(&row) && (100..400).contains(&column);
                let speckle = (row * 7919 + column * 104_729) % 1009 % 5;
                match inside && !dark(row, column) {
                    true => 40.0 * speckle as f32,
                    false => 0.0,
                }
            })
        };
        assert_eq!(PictureFan::of(picture(&|_, _| false).view()), None);
        // Hardly wider below.
        let wider = |row: usize, column: usize| column.abs_diff(250) > 140 + row / 50;
        assert_eq!(PictureFan::of(picture(&wider).view()), None);
        // Shadows at both sides, which leave a funnel.
        let funnel = |row: usize, column: usize| column.abs_diff(250) > 150 - row / 4;
        assert_eq!(PictureFan::of(picture(&funnel).view()), None);
        assert_eq!(PictureFan::of(picture(&|_, _| true).view()), None);
        assert_eq!(PictureFan::of(Array2::zeros((0, 0)).view()), None);
    }
}
