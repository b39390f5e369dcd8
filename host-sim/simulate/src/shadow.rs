//! Visibility of scatterers for elements, past bone that absorbs all sound.
//!
//! The straight lines from a point to the elements are in one plane, which contains the elements' axis. That plane
//! cuts a surface in segments. Each segment between the point and the axis hides the elements within its projection
//! from the point. So visibility is exact, and its cost does not depend on the number of elements.

use super::chain::Point;
use super::outline::Outline;
use super::scatterer::PointSource;
use super::surface::Surface;

/// Height above a point below which nothing hides it, m.
///
/// Otherwise the surface would hide the scatterers on it.
const TOLERANCE: f64 = 5e-6;

/// Sectors of the planes through the elements' axis, to find triangles.
const SECTORS: usize = 2048;

/// Objects that cast shadows.
pub enum Shadow {
    /// Nothing.
    None,
    /// A surface that is the same at every elevation: its segments by least depth.
    Segments(Vec<[Point; 2]>),
    Triangles(Sectors),
}

impl Shadow {
    /// The shadow of an outline in the image plane.
    pub fn of_outline(outline: &Outline) -> Self {
        let mut segments: Vec<[Point; 2]> = outline.segments().collect();
        let top = |s: &[Point; 2]| s[0][1].min(s[1][1]);
        segments.sort_by(|a, b| top(a).total_cmp(&top(b)));
        Shadow::Segments(segments)
    }

    /// The shadow of a surface of triangles.
    pub fn of_surface(surface: &Surface) -> Self {
        Shadow::Triangles(Sectors::new(surface))
    }

    /// Sets the bits of the elements that see the source, and clears the others.
    ///
    /// Elements are at ascending x.
    pub fn seen(&self, source: &PointSource, element_x: &[f64], seen: &mut [u64]) {
        set(seen, 0, element_x.len());
        if source.unhidden {
            return;
        }
        let [x, y, z] = source.seen_at;
        match self {
            Shadow::None => {}
            Shadow::Segments(segments) => {
                for segment in segments {
                    if segment[0][1].min(segment[1][1]) >= z - TOLERANCE {
                        break;
                    }
                    hide(*segment, [x, z], TOLERANCE, element_x, seen);
                }
            }
            Shadow::Triangles(sectors) => {
                let slope = y / z;
                // Depth stands for the distance from the axis, which is longer by √(1 + slope²).
                let tolerance = TOLERANCE / (1.0 + slope * slope).sqrt();
                // The shallowest first: what lies below the point hides nothing, nor does anything once no
                // element is left.
                for triangle in sectors.at(slope) {
                    if top(triangle) >= z {
                        break;
                    }
                    if let Some(segment) = cut(triangle, slope) {
                        hide(segment, [x, z], tolerance, element_x, seen);
                        if seen.iter().all(|&word| word == 0) {
                            break;
                        }
                    }
                }
            }
        }
    }
}

/// Visibility `[element][point]` past an outline.
///
/// A point is visible if the straight line from the element (on z = 0) crosses no segment of the outline more than
/// 5 µm above the point. All of the outline is at z > 0.
pub fn visible(outline: &Outline, element_x: &[f64], points: &[Point]) -> Vec<Vec<bool>> {
    let shadow = Shadow::of_outline(outline);
    let mut all = vec![vec![false; points.len()]; element_x.len()];
    let mut seen = vec![0u64; element_x.len().div_ceil(64)];
    for (k, &[x, z]) in points.iter().enumerate() {
        shadow.seen(&PointSource::at([x, 0.0, z], 1.0), element_x, &mut seen);
        for (element, row) in all.iter_mut().enumerate() {
            row[k] = seen[element / 64] >> (element % 64) & 1 == 1;
        }
    }
    all
}

/// Triangles by the slopes y/z of the planes that cut them.
pub struct Sectors {
    lowest: f64,
    width: f64,
    /// Triangles, the shallowest first.
    triangles: Vec<[[f64; 3]; 3]>,
    sectors: Vec<Vec<u32>>,
}

