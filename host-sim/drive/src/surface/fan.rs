//! The fan of a picture of a curved array or a sector, found by its black corners.

use super::lit::Lit;
use ndarray::{Array2, ArrayView2, Axis};
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

/// Blocks to the middle of letters that touch the picture.
const LETTERS: usize = 2;
/// Largest deviation of a side from a straight line, pixels.
const STRAIGHT: f64 = 1.5;
/// Smallest height of a fan, as a share of the picture's: echoes of a point in water are no fan.
const LEAST_HEIGHT: f64 = 0.2;
/// Smallest height of a side of a fan, as a share of the fan's height.
const LEAST_SIDE: f64 = 0.12;
/// Smallest and largest angle between the sides, and smallest of a side from the vertical, rad.
const TURNS: [f64; 2] = [0.15, 2.4];
const LEAST_TURN: f64 = 0.05;
/// Largest depth of the apex below the picture's top, as a share of the height, and longest outer radius, heights.
const APEX: f64 = 0.2;
const FARTHEST: f64 = 6.0;
/// Most outer arcs that are tried, and most points of the outline.
const ARCS: usize = 40;
const POINTS: usize = 800;
/// Columns of a median of the upper edge, and fewest of the edge.
const SMOOTHED: usize = 9;
const FEWEST_COLUMNS: usize = 40;
/// Smallest height of the arc of the upper edge, pixels, and smallest share of the edge on it.
const LEAST_RISE: f64 = 5.0;
const ON_FACE: f64 = 0.8;
/// Smallest shares of the outline: between the sides, on the sides, on the sides and arcs.
const WITHIN: f64 = 0.985;
const ON_SIDES: f64 = 0.1;
const EXPLAINED: f64 = 0.2;

impl PictureFan {
    /// The fan in pixels from the centre of the top left one; `None` if there is none.
    ///
    /// The largest connected part that is not black is the picture. Each pair of straight sides of its convex hull that
    /// meet above it is a candidate, and each circle through three points of its lower hull, with sides at the same
    /// angle: shadows may hide a side. So is the circle of its upper edge, with sides through the ends, which needs
    /// no sides. The candidate with most of the outline on its sides and arcs is the fan. If there is none, letters may
    /// touch the picture: they are left out.
    pub(super) fn of(pixels: ArrayView2<f32>) -> Option<Self> {
        let lit = Lit::of(pixels);
        let found = |margin| Self::around_part(&lit.largest_part(margin));
        found(0).or_else(|| found(LETTERS))
    }

