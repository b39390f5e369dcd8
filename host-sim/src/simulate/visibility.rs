//! Which elements see which scatterers past totally absorbing bone.

use rayon::prelude::*;

use super::chain::Point;
use super::outline::Outline;

/// A crossing nearer to the scatterer than this does not hide it: a scatterer on the surface
/// lies on the segment that it would cross. m.
const TOLERANCE: f64 = 5e-6;

/// Bins of the slope dx/dz as seen from an element.
const BINS: usize = 2048;

/// Visibility `[element][point]`: true when the straight line from the element (on z = 0) to the
/// point crosses no segment of the outline. Exact but for the tolerance of 5 µm at the point.
/// All of the outline lies at z > 0.
pub fn visible(outline: &Outline, element_x: &[f64], points: &[Point]) -> Vec<Vec<bool>> {
    let segments: Vec<[Point; 2]> = outline.segments().collect();
    element_x
        .par_iter()
        .map(|&x| {
            let view = View::new(x, &segments);
            points.iter().map(|&p| view.sees(p)).collect()
        })
        .collect()
}

/// The segments as one element sees them, sorted into bins of slope.
struct View<'a> {
    x: f64,
    lowest: f64,
    width: f64,
    bins: Vec<Vec<&'a [Point; 2]>>,
}

impl<'a> View<'a> {
    fn new(x: f64, segments: &'a [[Point; 2]]) -> Self {
        let slope = |p: &Point| (p[0] - x) / p[1];
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in segments.iter().flatten() {
            lowest = lowest.min(slope(p));
            highest = highest.max(slope(p));
        }
        let width = ((highest - lowest) / BINS as f64).max(f64::MIN_POSITIVE);
        let mut view = View {
            x,
            lowest,
            width,
            bins: vec![Vec::new(); BINS],
        };
        for segment in segments {
            let (a, b) = (view.bin(slope(&segment[0])), view.bin(slope(&segment[1])));
            for bin in a.min(b)..=a.max(b) {
                view.bins[bin].push(segment);
            }
        }
        view
    }

    fn bin(&self, slope: f64) -> usize {
        // A cast of a negative value is 0.
        (((slope - self.lowest) / self.width) as usize).min(BINS - 1)
    }

    fn sees(&self, p: Point) -> bool {
        let ray = [p[0] - self.x, p[1]];
        let reach = 1.0 - TOLERANCE / ray[0].hypot(ray[1]);
        !self.bins[self.bin(ray[0] / ray[1])].iter().any(|[a, b]| {
            let side = |q: &Point| ray[0] * q[1] - ray[1] * (q[0] - self.x);
            let (sa, sb) = (side(a), side(b));
            if (sa > 0.0) == (sb > 0.0) {
                return false;
            }
            // The crossing as a fraction of the ray, by its longer, never vanishing depth.
            let w = sa / (sa - sb);
            let z = a[1] + w * (b[1] - a[1]);
            z < reach * ray[1]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square from (−1, 10) to (1, 12): the shadow's edges are straight lines through its
    /// corners.
    #[test]
    fn a_square_hides_what_lies_behind_it() {
        let square = vec![[-1.0, 10.0], [1.0, 10.0], [1.0, 12.0], [-1.0, 12.0]];
        let outline = Outline::new(vec![square]).unwrap();
        let points = [
            [0.0, 9.0],
            [0.0, 10.0],
            [0.0, 12.0],
            [0.0, 20.0],
            [1.9, 20.0],
            [2.1, 20.0],
            [1.0, 11.0],
            [50.0, 20.0],
        ];
        let seen = visible(&outline, &[0.0, 5.0], &points);
        // From x = 0 the corner (1, 10) shadows up to x = 2 at z = 20, and the side x = 1.
        assert_eq!(
            seen[0],
            [true, true, false, false, false, true, false, true]
        );
        // From x = 5 the right side is lit, and at z = 20 the corners (1, 12) and (−1, 10)
        // shadow x = −7 to −1.67.
        assert_eq!(seen[1], [true, true, false, true, true, true, true, true]);
    }
}
