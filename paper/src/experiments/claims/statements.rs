//! The paper's claims and their measures.

use super::scene::SceneMeasure;

/// The claimed relation of ESMV's measure to DAS's.
#[derive(Clone, Copy, PartialEq)]
pub enum Direction {
    Less,
    More,
    /// Equal errors, within 0.2 mm.
    Same,
}

/// A claim and its measure.
pub struct Statement {
    pub claim: &'static str,
    pub place: &'static str,
    pub direction: Direction,
    /// Claimed reduction as a share of DAS; `None` if the claim has no number.
    pub magnitude: Option<f64>,
    pub measure: &'static str,
    pub pick: fn(&SceneMeasure) -> Option<f64>,
    pub paper: &'static str,
    pub tissue_only: bool,
}

const ABSTRACT: &str = "abstract";
const DISCUSSION: &str = "discussion";

const fn statement(
    [claim, place]: [&'static str; 2],
    direction: Direction,
    magnitude: Option<f64>,
    measure: &'static str,
    pick: fn(&SceneMeasure) -> Option<f64>,
    paper: &'static str,
) -> Statement {
    Statement {
        claim,
        place,
        direction,
        magnitude,
        measure,
        pick,
        paper,
        tissue_only: false,
    }
}

/// The claims.
#[rustfmt::skip]
pub const STATEMENTS: [Statement; 13] = {
    use Direction::{Less, More, Same};
    [
        statement(["The bone is localized as well as with DAS (PS)", ABSTRACT], Same, None,
            "PS: mean localization error, mm", |m| m.phase_symmetry.mean_mm, "0.94, 0.97 → 0.84, 0.95"),
        statement(["The intensity around the surface has a smaller STD, by some 20 % (PS)", ABSTRACT], Less, Some(0.2),
            "PS: STD in region A, mm", |m| m.phase_symmetry.std_mm, "0.53, 0.57 → 0.42, 0.45"),
        statement(["The STD is also smaller within 1 mm on both sides of the known surface (PS)", "variant of the abstract"], Less, None,
            "PS: STD in ±1 mm, mm", |m| m.phase_symmetry.near_std_mm, "–"),
        statement(["The noise inside the shadow is lower, by some 60 % (PS)", ABSTRACT], Less, Some(0.6),
            "PS: intensity C", |m| m.phase_symmetry.intensity_c, "3.06, 5.16 → 1.24, 1.88"),
        statement(["The bone is localized as well as with DAS (B-mode)", DISCUSSION], Same, None,
            "US: mean localization error, mm", |m| m.b_mode.mean_mm, "0.70, 0.90 → 0.66, 0.79"),
        statement(["The distribution in region A is narrower (B-mode)", DISCUSSION], Less, None,
            "US: STD in region A, mm", |m| m.b_mode.std_mm, "0.72, 0.85 → 0.65, 0.77"),
        statement(["The noise inside the bone is much lower (B-mode)", DISCUSSION], Less, None,
            "US: intensity C", |m| m.b_mode.intensity_c, "92.4, 125.5 → 16.8, 15.8"),
        statement(["The noise outside the bone is much lower (PS)", DISCUSSION], Less, None,
            "PS: intensity B", |m| m.phase_symmetry.intensity_b, "32.2, 32.2 → 6.60, 3.93"),
        statement(["The boundaries are thinner (PS)", DISCUSSION], Less, None,
            "PS: thickness of ridges, mm", |m| m.phase_symmetry.thickness_mm, "0.51 → 0.34"),
        statement(["More of the surface is detected (PS)", "results, Fig. 3"], More, None,
            "PS: share of the surface found", |m| m.phase_symmetry.found, "–"),
        statement(["The surface stands out better from its surroundings (PS, paper's filter)", ABSTRACT], More, None,
            "PS: average precision", |m| m.phase_symmetry.average_precision, "–"),
        statement(["The surface stands out better from its surroundings (PS, best filter for each beamformer)", ABSTRACT], More, None,
            "PS, tuned: average precision", |m| m.tuned.average_precision, "–"),
        Statement { tissue_only: true, ..statement(["Speckle around the bone is reduced (B-mode)", DISCUSSION], Less, None,
            "US: intensity B", |m| m.b_mode.intensity_b, "27.2, 63.1 → 4.71, 10.2 (water)") },
    ]
};