    fn around_part(lit: &Array2<bool>) -> Option<Self> {
        let lanes = |axis| {
            let lanes = lit.axis_iter(Axis(axis)).enumerate();
            let ends = lanes.filter_map(|(k, lane)| {
                let ends = [
                    lane.iter().position(|&l| l)?,
                    lane.iter().rposition(|&l| l)?,
                ];
                Some([k, ends[0], ends[1]].map(|k| k as f64))
            });
            ends.collect::<Vec<[f64; 3]>>()
        };
        let (rows, columns) = (lanes(0), lanes(1));
        let (top, bottom) = (rows.first()?[0], rows.last()?[0]);
        let height = bottom - top;
        if height < LEAST_HEIGHT * lit.nrows() as f64 {
            return None;
        }
        let across = rows.iter().flat_map(|&[z, a, b]| [[a, z], [b, z]]);
        let down = columns.iter().flat_map(|&[x, a, b]| [[x, a], [x, b]]);
        let outline: Vec<[f64; 2]> = across.chain(down).collect();
        let every = outline.len().div_ceil(POINTS);
        let outline: Vec<_> = outline.into_iter().step_by(every).collect();

        let left = Side::all(rows.iter().map(|[z, first, _]| [*z, *first]), height);
        // Mirrored, the right side is a left one.
        let right = Side::all(rows.iter().map(|[z, _, last]| [*z, -last]), height);
        let pairs = left.iter().flat_map(|l| right.iter().map(move |r| (l, r)));
        let pairs = pairs.map(|(left, right)| {
            // x = a + b·z on the left, x = −(c + d·z) on the right.
            let z = -(left.at_0 + right.at_0) / (left.slope + right.slope);
            let angles = [left.slope.atan(), -right.slope.atan()];
            ([left.at_0 + left.slope * z, z], angles)
        });
        let low: Vec<_> = columns.iter().map(|[x, _, bottom]| [*x, -bottom]).collect();
        let arcs = apices(&hull(&low)).into_iter().map(|[x, z]| {
            let angles = outline.iter().map(|p| (p[0] - x).atan2(p[1] - z).abs());
            let mut angles: Vec<f64> = angles.collect();
            angles.sort_by(f64::total_cmp);
            let half = angles[angles.len() * 199 / 200];
            ([x, z], [-half, half])
        });
        let others = pairs.chain(arcs).map(|by| (by, EXPLAINED));
        let face = face(&columns).map(|by| (by, 0.0));
        let candidates = others.chain(face).filter(|(([_, z], [first, last]), _)| {
            let turns = (TURNS[0]..=TURNS[1]).contains(&(last - first));
            *z < top + APEX * height && turns && first.max(-last) < -LEAST_TURN
        });
        let judged = candidates.filter_map(|((apex, angles), least)| {
            let fan = Self::around(&outline, apex, angles)?;
            let fits = fan.explained(&outline, bottom);
            (fan.radii[1] < FARTHEST * height && fits >= least).then_some((fits, fan))
        });
        let (_, fan) = judged.max_by(|a, b| a.0.total_cmp(&b.0))?;
        // Of all pixels: dark tissue begins later and ends earlier. Black below the outer arc would be a shadow, so the
        // fan ends as far above it as its apex may be off.
        let pixels = lit.indexed_iter().filter(|(_, lit)| **lit);
        let polar = pixels.map(|((row, column), _)| {
            let (u, v) = (column as f64 - fan.x, row as f64 - fan.z);
            [u.hypot(v), u.atan2(v)]
        });
        let ends = ends(polar, fan.angles);
        let radii = [ends.nth(0, 0.2)?, ends.nth(1, 0.95)? - 2.0 * STRAIGHT];
        Some(Self { radii, ..fan })
    }

    /// The fan of an apex and angles around an outline, down to where most beams end at the latest.
    fn around(outline: &[[f64; 2]], [x, z]: [f64; 2], angles: [f64; 2]) -> Option<Self> {
        let polar = outline.iter().map(|p| [p[0] - x, p[1] - z]);
        let polar = polar.map(|[u, v]| [u.hypot(v), u.atan2(v)]);
        let near = |angle: f64| angle > angles[0] - 0.01 && angle < angles[1] + 0.01;
        let within = polar.clone().filter(|p| near(p[1])).count();
        let first = polar.clone().map(|p| p[0]).fold(f64::INFINITY, f64::min);
        let last = ends(polar, angles).nth(1, 0.95)?;
        let most = within as f64 >= WITHIN * outline.len() as f64;
        (most && last > first).then_some(Self {
            x,
            z,
            radii: [first, last],
            angles,
        })
    }

