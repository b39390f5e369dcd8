//! Judges each claim by the scenes.

use crate::experiments::study::*;
use std::collections::{BTreeMap, BTreeSet};

use crate::experiments::common::interval::holm;
use crate::experiments::outcome::{Ruling, Verdict};

use super::condition::{Condition, Medium};
use super::parameters::Claims;
use super::population::Bone;
use super::scene::SceneResult;
use super::statements::{Direction, STATEMENTS, Statement};
use super::tuning::Tuned;

/// Fewest bones that can decide a claim.
const FEWEST: usize = 3;
/// Mean errors count as equal within this difference, mm.
const SAME: f64 = 0.2;
/// Tolerance of a claim such as "some 20 %", as a share of DAS.
const SOME: f64 = 0.05;
/// Probability of a false finding among all conditions of a claim.
const LEVEL: f64 = 0.05;

/// The data of the claims.
#[derive(Clone, Debug, Serialize)]
pub struct ClaimsResult {
    /// Every scene.
    pub scenes: Vec<SceneResult>,
    /// The bones of the scenes.
    pub bones: Vec<Bone>,
    /// Differences of every claim.
    pub claims: Vec<Claim>,
    /// Filters that were found on other bones.
    pub tuned: Vec<Tuned>,
    /// Names of the beamformers by key, DAS first.
    pub beamformers: Vec<(String, String)>,
    /// Mean average precision of the mixed images, over the scenes in tissue.
    pub zones: Vec<(String, Option<Interval>)>,
}

/// A claim and its differences.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// Name of the measure.
    pub measure: &'static str,
    /// ESMV − DAS in every condition.
    pub cells: Vec<Cell>,
    pub verdict: Verdict,
}

/// ESMV − DAS in one condition.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// Medium and disturbance.
    pub condition: Condition,
    /// The beamformer's key.
    pub beamformer: String,
    /// Whether this is the paper's beamformer in this condition.
    ///
    /// Only this beamformer counts in the verdict.
    pub papers: bool,
    /// Means of DAS and of ESMV.
    pub means: [f64; 2],
    /// Mean difference with its interval.
    pub difference: Interval,
    /// Reduction as a share of DAS, if the claim has a number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reduction: Option<Interval>,
    /// Whether the claim is shown here, or its opposite (`false`); `None` if open.
    pub shown: Option<bool>,
}

impl Cell {
    /// Whether the interval of the reduction reaches the claimed share.
    fn reaches(&self, magnitude: Option<f64>) -> bool {
        let Some(magnitude) = magnitude else {
            return true;
        };
        let ends = self.reduction.and_then(|reduction| reduction.ends);
        ends.is_some_and(|[_, most]| most >= magnitude - SOME)
    }
}

/// Judges every claim on the scenes.
pub fn judge(scenes: Vec<SceneResult>, tuned: Vec<Tuned>, claims: &Claims) -> Result<ClaimsResult> {
    let numbers: BTreeSet<u64> = scenes.iter().map(|scene| scene.bone).collect();
    let bones = numbers.into_iter().map(|number| Bone::new(claims, number));
    let beamformers = claims.variants().into_iter();
    Ok(ClaimsResult {
        claims: judged(&scenes, claims),
        bones: bones.collect::<Result<_>>()?,
        tuned,
        zones: zones(&scenes),
        beamformers: beamformers.map(|v| (v.key, v.name)).collect(),
        scenes,
    })
}

/// Judges every claim by the scenes.
fn judged(scenes: &[SceneResult], claims: &Claims) -> Vec<Claim> {
    let judged = STATEMENTS.iter().filter_map(|statement| {
        let cells = cells(scenes, statement, claims);
        (!cells.is_empty()).then(|| Claim {
            measure: statement.measure,
            verdict: verdict(statement, &cells),
            cells,
        })
    });
    judged.collect()
}

/// Mean of a column of the mixed images.
fn zones(scenes: &[SceneResult]) -> Vec<(String, Option<Interval>)> {
    type Pick = fn(&super::mechanism::Zones) -> Option<f64>;
    let rows: [(&str, Pick); 9] = [
        ("DAS", |z| z.das),
        ("DAS with the echo of rank 1", |z| z.echo),
        ("DAS with the halo of rank 1", |z| z.halo),
        ("DAS with the rest of rank 1", |z| z.rest),
        ("ESMV rank 1", |z| z.all),
        ("level beside echoes re tissue, DAS, dB", |z| z.halo_db[0]),
        ("level beside echoes re tissue, rank 1, dB", |z| {
            z.halo_db[1]
        }),
        ("spread of the tissue's level, DAS, dB", |z| z.spread_db[0]),
        ("spread of the tissue's level, rank 1, dB", |z| {
            z.spread_db[1]
        }),
    ];
    rows.map(|(name, pick)| {
        let values = scenes.iter().filter_map(|s| pick(s.zones.as_ref()?));
        (name.to_owned(), Interval::of(values))
    })
    .into()
}

