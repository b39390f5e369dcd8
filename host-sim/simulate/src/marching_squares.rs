//! Contours of a function on a plane (marching squares).

use rayon::prelude::*;

use super::chain::{Point, Segment};

/// The rectangle to search for contours, and its grid.
pub struct PlaneGrid {
    /// The corner with the smallest coordinates, m.
    pub corner: Point,
    /// Distance between nodes, m.
    pub step: f64,
    /// Nodes along both axes.
    pub nodes: [usize; 2],
}

impl PlaneGrid {
    fn point(&self, i: usize, j: usize) -> Point {
        [
            self.corner[0] + i as f64 * self.step,
            self.corner[1] + j as f64 * self.step,
        ]
    }
}

/// Segments of the curve f = 0, linear within each cell.
///
/// If a cell's corners alternate in sign, the mean of the four decides which of them are connected.
pub fn contour(grid: &PlaneGrid, f: impl Fn(Point) -> f64 + Sync) -> Vec<Segment> {
    let [columns, rows] = grid.nodes;
    let values: Vec<f64> = (0..columns * rows)
        .into_par_iter()
        .map(|k| f(grid.point(k % columns, k / columns)))
        .collect();
    let node = |i: usize, j: usize| j * columns + i;
    let mut segments = Vec::new();
    for j in 0..rows - 1 {
        for i in 0..columns - 1 {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let value = corners.map(|(i, j)| values[node(i, j)]);
            let inside = value.map(|v| v < 0.0);
            let mut crossings = Vec::with_capacity(4);
            for k in 0..4 {
                let next = (k + 1) % 4;
                if inside[k] == inside[next] {
                    continue;
                }
                let (a, b) = (grid.point(corners[k].0, corners[k].1), corners[next]);
                let b = grid.point(b.0, b.1);
                let w = value[k] / (value[k] - value[next]);
                let ends = [
                    node(corners[k].0, corners[k].1),
                    node(corners[next].0, corners[next].1),
                ];
                let edge = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                crossings.push((edge, [a[0] + w * (b[0] - a[0]), a[1] + w * (b[1] - a[1])]));
            }
            let mut join = |p: usize, q: usize| {
                segments.push(Segment {
                    edges: [crossings[p].0, crossings[q].0],
                    ends: [crossings[p].1, crossings[q].1],
                });
            };
            match crossings.len() {
                2 => join(0, 1),
                4 => {
                    // Crossing k lies on the edge from corner k to k + 1. Corner 0 is cut off
                    // where its sign differs from the middle's.
                    let middle_inside = value.iter().sum::<f64>() < 0.0;
                    if inside[0] == middle_inside {
                        join(0, 1);
                        join(2, 3);
                    } else {
                        join(3, 0);
                        join(1, 2);
                    }
                }
                _ => {}
            }
        }
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::super::chain::closed_loops;
    use super::*;

    /// Two circles that nearly touch, and a hole: three loops with the circles' lengths. A chord
    /// of the step s falls short of the arc of radius r by (s/r)²/24 of its length, 4e-5 here.
    #[test]
    fn circles_give_closed_loops_of_their_length() {
        let grid = PlaneGrid {
            corner: [-3.0, -3.0],
            step: 0.03,
            nodes: [301, 201],
        };
        let circle = |p: Point, x: f64, r: f64| (p[0] - x).hypot(p[1]) - r;
        let f = |p: Point| {
            circle(p, 0.0, 2.0)
                .min(circle(p, 3.07, 1.0))
                .max(-circle(p, 0.0, 1.0))
        };
        let loops = closed_loops(&contour(&grid, f)).unwrap();
        let mut lengths: Vec<f64> = loops
            .iter()
            .map(|points| {
                (0..points.len())
                    .map(|k| {
                        let (a, b) = (points[k], points[(k + 1) % points.len()]);
                        (a[0] - b[0]).hypot(a[1] - b[1])
                    })
                    .sum()
            })
            .collect();
        lengths.sort_by(f64::total_cmp);
        let tau = std::f64::consts::TAU;
        assert_eq!(lengths.len(), 3);
        for (length, expected) in lengths.iter().zip([tau, tau, 2.0 * tau]) {
            assert!(
                (length - expected).abs() < 1e-3 * expected,
                "{length} {expected}"
            );
        }
    }
}
