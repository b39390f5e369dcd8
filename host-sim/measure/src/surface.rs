//! Scores of a detector of a surface, with at most one point per line.
//!
//! The surface is the one that a line meets first.

use serde::{Deserialize, Serialize};

/// Detected points of one frame, compared with the known surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// Number of lines with a detected point.
    pub answers: usize,
    /// Number of lines that meet a surface.
    pub surfaces: usize,
    /// Distance of each hit from the surface, mm.
    pub hits_mm: Vec<f64>,
}

/// Largest step of the surface in depth between neighbouring lines, m.
///
/// Beyond it, another surface begins.
const STEP: f64 = 3e-3;

/// The known surface: lateral positions of the lines, and depth or `None`, m.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// Ascending.
    pub x: &'a [f64],
    /// As many as `x`.
    pub depths: &'a [Option<f64>],
}

impl Known<'_> {
    /// Shortest distance of a depth on a line from the surface near it, m.
    ///
    /// The surface is straight from each line's depth to the next's. `None` for a line without a surface.
    fn distance(&self, line: usize, depth: f64, near: f64) -> Option<f64> {
        let (own, x) = (*self.depths.get(line)?, *self.x.get(line)?);
        let vertical = (depth - own?).abs();
        let sides = self.x.windows(2).zip(self.depths.windows(2));
        let sides = sides.filter(|(x2, _)| x2[1] >= x - near && x2[0] <= x + near);
        let distances = sides.filter_map(|(x2, depths)| {
            let [from, to] = [[x2[0], depths[0]?], [x2[1], depths[1]?]];
            let along = [to[0] - from[0], to[1] - from[1]];
            if along[1].abs() > STEP {
                return None;
            }
            let start = [x - from[0], depth - from[1]];
            let length = along[0] * along[0] + along[1] * along[1];
            let at = (start[0] * along[0] + start[1] * along[1]) / length.max(f64::MIN_POSITIVE);
            let at = at.clamp(0.0, 1.0);
            Some((start[0] - at * along[0]).hypot(start[1] - at * along[1]))
        });
        Some(distances.fold(vertical, f64::min))
    }
}

/// Judges detected depths, m, one per line.
///
/// A hit is at most `tolerance` m from the surface, by the shortest way, in a line that meets one.
pub fn judge(answers: &[Option<f64>], known: Known<'_>, tolerance: f64) -> Judged {
    let lines = answers.iter().enumerate();
    let distances =
        lines.filter_map(|(line, found)| known.distance(line, found.as_ref().copied()?, tolerance));
    Judged {
        answers: answers.iter().flatten().count(),
        surfaces: known.depths.iter().flatten().count(),
        hits_mm: distances
            .filter(|distance| *distance <= tolerance)
            .map(|distance| 1e3 * distance)
            .collect(),
    }
}

impl Judged {
    /// The sum over all frames.
    pub fn of_all<'a>(frames: impl IntoIterator<Item = &'a Judged>) -> Judged {
        let mut all = Judged::default();
        for frame in frames {
            all.answers += frame.answers;
            all.surfaces += frame.surfaces;
            all.hits_mm.extend(&frame.hits_mm);
        }
        all
    }

    /// Share of the detected points that are hits; `None` without points.
    pub fn precision(&self) -> Option<f64> {
        fraction(self.hits_mm.len(), self.answers)
    }

    /// Share of the surface's lines that are hit; `None` without a surface.
    pub fn recall(&self) -> Option<f64> {
        fraction(self.hits_mm.len(), self.surfaces)
    }

    /// Harmonic mean of precision and recall; `None` without points and surface.
    pub fn f1(&self) -> Option<f64> {
        fraction(2 * self.hits_mm.len(), self.answers + self.surfaces)
    }

    /// Mean distance of the hits, mm.
    pub fn mean_mm(&self) -> Option<f64> {
        let count = self.hits_mm.len();
        (count > 0).then(|| self.hits_mm.iter().sum::<f64>() / count as f64)
    }

    /// Distance that 95 % of the hits do not exceed, mm.
    pub fn p95_mm(&self) -> Option<f64> {
        let mut sorted = self.hits_mm.clone();
        sorted.sort_by(f64::total_cmp);
        let rank = (0.95 * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.checked_sub(1)?).copied()
    }
}

fn fraction(part: usize, of: usize) -> Option<f64> {
    (of > 0).then(|| part as f64 / of as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_hits_false_or_missing() {
        // A hit, one too deep, one where there is no surface, a surface without an answer, neither.
        let answers = [Some(10.2e-3), Some(20.6e-3), Some(5e-3), None, None];
        let surface = [Some(10e-3), Some(20e-3), None, Some(15e-3), None];
        let x = [0.0, 5e-3, 10e-3, 15e-3, 20e-3];
        let known = Known {
            x: &x,
            depths: &surface,
        };
        let judged = judge(&answers, known, 0.5e-3);
        assert_eq!((judged.answers, judged.surfaces), (3, 3));
        assert_eq!(judged.precision(), Some(1.0 / 3.0));
        assert_eq!(judged.recall(), Some(1.0 / 3.0));
        assert!((judged.mean_mm().unwrap() - 0.2).abs() < 1e-9);
        let nothing = Known {
            x: &x[..4],
            depths: &[None; 4],
        };
        let none = judge(&[None; 4], nothing, 0.5e-3);
        assert_eq!(
            (none.precision(), none.recall(), none.f1()),
            (None, None, None)
        );
        let both = Judged::of_all([&judged, &judged, &none]);
        assert_eq!((both.answers, both.surfaces, both.hits_mm.len()), (6, 6, 2));
    }

    #[test]
    fn on_a_slope_the_shortest_way_counts() {
        // 60 degrees steep: half of what the depths differ by. The fourth line's surface is another one.
        let steep = 0.3e-3 * 3f64.sqrt();
        let known = Known {
            x: &[0.0, 0.3e-3, 0.6e-3, 0.9e-3],
            depths: &[10e-3, 10e-3 + steep, 10e-3 + 2.0 * steep, 20e-3].map(Some),
        };
        let at = |line, depth| 1e3 * known.distance(line, depth, 0.5e-3).unwrap();
        assert!((at(1, 10e-3 + steep + 0.4e-3) - 0.2).abs() < 1e-9);
        assert!((at(3, 20.4e-3) - 0.4).abs() < 1e-9);
        // Beyond the end of the surface.
        assert!((at(0, 9.6e-3) - 0.4).abs() < 1e-9);
    }

    #[test]
    fn the_percentile_is_the_nearest_rank() {
        let with = |count: usize| Judged {
            hits_mm: (1..=count).rev().map(|k| k as f64).collect(),
            ..Judged::default()
        };
        assert_eq!(with(100).p95_mm(), Some(95.0));
        assert_eq!(with(20).p95_mm(), Some(19.0));
        assert_eq!(with(1).p95_mm(), Some(1.0));
        assert_eq!(with(0).p95_mm(), None);
    }
}