impl Sectors {
    fn new(surface: &Surface) -> Self {
        let mut triangles: Vec<[[f64; 3]; 3]> = surface.corners().collect();
        triangles.sort_by(|a, b| top(a).total_cmp(&top(b)));
        let slopes = |t: &[[f64; 3]; 3]| {
            let s = t.map(|[_, y, z]| y / z);
            [s[0].min(s[1]).min(s[2]), s[0].max(s[1]).max(s[2])]
        };
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        for [low, high] in triangles.iter().map(slopes) {
            lowest = lowest.min(low);
            highest = highest.max(high);
        }
        let mut found = Sectors {
            lowest,
            width: ((highest - lowest) / SECTORS as f64).max(f64::MIN_POSITIVE),
            triangles: Vec::new(),
            sectors: vec![Vec::new(); SECTORS],
        };
        for (index, [low, high]) in triangles.iter().map(slopes).enumerate() {
            for sector in found.sector(low)..=found.sector(high) {
                found.sectors[sector].push(index as u32);
            }
        }
        found.triangles = triangles;
        found
    }

    fn sector(&self, slope: f64) -> usize {
        // A cast of a negative value is 0.
        (((slope - self.lowest) / self.width) as usize).min(SECTORS - 1)
    }

    fn at(&self, slope: f64) -> impl Iterator<Item = &[[f64; 3]; 3]> {
        let found = &self.sectors[self.sector(slope)];
        found.iter().map(|&index| &self.triangles[index as usize])
    }
}

/// Least depth of a triangle.
fn top([a, b, c]: &[[f64; 3]; 3]) -> f64 {
    a[2].min(b[2]).min(c[2])
}

/// Segment in which the plane y = slope·z cuts a triangle: x and z of both ends.
fn cut(triangle: &[[f64; 3]; 3], slope: f64) -> Option<[Point; 2]> {
    let side = triangle.map(|[_, y, z]| y - slope * z);
    let mut ends = [[0.0; 2]; 2];
    let mut count = 0;
    for k in 0..3 {
        // A corner on the plane counts as above it, so that every edge is cut or not, alike for the
        // triangles that share it.
        let [a, b] = [k, (k + 1) % 3];
        if (side[a] >= 0.0) != (side[b] >= 0.0) && count < 2 {
            let w = side[a] / (side[a] - side[b]);
            let at = |axis: usize| triangle[a][axis] + w * (triangle[b][axis] - triangle[a][axis]);
            ends[count] = [at(0), at(2)];
            count += 1;
        }
    }
    (count == 2).then_some(ends)
}

/// Clears the bits of the elements that a segment above the point hides.
fn hide([mut a, mut b]: [Point; 2], p: Point, tolerance: f64, element_x: &[f64], seen: &mut [u64]) {
    let limit = p[1] - tolerance;
    if a[1] > b[1] {
        (a, b) = (b, a);
    }
    if a[1] >= limit {
        return;
    }
    if b[1] > limit {
        let w = (limit - a[1]) / (b[1] - a[1]);
        b = [a[0] + w * (b[0] - a[0]), limit];
    }
    let project = |q: Point| p[0] + (q[0] - p[0]) * p[1] / (p[1] - q[1]);
    let (from, to) = (project(a), project(b));
    let (from, to) = (from.min(to), from.max(to));
    let first = element_x.partition_point(|&x| x < from);
    let end = element_x.partition_point(|&x| x < to);
    clear(seen, first, end);
}

fn words(first: usize, end: usize) -> impl Iterator<Item = (usize, u64)> {
    (first / 64..end.div_ceil(64)).map(move |word| {
        let low = first.saturating_sub(64 * word).min(64);
        let high = (end - 64 * word).min(64);
        let ones = |n: usize| if n == 64 { u64::MAX } else { (1 << n) - 1 };
        (word, ones(high) & !ones(low))
    })
}

fn set(bits: &mut [u64], first: usize, end: usize) {
    for (word, mask) in words(first, end) {
        bits[word] |= mask;
    }
}

fn clear(bits: &mut [u64], first: usize, end: usize) {
    if first < end {
        for (word, mask) in words(first, end) {
            bits[word] &= !mask;
        }
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

    #[test]
    fn bits_of_ranges_across_words() {
        for (first, end) in [(0, 0), (0, 64), (3, 64), (60, 70), (64, 128), (1, 129)] {
            let mut bits = [0u64; 3];
            set(&mut bits, first, end);
            for k in 0..192 {
                let found = bits[k / 64] >> (k % 64) & 1 == 1;
                assert_eq!(found, (first..end).contains(&k), "{first} {end}: {k}");
            }
            clear(&mut bits, first, end);
            assert_eq!(bits, [0; 3]);
        }
    }
}
