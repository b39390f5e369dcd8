//! A picture of the bone from three sides, with the points in colours.

use ndarray::Array2;

use crate::algebra::{V3, add, unit};
use crate::bone::Bone;
use crate::residuals::quantile;

/// Side of a view, pixels.
const SIDE: usize = 480;
/// Bone shown around the points, mm.
const AROUND: f64 = 15.0;
/// Points this far behind the surface are still drawn, mm.
const BEHIND: f64 = 3.0;
/// Distance at which the colour is full red, mm.
const RED: f64 = crate::BAR;

/// The colour of a distance; grey without a counterpart.
///
/// Green at 0, yellow at 1 mm, red from 2 mm on.
pub fn colour(distance: f64) -> [u8; 3] {
    if distance.is_nan() {
        return [110; 3];
    }
    let share = (distance.abs() / RED).min(1.0);
    let level = |v: f64| (255.0 * v.clamp(0.0, 1.0) + 0.5) as u8;
    [level(2.0 * share), level(0.85 * (2.0 - 2.0 * share)), 0]
}

/// Three views side by side: along x, y and z.
///
/// Each is from the side to which `towards` points. `points` are in the bone's coordinates, and `signed` are their distances, mm.
pub fn picture(bone: &Bone, points: &[V3], signed: &[f64], towards: V3) -> Array2<[u8; 3]> {
    let mut picture = Array2::from_elem((SIDE, 3 * SIDE), [255; 3]);
    // Some far points do not set the frame.
    let range = |axis: usize| {
        let mut values: Vec<f64> = points.iter().map(|p| p[axis]).collect();
        values.sort_by(f64::total_cmp);
        [quantile(&values, 0.01), quantile(&values, 0.99)]
    };
    let ranges = [range(0), range(1), range(2)];
    let longest = ranges
        .iter()
        .map(|[low, high]| high - low)
        .fold(0.0, f64::max);
    let pixel = (longest + 2.0 * AROUND) / SIDE as f64;
    let centre = ranges.map(|[low, high]| 0.5 * (low + high));
    let light = unit(add(towards, [0.3, 0.2, 0.4]));
    for view in 0..3 {
        let nearer = if towards[view] < 0.0 { -1.0 } else { 1.0 };
        let [across, up] = [[1, 2], [0, 2], [0, 1]][view];
        // Column, row and nearness.
        let place = |p: V3| {
            let at = |axis: usize| (p[axis] - centre[axis]) / pixel;
            let half = SIDE as f64 / 2.0;
            let row = if view == 2 {
                half + at(up)
            } else {
                half - at(up)
            };
            [half + at(across), row, nearer * p[view]]
        };
        let mut depths = Array2::from_elem((SIDE, SIDE), f64::NEG_INFINITY);
        for triangle in 0..bone.surface().triangles().len() {
            let lit: f64 = (0..3).map(|k| light[k] * bone.normal(triangle)[k]).sum();
            let level = (165.0 + 70.0 * lit.clamp(-1.0, 1.0)) as u8;
            fill(bone.corners(triangle).map(place), |row, column, depth| {
                if depth > depths[[row, column]] {
                    depths[[row, column]] = depth;
                    picture[[row, view * SIDE + column]] = [level; 3];
                }
            });
        }
        for (point, distance) in points.iter().zip(signed) {
            let [x, y, depth] = place(*point);
            for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                let [column, row] = [x + dx, y + dy];
                let inside = |v: f64| v >= 0.0 && v < SIDE as f64;
                if !inside(column) || !inside(row) {
                    continue;
                }
                let [row, column] = [row as usize, column as usize];
                if depth > depths[[row, column]] - BEHIND {
                    picture[[row, view * SIDE + column]] = colour(*distance);
                }
            }
        }
    }
    picture
}

/// Calls `put` with row, column and nearness of the pixels whose centres a triangle covers.
fn fill([a, b, c]: [V3; 3], mut put: impl FnMut(usize, usize, f64)) {
    let edge = |from: V3, to: V3, x: f64, y: f64| {
        (to[0] - from[0]) * (y - from[1]) - (to[1] - from[1]) * (x - from[0])
    };
    let area = edge(a, b, c[0], c[1]);
    if area == 0.0 {
        return;
    }
    let limits = |axis: usize| {
        let values = [a[axis], b[axis], c[axis]];
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        // The casts saturate.
        (low as usize)..(high.ceil().max(0.0) as usize).saturating_add(1).min(SIDE)
    };
    for row in limits(1) {
        for column in limits(0) {
            let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
            let shares = [edge(b, c, x, y), edge(c, a, x, y), edge(a, b, x, y)].map(|v| v / area);
            if shares.iter().all(|share| *share >= 0.0) {
                let depths = [a, b, c].map(|corner| corner[2]);
                put(row, column, (0..3).map(|k| shares[k] * depths[k]).sum());
            }
        }
    }
}