/// Differences of a claim's measure, by condition and beamformer.
fn cells(scenes: &[SceneResult], statement: &Statement, claims: &Claims) -> Vec<Cell> {
    let mut conditions: BTreeMap<Condition, Vec<&SceneResult>> = BTreeMap::new();
    for scene in scenes {
        if statement.tissue_only && scene.condition.medium() != Medium::Tissue {
            continue;
        }
        conditions.entry(scene.condition).or_default().push(scene);
    }
    let mut cells = Vec::new();
    for (condition, scenes) in conditions {
        for Variant { key, .. } in claims.variants().iter().skip(1) {
            let pair = |scene: &&SceneResult| {
                let of = |key: &str| {
                    let m = scene.beamformers.iter().find(|m| m.beamformer == key)?;
                    (statement.pick)(m)
                };
                Some([of("das")?, of(key)?])
            };
            let pairs: Vec<[f64; 2]> = scenes.iter().filter_map(pair).collect();
            let Some(difference) = Interval::of(pairs.iter().map(|[das, esmv]| esmv - das)) else {
                continue;
            };
            let reductions = pairs.iter().map(|[das, esmv]| 1.0 - esmv / das);
            let means = [0, 1].map(|k| mean(pairs.iter().map(|p| p[k])).unwrap_or(f64::NAN));
            cells.push(Cell {
                condition,
                beamformer: key.clone(),
                papers: *key == claims.papers(condition.medium()),
                means,
                difference,
                reduction: statement.magnitude.and_then(|_| Interval::of(reductions)),
                shown: None,
            });
        }
    }
    let rulings = rulings(&cells, statement.direction);
    for (cell, ruling) in cells.iter_mut().zip(rulings) {
        cell.shown = ruling.filter(|_| cell.difference.scenes >= FEWEST);
        // A claim with a figure is not shown by a smaller effect.
        if cell.shown == Some(true) && !cell.reaches(statement.magnitude) {
            cell.shown = None;
        }
    }
    cells
}

/// Whether a claim, or its opposite, is shown in each condition.
///
/// Holm's correction allows for the number of conditions.
fn rulings(cells: &[Cell], direction: Direction) -> Vec<Option<bool>> {
    // Two-sided, since either side is a finding.
    let chances = |d: &Interval| match direction {
        Direction::Less => [d.chance_below(0.0), d.chance_above(0.0)].map(|p| 2.0 * p),
        Direction::More => [d.chance_above(0.0), d.chance_below(0.0)].map(|p| 2.0 * p),
        Direction::Same => {
            let beyond = d.chance_above(SAME).min(d.chance_below(-SAME));
            [d.chance_within(SAME), 2.0 * beyond]
        }
    };
    let both: Vec<[f64; 2]> = cells.iter().map(|c| chances(&c.difference)).collect();
    let [shown, opposite] = [0, 1].map(|k| holm(&both.iter().map(|p| p[k]).collect::<Vec<_>>()));
    let decide = |(shown, opposite): (f64, f64)| match (shown < LEVEL, opposite < LEVEL) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    };
    shown.into_iter().zip(opposite).map(decide).collect()
}

/// The verdict.
///
/// The beamformers of a condition share its recordings, so each condition counts once, by the paper's beamformer.
fn verdict(statement: &Statement, cells: &[Cell]) -> Verdict {
    let conditions: Vec<&Cell> = cells.iter().filter(|c| c.papers).collect();
    let having = |shown: Option<bool>| -> Vec<&str> {
        let some = conditions.iter().filter(|c| c.shown == shown);
        some.map(|c| c.condition.title()).collect()
    };
    let (shown, opposite) = (having(Some(true)), having(Some(false)));
    let count = shown.len();
    let few = conditions.iter().any(|c| c.difference.scenes < FEWEST);
    let ruling = match count {
        0 if !opposite.is_empty() => Ruling::DoesNotHold,
        0 if few => Ruling::Open(format!("fewer than {FEWEST} bones per condition")),
        0 => Ruling::Open("no difference is both significant and as large as claimed".into()),
        _ if count == conditions.len() => Ruling::Holds,
        _ => Ruling::DependsOn(format!("the condition: shown in {}", shown.join("; "))),
    };
    let mut evidence = format!(
        "shown in {count} of {} conditions, the opposite in {}",
        conditions.len(),
        opposite.len()
    );
    let others = cells.iter().filter(|c| !c.papers);
    let (mut other, mut agree) = (0, 0);
    for cell in others {
        let papers = conditions.iter().find(|c| c.condition == cell.condition);
        other += 1;
        agree += usize::from(papers.is_some_and(|c| c.shown == cell.shown));
    }
    if other > 0 {
        evidence += &format!("; other K or FB agree in {agree} of {other}");
    }
    evidence += ".";
    for condition in [Condition::WaterDisturbed, Condition::TissueDisturbed] {
        let Some(cell) = conditions.iter().find(|c| c.condition == condition) else {
            continue;
        };
        let [das, esmv] = cell.means.map(number);
        evidence += &format!(" {}: {das} → {esmv}.", condition.title());
    }
    if statement.paper != "–" {
        evidence += &format!(" Paper: {}.", statement.paper);
    }
    Verdict {
        claim: statement.claim.into(),
        place: statement.place.into(),
        ruling,
        evidence: format!("{}: {evidence}", statement.measure),
    }
}

