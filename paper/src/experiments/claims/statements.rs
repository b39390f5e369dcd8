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
    pub measure: &'static str,
    pub direction: Direction,
    pub tissue_only: bool,
    /// Claimed reduction as a share of DAS; `None` if the claim has no number.
    pub magnitude: Option<f64>,
    pub pick: fn(&SceneMeasure) -> Option<f64>,
    pub paper: &'static str,
}

const fn statement(
    claim: &'static str,
    place: &'static str,
    measure: &'static str,
    direction: Direction,
    pick: fn(&SceneMeasure) -> Option<f64>,
    paper: &'static str,
) -> Statement {
    Statement {
        claim,
        place,
        measure,
        direction,
        tissue_only: false,
        magnitude: None,
        pick,
        paper,
    }
}

impl Statement {
    const fn by(self, share: f64) -> Self {
        Statement {
            magnitude: Some(share),
            ..self
        }
    }
}

const ABSTRACT: &str = "abstract";
const DISCUSSION: &str = "discussion";

/// The claims.
pub const STATEMENTS: [Statement; 12] = [
    statement(
        "The bone is localized as well as with DAS (PS)",
        ABSTRACT,
        "PS: mean localization error, mm",
        Direction::Same,
        |m| m.phase_symmetry.mean_mm,
        "0.94, 0.97 → 0.84, 0.95",
    ),
    statement(
        "The intensity around the surface has a smaller STD, by some 20 % (PS)",
        ABSTRACT,
        "PS: STD in region A, mm",
        Direction::Less,
        |m| m.phase_symmetry.std_mm,
        "0.53, 0.57 → 0.42, 0.45",
    )
    .by(0.2),
    statement(
        "The STD is also smaller within 1 mm on both sides of the known surface (PS)",
        "variant of the abstract",
        "PS: STD in ±1 mm, mm",
        Direction::Less,
        |m| m.phase_symmetry.near_std_mm,
        "–",
    ),
    statement(
        "The noise inside the shadow is lower, by some 60 % (PS)",
        ABSTRACT,
        "PS: intensity C",
        Direction::Less,
        |m| m.phase_symmetry.intensity_c,
        "3.06, 5.16 → 1.24, 1.88",
    )
    .by(0.6),
    statement(
        "The bone is localized as well as with DAS (B-mode)",
        DISCUSSION,
        "US: mean localization error, mm",
        Direction::Same,
        |m| m.b_mode.mean_mm,
        "0.70, 0.90 → 0.66, 0.79",
    ),
    statement(
        "The distribution in region A is narrower (B-mode)",
        DISCUSSION,
        "US: STD in region A, mm",
        Direction::Less,
        |m| m.b_mode.std_mm,
        "0.72, 0.85 → 0.65, 0.77",
    ),
    statement(
        "The noise inside the bone is much lower (B-mode)",
        DISCUSSION,
        "US: intensity C",
        Direction::Less,
        |m| m.b_mode.intensity_c,
        "92.4, 125.5 → 16.8, 15.8",
    ),
    statement(
        "The noise outside the bone is much lower (PS)",
        DISCUSSION,
        "PS: intensity B",
        Direction::Less,
        |m| m.phase_symmetry.intensity_b,
        "32.2, 32.2 → 6.60, 3.93",
    ),
    statement(
        "The boundaries are thinner (PS)",
        DISCUSSION,
        "PS: thickness of ridges, mm",
        Direction::Less,
        |m| m.phase_symmetry.thickness_mm,
        "0.51 → 0.34",
    ),
    statement(
        "More of the surface is detected (PS)",
        "results, Fig. 3",
        "PS: share of the surface found",
        Direction::More,
        |m| m.phase_symmetry.found,
        "–",
    ),
    statement(
        "The surface stands out better from its surroundings (PS, paper's filter)",
        ABSTRACT,
        "PS: average precision",
        Direction::More,
        |m| m.phase_symmetry.average_precision,
        "–",
    ),
    statement(
        "The surface stands out better from its surroundings (PS, best filter for each beamformer)",
        ABSTRACT,
        "PS, tuned: average precision",
        Direction::More,
        |m| m.tuned.average_precision,
        "–",
    ),
];

/// The speckle around the bone is reduced; needs tissue.
pub const SPECKLE: Statement = Statement {
    claim: "Speckle around the bone is reduced (B-mode)",
    place: DISCUSSION,
    measure: "US: intensity B",
    direction: Direction::Less,
    tissue_only: true,
    magnitude: None,
    pick: |m: &SceneMeasure| m.b_mode.intensity_b,
    paper: "27.2, 63.1 → 4.71, 10.2 (water)",
};
