//! Whether a frame has bone, as a whole.

use std::fmt;

use bonebeam::surface::{Levels, Point};

/// Whether a frame has bone; if not, why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// A surface that is long and sure enough.
    Bone,
    /// No surface in a frame that would show one.
    NoBone(&'static str),
    /// The frame does not tell.
    Unclear(&'static str),
}

/// Least confidence of a point that counts.
const SURE: f32 = 0.5;
/// Least length of all surface that counts, m.
const LENGTH: f64 = 3e-3;
/// Least bright level of a frame that shows tissue, 1/16 of a grey level.
const BRIGHT: u16 = 16 * 32;
/// Largest level of a black shadow, 1/16 of a grey level.
const BLACK: u16 = 16 * 13;

/// What a frame shows beside its points.
#[derive(Clone, Copy)]
pub(super) struct Facts {
    pub levels: Levels,
    /// Whether lines had a surface before unsure pieces were left out.
    pub surface: bool,
}

impl Verdict {
    /// Of the points of lines, m apart, in a frame.
    pub(super) fn of(points: &[Option<Point>], spacing: f64, facts: Facts) -> Self {
        let sure = points.iter().flatten().filter(|p| p.confidence >= SURE);
        let Levels {
            dark,
            tissue,
            bright,
        } = facts.levels;
        match () {
            () if sure.count() as f64 * spacing >= LENGTH => Verdict::Bone,
            () if bright < BRIGHT => Verdict::Unclear("the frame is too dark"),
            () if facts.surface => Verdict::Unclear("the surface is short or faint"),
            () if dark > BLACK.max(tissue / 2) => Verdict::NoBone("no shadow"),
            () => Verdict::NoBone("no line above a shadow"),
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Verdict::Bone => f.write_str("bone"),
            Verdict::NoBone(why) => write!(f, "no bone: {why}"),
            Verdict::Unclear(why) => write!(f, "cannot tell: {why}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_judged_by_their_surface_and_by_their_levels() {
        let point = |confidence| {
            let begins = false;
            Some(Point {
                depth: 0.02,
                confidence,
                begins,
            })
        };
        let facts = |surface, [dark, tissue, bright]: [u16; 3]| Facts {
            levels: Levels {
                dark: 16 * dark,
                tissue: 16 * tissue,
                bright: 16 * bright,
            },
            surface,
        };
        let usual = [2, 60, 150];
        let doubtful = "cannot tell: the surface is short or faint";
        for (points, surface, levels, expected) in [
            (vec![point(0.9); 20], true, usual, "bone"),
            (vec![point(0.9); 4], true, usual, doubtful),
            (vec![point(0.4); 40], true, usual, doubtful),
            // All pieces were left out.
            (vec![None; 20], true, usual, doubtful),
            (
                vec![None; 20],
                false,
                usual,
                "no bone: no line above a shadow",
            ),
            (vec![None; 20], false, [50, 60, 150], "no bone: no shadow"),
            (
                vec![None; 20],
                false,
                [0, 5, 20],
                "cannot tell: the frame is too dark",
            ),
        ] {
            let verdict = Verdict::of(&points, 0.25e-3, facts(surface, levels));
            assert_eq!(verdict.to_string(), expected);
        }
    }
}