#[cfg(test)]
mod tests {
    use super::super::scene::SceneMeasure;
    use super::*;
    use crate::experiments::common::bone::BoneMeasure;

    fn measure(value: f64) -> BoneMeasure {
        BoneMeasure {
            mean_mm: Some(value),
            std_mm: Some(value),
            near_std_mm: Some(value),
            intensity_b: Some(value),
            intensity_c: Some(value),
            average_precision: Some(value),
            found: Some(value),
            thickness_mm: Some(value),
        }
    }

    /// Scenes whose ESMV is `factor(medium)` times DAS, which differs from bone to bone.
    fn scenes(factor: impl Fn(Medium) -> f64) -> Vec<SceneResult> {
        let mut all = Vec::new();
        for medium in [Medium::Water, Medium::Tissue] {
            for bone in 1..=8 {
                let das = 1.0 + 0.1 * bone as f64;
                let of = |key: &str, value: f64| SceneMeasure {
                    beamformer: key.into(),
                    b_mode: measure(value),
                    phase_symmetry: measure(value),
                    tuned: measure(value),
                };
                all.push(SceneResult {
                    bone,
                    condition: match medium {
                        Medium::Water => Condition::WaterQuiet,
                        Medium::Tissue => Condition::TissueQuiet,
                    },
                    brightness: None,
                    detectors: Vec::new(),
                    beamformers: vec![of("das", das), of("esmv-rank1-k0", das * factor(medium))],
                    uniform: [measure(1.0), measure(1.0)],
                    zones: None,
                });
            }
        }
        all
    }

    fn ruling(scenes: Vec<SceneResult>, measure: &str) -> Ruling {
        let claims = Claims {
            half_windows: vec![0],
            ..Claims::default()
        };
        let result = judged(&scenes, &claims);
        let found = result.into_iter().find(|c| c.measure == measure);
        found.unwrap().verdict.ruling
    }

    #[test]
    fn verdicts_follow_the_differences() {
        let std = "PS: STD in region A, mm";
        assert_eq!(ruling(scenes(|_| 0.8), std), Ruling::Holds);
        assert_eq!(ruling(scenes(|_| 1.2), std), Ruling::DoesNotHold);
        assert!(matches!(ruling(scenes(|_| 1.0), std), Ruling::Open(_)));
        let depends = ruling(
            scenes(|medium| if medium == Medium::Water { 0.8 } else { 1.2 }),
            std,
        );
        let expected = "the condition: shown in water, quiet";
        assert_eq!(depends, Ruling::DependsOn(expected.into()));
        // A tenth less is no fifth less, though it is less.
        assert!(matches!(ruling(scenes(|_| 0.9), std), Ruling::Open(_)));
        assert_eq!(
            ruling(scenes(|_| 0.9), "US: STD in region A, mm"),
            Ruling::Holds
        );
        // More is claimed of average precision.
        let precision = "PS: average precision";
        assert_eq!(ruling(scenes(|_| 1.2), precision), Ruling::Holds);
        assert_eq!(ruling(scenes(|_| 0.8), precision), Ruling::DoesNotHold);
        // The same: within 0.2 mm, shown by two one-sided tests.
        let error = "PS: mean localization error, mm";
        assert_eq!(ruling(scenes(|_| 1.05), error), Ruling::Holds);
        assert_eq!(ruling(scenes(|_| 4.0), error), Ruling::DoesNotHold);
        assert_eq!(ruling(scenes(|_| 0.1), error), Ruling::DoesNotHold);
        // Differences of 0.11 to 0.18 mm are within, but their mean is not known to be by 0.13 more.
        assert!(matches!(ruling(scenes(|_| 1.14), error), Ruling::Open(_)));
        let small = |mut scene: SceneResult| {
            for (m, value) in scene.beamformers.iter_mut().zip([0.001, -0.12]) {
                m.phase_symmetry.mean_mm = Some(value);
            }
            scene
        };
        let small = scenes(|_| 1.0).into_iter().map(small).collect();
        assert_eq!(ruling(small, error), Ruling::Holds);
        // Two bones decide nothing.
        let mut few = scenes(|_| 0.8);
        few.retain(|scene| scene.bone <= 2);
        assert!(matches!(ruling(few, std), Ruling::Open(_)));
    }
}
