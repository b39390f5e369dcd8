//! What the scenes say of each claim.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::experiments::common::interval::{Interval, holm};
use crate::experiments::outcome::{Ruling, Verdict, number};

use super::medium::{Medium, disturbance};
use super::parameters::Claims;
use super::scene::SceneResult;
use super::statements::{Direction, SPECKLE, STATEMENTS, Statement};
use super::tuning::Tuned;

/// Fewer scenes decide nothing.
const FEWEST: usize = 3;
/// Mean errors within this are the same, mm.
const SAME: f64 = 0.2;
/// A claim of "some 20 %" allows so much less, as a share of DAS.
const SOME: f64 = 0.05;
/// The chance of a false finding among all conditions of a claim.
const LEVEL: f64 = 0.05;

/// All that is told of the claims.
#[derive(Clone, Debug, Serialize)]
pub struct ClaimsResult {
    /// Every scene.
    pub scenes: Vec<SceneResult>,
    /// Every claim's differences.
    pub claims: Vec<Claim>,
    /// The filters that were found on other seeds.
    pub tuned: Vec<Tuned>,
    /// The names of the beamformers by their keys, DAS first.
    pub beamformers: Vec<(String, String)>,
    /// Means over the scenes in tissue of the mixed images' average precision.
    pub zones: Vec<(String, Option<Interval>)>,
}

/// A claim and what was found.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// The measure's name.
    pub measure: &'static str,
    /// ESMV − DAS in every condition.
    pub cells: Vec<Cell>,
    /// The verdict.
    pub verdict: Verdict,
}

/// ESMV − DAS in one condition.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// What surrounds the bone.
    pub medium: Medium,
    /// With noise, clutter and reverberation.
    pub disturbed: bool,
    /// Which bone.
    pub geometry: String,
    /// The beamformer's key.
    pub beamformer: String,
    /// Mean of DAS, and of ESMV.
    pub means: [f64; 2],
    /// Mean difference, and its interval.
    pub difference: Interval,
    /// By which share of DAS the measure is smaller, where the claim has a figure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reduction: Option<Interval>,
    /// Whether the claim is shown here: true, or false where the opposite is; none where it is open.
    pub shown: Option<bool>,
}

impl Cell {
    /// Whether the interval of the reduction reaches the share that is claimed.
    fn reaches(&self, magnitude: Option<f64>) -> bool {
        let Some(magnitude) = magnitude else {
            return true;
        };
        let ends = self.reduction.and_then(|reduction| reduction.ends);
        ends.is_some_and(|[_, most]| most >= magnitude - SOME)
    }
}

/// Judges every claim on the scenes.
pub fn judge(scenes: Vec<SceneResult>, tuned: Vec<Tuned>, claims: &Claims) -> ClaimsResult {
    let beamformers: Vec<(String, String)> = claims
        .variants()
        .into_iter()
        .map(|v| (v.key, v.name))
        .collect();
    let judged = STATEMENTS.iter().chain([&SPECKLE]).filter_map(|statement| {
        let cells = cells(&scenes, statement, &beamformers);
        (!cells.is_empty()).then(|| Claim {
            measure: statement.measure,
            verdict: verdict(statement, &cells),
            cells,
        })
    });
    let claims = judged.collect();
    ClaimsResult {
        claims,
        tuned,
        zones: zones(&scenes),
        beamformers,
        scenes,
    }
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
        let values: Vec<f64> = scenes
            .iter()
            .filter_map(|s| pick(s.zones.as_ref()?))
            .collect();
        (name.to_owned(), Interval::of(&values))
    })
    .into()
}