    /// Share of the outline on the sides and arcs, without a level lower edge; 0 if little is on the sides.
    fn explained(&self, outline: &[[f64; 2]], bottom: f64) -> f64 {
        let judged = outline.iter().filter(|p| p[1] < bottom - 1.5);
        let (mut all, mut on_sides, mut on_arcs) = (0.0, 0.0, 0.0);
        for (u, v) in judged.map(|p| (p[0] - self.x, p[1] - self.z)) {
            let (radius, angle) = (u.hypot(v), u.atan2(v));
            let near = |away: f64| away.abs() <= 2.0 * STRAIGHT;
            all += 1.0;
            if self.angles.iter().any(|side| near(radius * (angle - side))) {
                on_sides += 1.0;
            } else if self.radii.iter().any(|arc| near(radius - arc)) {
                on_arcs += 1.0;
            }
        }
        match on_sides >= ON_SIDES * all {
            true => (on_sides + on_arcs) / f64::max(all, 1.0),
            false => 0.0,
        }
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
}

impl Side {
    /// The straight parts of the hull of points (z, x) of ascending z that are high enough.
    fn all(points: impl Iterator<Item = [f64; 2]>, height: f64) -> Vec<Self> {
        let points: Vec<[f64; 2]> = points.collect();
        let hull = hull(&points);
        let ends = hull.iter().enumerate().filter_map(|(i, &a)| {
            let straight = hull[i + 1..].iter().take_while(|&&b| {
                let length = (b[0] - a[0]).hypot(b[1] - a[1]).max(1.0);
                let passed = hull[i..].iter().take_while(|p| p[0] <= b[0]);
                let away =
                    |p: &[f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
                passed.map(away).all(|away| away.abs() / length <= STRAIGHT)
            });
            let b = *straight.last()?;
            (b[0] - a[0] >= LEAST_SIDE * height).then_some([a, b])
        });
        let fitted = ends.filter_map(|[a, b]| {
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
            let at_0 = mean_x - slope * mean_z;
            (slope < 0.0).then_some(Self { at_0, slope })
        });
        fitted.collect()
    }
}

/// Apex and angles of a curved array by its face: the upper edge, an arc between the highest points on either side.
///
/// `columns` are x, upper and lower end. `None` if most of that edge is on no circle.
fn face(columns: &[[f64; 3]]) -> Option<([f64; 2], [f64; 2])> {
    // Without the holes of speckle.
    let upper: Vec<[f64; 2]> = columns
        .windows(SMOOTHED)
        .map(|beside| {
            let mut tops: Vec<f64> = beside.iter().map(|column| column[1]).collect();
            tops.sort_by(f64::total_cmp);
            [beside[SMOOTHED / 2][0], tops[SMOOTHED / 2]]
        })
        .collect();
    let highest = (0..upper.len()).min_by(|&a, &b| upper[a][1].total_cmp(&upper[b][1]))?;
    // The edge descends from one end and rises to the other.
    let rise = |to: &mut dyn Iterator<Item = usize>| {
        let mut lowest = f64::MIN;
        let rises = to.map(|k| {
            lowest = lowest.max(upper[k][1]);
            (lowest - upper[k][1], k)
        });
        rises.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let ends = [
        rise(&mut (highest..upper.len())),
        rise(&mut (0..=highest).rev()),
    ];
    let (rise, other) = ends
        .into_iter()
        .flatten()
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    let edge = upper.get(highest.min(other)..=highest.max(other))?;
    if rise < LEAST_RISE || edge.len() < FEWEST_COLUMNS {
        return None;
    }
    let at = |sixth: usize| edge[(edge.len() - 1) * sixth / 6];
    let triples = (0..=2).flat_map(|i| (4..=6).map(move |k| [at(i), at(3), at(k)]));
    let centres: Vec<[f64; 2]> = triples.filter_map(|[a, b, c]| centre(a, b, c)).collect();
    let median = |k: usize| {
        let mut sorted: Vec<f64> = centres.iter().map(|centre| centre[k]).collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    };
    let [x, z] = [median(0)?, median(1)?];
    let mut radii: Vec<f64> = edge.iter().map(|p| (p[0] - x).hypot(p[1] - z)).collect();
    radii.sort_by(f64::total_cmp);
    let radius = radii[radii.len() / 2];
    let on = radii.iter().filter(|r| (*r - radius).abs() <= STRAIGHT);
    let angle = |p: [f64; 2]| (p[0] - x).atan2(p[1] - z);
    (on.count() as f64 >= ON_FACE * radii.len() as f64)
        .then(|| ([x, z], [angle(at(0)), angle(at(6))]))
}

/// The centre (x, z) of the circle through three points.
fn centre(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<[f64; 2]> {
    // Both chords' perpendicular bisectors.
    let [[bx, bz], [cx, cz]] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1]]);
    let (b, c) = (bx * bx + bz * bz, cx * cx + cz * cz);
    let twice = 2.0 * (bx * cz - bz * cx);
    let centre = [
        a[0] + (cz * b - bz * c) / twice,
        a[1] + (bx * c - cx * b) / twice,
    ];
    centre.iter().all(|v| v.is_finite()).then_some(centre)
}

/// Centres (x, z) of circles through three points (x, −z) of a lower hull, far enough apart.
fn apices(hull: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let [Some(first), Some(last)] = [hull.first(), hull.last()] else {
        return Vec::new();
    };
    let width = last[0] - first[0];
    let mut triples = Vec::new();
    for (i, a) in hull.iter().enumerate() {
        for (j, b) in hull.iter().enumerate().skip(i + 1) {
            let c = hull.iter().skip(j + 1).filter(|c| {
                let apart = (b[0] - a[0]).min(c[0] - b[0]);
                c[0] - a[0] > 0.25 * width && apart > 0.08 * width
            });
            triples.extend(c.map(|c| [a, b, c]));
        }
    }
    let every = triples.len().div_ceil(ARCS).max(1);
    let triples = triples.into_iter().step_by(every);
    let centres = triples.filter_map(|[a, b, c]| centre(*a, *b, *c));
    centres.map(|[x, z]| [x, -z]).collect()
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

/// Number of bins of the angle in which the arcs are sought.
const BINS: usize = 128;

/// The nearest and the farthest radius of each bin of the angle.
struct Ends(Vec<[f64; 2]>);

/// Of points (radius, angle) between two angles.
fn ends(points: impl Iterator<Item = [f64; 2]>, angles: [f64; 2]) -> Ends {
    let mut ends = vec![[f64::INFINITY, 0.0]; BINS];
    for [radius, angle] in points {
        let fraction = (angle - angles[0]) / (angles[1] - angles[0]);
        if (0.0..1.0).contains(&fraction) {
            let [nearest, farthest] = &mut ends[(fraction * BINS as f64) as usize];
            (*nearest, *farthest) = (nearest.min(radius), farthest.max(radius));
        }
    }
    ends.retain(|[nearest, _]| nearest.is_finite());
    Ends(ends)
}

impl Ends {
    /// The radius that a share of the bins does not reach, of the nearest (0) or the farthest (1).
    fn nth(&self, k: usize, share: f64) -> Option<f64> {
        let mut sorted: Vec<f64> = self.0.iter().map(|ends| ends[k]).collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get((share * sorted.len() as f64) as usize).copied()
    }
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

    /// Shadows hide both sides, and the frame's lines touch the fan.
    #[test]
    fn a_face_is_enough_also_within_a_frame() {
        let fan = PictureFan {
            x: 310.0,
            z: -120.0,
            radii: [180.0, 540.0],
            angles: [-0.6, 0.6],
        };
        let mut picture = drawn(&fan, 480, 620);
        for ((row, column), level) in picture.indexed_iter_mut() {
            let (u, v) = (column as f64 - fan.x, row as f64 - fan.z);
            if u.hypot(v) > 200.0 && u.atan2(v).abs() > 0.25 || row > 300 {
                *level = 0.0;
            }
            let across = [26, 27, 420, 421].contains(&row) && (8..612).contains(&column);
            let down = [8, 9, 610, 611].contains(&column) && (26..422).contains(&row);
            if across || down {
                *level = 90.0;
            }
        }
        let found = PictureFan::of(picture.view()).unwrap();
        assert!((found.x - fan.x).abs() < 5.0, "{found:?}");
        // Lines at half the depth point as they should.
        for angle in [-0.5, 0.0, 0.5] {
            let [u, v] = fan.at(360.0, angle);
            let found = (u - found.x).atan2(v - found.z);
            assert!((found - angle).abs() < 0.05, "{found} for {angle}");
        }
    }

    #[test]
    fn letters_may_touch_the_fan() {
        let fan = PictureFan {
            x: 310.0,
            z: 20.0,
            radii: [20.0, 420.0],
            angles: [-0.45, 0.45],
        };
        let mut picture = drawn(&fan, 480, 620);
        for ((row, column), level) in picture.indexed_iter_mut() {
            let stroke = column % 7 < 3 || row % 8 < 3;
            if (36..52).contains(&row) && (150..330).contains(&column) && stroke {
                *level = 255.0;
            }
        }
        let found = PictureFan::of(picture.view()).unwrap();
        assert!((found.x - fan.x).abs() < 5.0, "{found:?}");
        for k in 0..2 {
            assert!((found.angles[k] - fan.angles[k]).abs() < 0.02, "{found:?}");
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
        // An echo in water whose side lobes spread downwards.
        let echo = PictureFan {
            x: 250.0,
            z: 60.0,
            radii: [40.0, 110.0],
            angles: [-0.6, 0.6],
        };
        assert!(PictureFan::of(drawn(&echo, 300, 500).view()).is_some());
        assert_eq!(PictureFan::of(drawn(&echo, 600, 500).view()), None);
    }
}
