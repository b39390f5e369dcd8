//! The mesh of a sweep: triangles between the surfaces of neighbouring frames.

use super::SurfacePoint;

/// Largest slope in elevation that a triangle spans: depth over distance between frames.
const STEEPEST: f64 = 2.0;
/// Change in depth that any distance between frames allows, m: errors of two points.
const ERRORS: f64 = 0.3e-3;

/// Triangles between the points of neighbouring frames, as indices of all points.
///
/// `lines` is the number of lines of each frame and `step` the distance between frames, m. Two neighbouring lines in
/// two neighbouring frames make a quadrilateral. A side is valid within a frame if both points belong to one piece, and
/// between frames if the change in depth is at most twice the distance of the frames plus 0.3 mm. Four valid sides give
/// two triangles, split along the diagonal with the smaller change in depth. If one point is missing and the two sides
/// without it are valid, they give one triangle. Triangles are anticlockwise as seen from the array.
pub fn triangles(frames: &[&[SurfacePoint]], lines: usize, step: f64) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    let mut first = 0;
    let by_line = |points: &[SurfacePoint], first: usize| {
        let mut by_line = vec![None; lines];
        for (k, point) in points.iter().enumerate() {
            if let Some(slot) = by_line.get_mut(point.line) {
                *slot = Some((first + k, *point));
            }
        }
        by_line
    };
    for pair in frames.windows(2) {
        let next = first + pair[0].len();
        let [near, far] = [by_line(pair[0], first), by_line(pair[1], next)];
        for (near, far) in near.windows(2).zip(far.windows(2)) {
            triangles.extend(of_cell([near[0], far[0], far[1], near[1]], step));
        }
        first = next;
    }
    triangles
}

/// The triangles of a quadrilateral, whose corners are in order; its sides 0 and 2 join frames.
fn of_cell(corners: [Option<(usize, SurfacePoint)>; 4], step: f64) -> Vec<[usize; 3]> {
    let missing = corners.iter().filter(|corner| corner.is_none()).count();
    let joined = |side: usize| match (corners[side], corners[(side + 1) % 4]) {
        (Some((_, a)), Some((_, b))) if [0, 2].contains(&side) => {
            (a.x - b.x).hypot(a.z - b.z) <= STEEPEST * step + ERRORS
        }
        (Some((_, a)), Some((_, b))) => a.piece == b.piece,
        _ => false,
    };
    // The triangle of a corner and both its neighbours, if both sides are joined.
    let around = |corner: usize| {
        let of = |k: usize| corners[k % 4].map(|(index, _)| index);
        let both = joined((corner + 3) % 4) && joined(corner);
        let triangle = [of(corner + 3)?, of(corner)?, of(corner + 1)?];
        both.then_some(triangle)
    };
    match (missing, corners) {
        (0, [Some((_, a)), Some((_, b)), Some((_, c)), Some((_, d))]) if (0..4).all(joined) => {
            let odd = (a.z - c.z).abs() <= (b.z - d.z).abs();
            let pair = if odd { [1, 3] } else { [0, 2] };
            pair.into_iter().filter_map(around).collect()
        }
        (1, _) => (0..4).find_map(around).into_iter().collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame with points at depths in mm, one a line; pieces begin at the lines of `begins`.
    fn frame(depths: &[Option<f64>], begins: &[usize]) -> Vec<SurfacePoint> {
        let points = depths.iter().enumerate().filter_map(|(line, depth)| {
            Some(SurfacePoint {
                line,
                x: 0.3e-3 * line as f64,
                z: 1e-3 * (*depth)?,
                confidence: 1.0,
                piece: begins.iter().filter(|begin| **begin <= line).count(),
            })
        });
        points.collect()
    }

    const STEP: f64 = 0.5e-3;

    #[test]
    fn a_continuous_surface_is_covered_once_and_faces_the_array() {
        let frames: Vec<_> = (0..4)
            .map(|k| {
                let depth = |line: usize| Some(20.0 + 0.2 * line as f64 + 0.3 * k as f64);
                frame(&[0, 1, 2, 3, 4].map(depth), &[])
            })
            .collect();
        let frames: Vec<&[SurfacePoint]> = frames.iter().map(|points| &points[..]).collect();
        let triangles = triangles(&frames, 5, STEP);
        assert_eq!(triangles.len(), 2 * 3 * 4);
        let at = |index: usize| {
            let (frame, line) = (index / 5, index % 5);
            [frames[frame][line].x, STEP * frame as f64]
        };
        // Twice the signed area in x and y: negative if anticlockwise as seen along −z, from the array.
        let areas = triangles.iter().map(|t| {
            let [a, b, c] = t.map(at);
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        });
        let whole = 2.0 * (4.0 * 0.3e-3) * (3.0 * STEP);
        assert!((areas.clone().sum::<f64>() + whole).abs() < 1e-12);
        assert!(areas.into_iter().all(|area| area < 0.0));
    }

    #[test]
    fn no_triangle_spans_a_jump_or_a_hole() {
        let flat = [Some(20.0); 4];
        let of = |next: [Option<f64>; 4], begins: &[usize]| {
            triangles(&[&frame(&flat, &[]), &frame(&next, begins)], 4, STEP)
        };
        assert_eq!(of(flat, &[]).len(), 6);
        // The limit at 0.5 mm between frames is 1.3 mm.
        assert_eq!(of([Some(21.29); 4], &[]).len(), 6);
        assert_eq!(of([Some(21.31); 4], &[]).len(), 0);
        // A piece that begins at line 2, and a point in line 2 that is too deep, end the mesh beside them.
        assert_eq!(of(flat, &[2]).len(), 4);
        assert_eq!(of([flat[0], flat[1], Some(22.0), flat[3]], &[]).len(), 2);
        // Beside a missing point there is half of each quadrilateral.
        let hole = of([flat[0], flat[1], None, flat[3]], &[]);
        assert_eq!(hole.len(), 4);
        assert_eq!(hole[2..], [[2, 1, 5], [6, 3, 2]]);
        assert!(of([None; 4], &[]).is_empty());
        assert!(of([flat[0], None, None, flat[3]], &[]).len() == 2);
    }

    #[test]
    fn the_diagonal_has_the_smaller_change_in_depth() {
        let pair = |far: [Option<f64>; 2]| {
            let near = frame(&[Some(20.0), Some(20.6)], &[]);
            triangles(&[&near, &frame(&far, &[])], 2, STEP)
        };
        // Points 0 and 1 are in the first frame, 2 and 3 in the second.
        assert!(
            pair([Some(20.6), Some(21.2)])
                .iter()
                .all(|t| t.contains(&1) && t.contains(&2))
        );
        assert!(
            pair([Some(19.4), Some(20.0)])
                .iter()
                .all(|t| t.contains(&0) && t.contains(&3))
        );
    }
}