/// The differences of a claim's measure, by condition and beamformer.
fn cells(
    scenes: &[SceneResult],
    statement: &Statement,
    beamformers: &[(String, String)],
) -> Vec<Cell> {
    let mut conditions: BTreeMap<(Medium, bool, &str), Vec<&SceneResult>> = BTreeMap::new();
    for scene in scenes {
        if statement.tissue_only && scene.medium != Medium::Tissue {
            continue;
        }
        let condition = (scene.medium, scene.disturbed, &scene.geometry[..]);
        conditions.entry(condition).or_default().push(scene);
    }
    let mut cells = Vec::new();
    for ((medium, disturbed, geometry), scenes) in conditions {
        for (key, _) in beamformers.iter().skip(1) {
            let pairs: Vec<[f64; 2]> = scenes
                .iter()
                .filter_map(|scene| {
                    let of = |key: &str| {
                        let m = scene.beamformers.iter().find(|m| m.beamformer == key)?;
                        (statement.pick)(m)
                    };
                    Some([of("das")?, of(key)?])
                })
                .collect();
            let differences: Vec<f64> = pairs.iter().map(|[das, esmv]| esmv - das).collect();
            let Some(difference) = Interval::of(&differences) else {
                continue;
            };
            let reductions: Vec<f64> = pairs.iter().map(|[das, esmv]| 1.0 - esmv / das).collect();
            let mean = |k: usize| pairs.iter().map(|p| p[k]).sum::<f64>() / pairs.len() as f64;
            let means = [mean(0), mean(1)];
            cells.push(Cell {
                medium,
                disturbed,
                geometry: geometry.to_owned(),
                beamformer: key.clone(),
                means,
                difference,
                reduction: statement.magnitude.and_then(|_| Interval::of(&reductions)),
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

/// Whether a claim is shown in each condition, or its opposite, with Holm's correction for their number.
fn rulings(cells: &[Cell], direction: Direction) -> Vec<Option<bool>> {
    let chances = |of: fn(&Interval) -> [f64; 2]| -> Vec<[f64; 2]> {
        let both: Vec<[f64; 2]> = cells.iter().map(|c| of(&c.difference)).collect();
        let [shown, opposite] =
            [0, 1].map(|k| holm(&both.iter().map(|p| p[k]).collect::<Vec<_>>()));
        shown
            .into_iter()
            .zip(opposite)
            .map(<[f64; 2]>::from)
            .collect()
    };
    // Two-sided, since either side is a finding.
    let corrected = match direction {
        Direction::Less => chances(|d| [d.chance_below(0.0), d.chance_above(0.0)].map(|p| 2.0 * p)),
        Direction::More => chances(|d| [d.chance_above(0.0), d.chance_below(0.0)].map(|p| 2.0 * p)),
        Direction::Same => chances(|d| {
            let beyond = d.chance_above(SAME).min(d.chance_below(-SAME));
            [d.chance_within(SAME), 2.0 * beyond]
        }),
    };
    let decide = |[shown, opposite]: [f64; 2]| decided(shown < LEVEL, opposite < LEVEL);
    corrected.into_iter().map(decide).collect()
}

fn decided(shown: bool, opposite: bool) -> Option<bool> {
    match (shown, opposite) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    }
}

fn verdict(statement: &Statement, cells: &[Cell]) -> Verdict {
    let shown = |cells: &[&Cell]| cells.iter().filter(|c| c.shown == Some(true)).count();
    let all: Vec<&Cell> = cells.iter().collect();
    let count = shown(&all);
    let opposite = cells.iter().filter(|c| c.shown == Some(false)).count();
    let ruling = if count == cells.len() {
        Ruling::Holds
    } else if count == 0 && opposite > 0 {
        Ruling::DoesNotHold
    } else if count == 0 {
        let few = cells.iter().any(|c| c.difference.scenes < FEWEST);
        Ruling::Open(match few {
            true => format!("fewer than {FEWEST} scenes a condition"),
            false => "no difference is significant, or none as large as is claimed".into(),
        })
    } else {
        Ruling::DependsOn(factor(cells))
    };
    let mut evidence = format!(
        "shown in {count} of {} conditions, the opposite in {opposite}.",
        cells.len()
    );
    // Where the paper has it: forward, the shortest time window in water and the longest in tissue.
    for medium in [Medium::Water, Medium::Tissue] {
        let forward = cells
            .iter()
            .filter(|c| c.medium == medium && !c.beamformer.contains("-fb"));
        let keys: Vec<&str> = forward.map(|c| &c.beamformer[..]).collect();
        let key = match medium {
            Medium::Water => keys.first(),
            Medium::Tissue => keys.last(),
        };
        let Some(key) = key else { continue };
        let window = key.rsplit("-k").next().unwrap_or_default();
        let of = |k: usize| {
            let chosen = cells
                .iter()
                .filter(|c| c.medium == medium && c.beamformer == *key);
            let values: Vec<f64> = chosen.map(|c| c.means[k]).collect();
            values.iter().sum::<f64>() / values.len() as f64
        };
        evidence += &format!(
            " {}, K = {window}: {} → {}.",
            medium.name(),
            number(Some(of(0))),
            number(Some(of(1)))
        );
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

/// The factor that tells best where the claim is shown, with its counts.
fn factor(cells: &[Cell]) -> String {
    type Level = fn(&Cell) -> String;
    let factors: [(&str, Level); 5] = [
        ("the medium", |c| c.medium.name().into()),
        ("disturbance", |c| disturbance(c.disturbed).into()),
        ("the geometry", |c| c.geometry.clone()),
        ("K", |c| {
            format!(
                "K = {}",
                c.beamformer.rsplit("-k").next().unwrap_or_default()
            )
        }),
        ("the covariance", |c| {
            let backward = c.beamformer.contains("-fb");
            if backward { "FB" } else { "forward" }.into()
        }),
    ];
    let mut best: Option<(f64, String)> = None;
    for (name, level) in factors {
        let mut counts: BTreeMap<String, [usize; 2]> = BTreeMap::new();
        for cell in cells {
            let entry = counts.entry(level(cell)).or_default();
            entry[0] += usize::from(cell.shown == Some(true));
            entry[1] += 1;
        }
        let shares = counts
            .values()
            .map(|[shown, of]| *shown as f64 / *of as f64);
        let [low, high] = shares.fold([1.0f64, 0.0f64], |[l, h], s| [l.min(s), h.max(s)]);
        if best.as_ref().is_none_or(|(range, _)| high - low > *range) {
            let counted = counts
                .iter()
                .map(|(level, [shown, of])| format!("{level} {shown} of {of}"));
            let counted: Vec<String> = counted.collect();
            best = Some((high - low, format!("{name}: {}", counted.join(", "))));
        }
    }
    best.map_or(String::new(), |(_, text)| text)
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

    /// Scenes whose ESMV is `factor(medium)` times DAS, which differs from seed to seed.
    fn scenes(factor: impl Fn(Medium) -> f64) -> Vec<SceneResult> {
        let mut all = Vec::new();
        for medium in [Medium::Water, Medium::Tissue] {
            for seed in 1..=8 {
                let das = 1.0 + 0.1 * seed as f64;
                let of = |key: &str, value: f64| SceneMeasure {
                    beamformer: key.into(),
                    b_mode: measure(value),
                    phase_symmetry: measure(value),
                    tuned: measure(value),
                };
                all.push(SceneResult {
                    geometry: "built-in".into(),
                    medium,
                    disturbed: false,
                    seed,
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
        let result = judge(scenes, Vec::new(), &claims);
        let found = result.claims.into_iter().find(|c| c.measure == measure);
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
        let expected = "the medium: tissue 0 of 1, water 1 of 1";
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
        // Two scenes decide nothing.
        let mut few = scenes(|_| 0.8);
        few.retain(|scene| scene.seed <= 2);
        assert!(matches!(ruling(few, std), Ruling::Open(_)));
    }
}
