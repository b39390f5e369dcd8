//! Tables, texts and pictures of the claims.

use crate::Result;
use crate::experiments::Outcome;
use crate::experiments::common::brightness::Brightness;
use crate::experiments::common::interval::Interval;
use crate::experiments::outcome::{Ruling, Section, Table, data, number};

use super::condition::Condition;
use super::detectors;
use super::judge::{Claim, ClaimsResult};
use super::mechanism::Figure;
use super::population::Bone;

/// The measure of the main claim.
const MAIN: &str = "PS, tuned: average precision";

/// The outcome of a result.
///
/// # Errors
/// Numbers that cannot be written.
pub fn outcome(result: &ClaimsResult, bones: Figure, mechanism: Option<Figure>) -> Result<Outcome> {
    let mut parts = vec![Section::Text(format!(
        "DAS and rank-1 ESMV on {} bones in up to {} conditions, {} scenes. Each bone has its own shape (size, \
         width, spinous process, laminae, facets, sides), slice, tilt, depth, roughness, tissue level, clutter \
         and noise. Water and tissue are each quiet (noise at −60 dB) or disturbed (noise at −40 dB, clutter \
         in the bone's shadow that is coherent over about six elements, a reverberation of the bone). \
         Disturbed tissue has further conditions: layers with fasciae, attenuation, aberration on receive, and \
         beamforming with a speed of sound that is 2 % off (depths are those of the true one). Scenes lie in \
         the image plane, except those in 3-D: some of the bones as volumes, by an array with a lens. Each \
         table gives the mean of ESMV − DAS with its 95 % interval (paired, Student's t over the bones). A \
         claim is shown in a condition if a two-sided test shows it at 5 % after Holm's correction for all \
         cells of the claim. A verdict counts each condition once, by the paper's beamformer: forward (Eq. 5), \
         K = 0 in water, K = 10 in tissue. A claim with a number, such as \"some 20 %\", also needs an \
         interval of the reduction that reaches it to within 5 points. Errors are equal if two one-sided tests \
         put their difference within ±0.2 mm.",
        result.bones.len(),
        Condition::ALL.len(),
        result.scenes.len(),
    ))];
    parts.push(Section::Table(population(result)));
    parts.push(Section::Table(detectors::by_condition(result)));
    parts.push(Section::Table(detectors::by_brightness(result)));
    parts.push(Section::Table(absolute(result)));
    for claim in &result.claims {
        parts.push(Section::Table(differences(claim, result)));
    }
    parts.push(Section::Table(tuned(result)));
    let mut pictures = bones.pictures;
    if !bones.parts.is_empty() {
        parts.push(Section::Heading("The first two bones, disturbed"));
        parts.extend(bones.parts);
    }
    if let Some(figure) = mechanism {
        parts.push(Section::Heading(
            "Where phase symmetry loses the bone in tissue",
        ));
        parts.push(Section::Text(
            "One part of the DAS image is replaced by that of rank-1 ESMV (forward, the longest time window): \
             the echo of the surface (0.5 mm before it to 1.5 mm behind), the halos (within 4 mm beside it at \
             the same depth), or the rest. Average precision of phase symmetry with the paper's filter over \
             all scenes in tissue:"
                .into(),
        ));
        parts.push(Section::Table(zones(result)));
        parts.extend(figure.parts);
        pictures.extend(figure.pictures);
    }
    Ok(Outcome {
        title: "Do the claims hold?",
        answer: answer(result),
        parts,
        pictures,
        verdicts: result.claims.iter().map(|c| c.verdict.clone()).collect(),
        data: data(result)?,
        ..Outcome::default()
    })
}

/// Columns of the tables: the beamformers but DAS.
fn head(result: &ClaimsResult) -> Vec<&'static str> {
    // Tables have heads that live as long as the program; the names here are few and known.
    let name = |key: &str| match key {
        "esmv-rank1-k0" => "K = 0",
        "esmv-rank1-fb-k0" => "K = 0, FB",
        "esmv-rank1-k2" => "K = 2",
        "esmv-rank1-fb-k2" => "K = 2, FB",
        "esmv-rank1-k10" => "K = 10",
        "esmv-rank1-fb-k10" => "K = 10, FB",
        key if key.contains("-fb") => "own K, FB",
        _ => "own K",
    };
    let keys = result.beamformers.iter().skip(1);
    let names = keys.map(|(key, _)| name(key));
    std::iter::once("").chain(names).collect()
}

fn differences(claim: &Claim, result: &ClaimsResult) -> Table {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for cell in &claim.cells {
        let name = cell.condition.name();
        if rows.last().is_none_or(|row| row[0] != name) {
            let mut row = vec!["–".to_owned(); result.beamformers.len()];
            name.clone_into(&mut row[0]);
            rows.push(row);
        }
        let column = result
            .beamformers
            .iter()
            .position(|(k, _)| *k == cell.beamformer);
        if let (Some(row), Some(column)) = (rows.last_mut(), column) {
            row[column] = cell.difference.text();
        }
    }
    Table {
        title: format!("{}: ESMV − DAS", claim.measure),
        head: head(result),
        rows,
        page_only: true,
    }
}

/// Means of the main measures of DAS and every ESMV, with a uniform image.
fn absolute(result: &ClaimsResult) -> Table {
    let mut rows = Vec::new();
    for condition in Condition::ALL {
        let scenes: Vec<_> = result
            .scenes
            .iter()
            .filter(|s| s.condition == condition)
            .collect();
        if scenes.is_empty() {
            continue;
        }
        let mean = |values: Vec<f64>| {
            let n = values.len();
            (n > 0).then(|| values.iter().sum::<f64>() / n as f64)
        };
        let position = condition.name();
        for (key, name) in &result.beamformers {
            let found: Vec<_> = scenes
                .iter()
                .filter_map(|s| s.beamformers.iter().find(|m| m.beamformer == *key))
                .collect();
            let over = |pick: fn(&super::scene::SceneMeasure) -> Option<f64>| {
                number(mean(found.iter().filter_map(|m| pick(m)).collect()))
            };
            rows.push(vec![
                format!("{position}, {name}"),
                over(|m| m.b_mode.mean_mm),
                over(|m| m.b_mode.std_mm),
                over(|m| m.b_mode.intensity_b),
                over(|m| m.b_mode.intensity_c),
                over(|m| m.phase_symmetry.mean_mm),
                over(|m| m.phase_symmetry.std_mm),
                over(|m| m.phase_symmetry.intensity_b),
                over(|m| m.phase_symmetry.intensity_c),
                over(|m| m.phase_symmetry.average_precision),
                over(|m| m.tuned.average_precision),
            ]);
        }
        let even = |image: usize| {
            let over = |pick: fn(&crate::experiments::common::bone::BoneMeasure) -> Option<f64>| {
                number(mean(
                    scenes
                        .iter()
                        .filter_map(|s| pick(&s.uniform[image]))
                        .collect(),
                ))
            };
            [
                over(|m| m.mean_mm),
                over(|m| m.std_mm),
                over(|m| m.average_precision),
            ]
        };
        let ([error, std, _], [ps_error, ps_std, precision]) = (even(0), even(1));
        let none = || "–".to_owned();
        rows.push(vec![
            format!("{position}, a uniform image"),
            error,
            std,
            none(),
            none(),
            ps_error,
            ps_std,
            none(),
            none(),
            precision,
            none(),
        ]);
    }
    Table {
        title: "Means over bones".into(),
        head: vec![
            "",
            "US error, mm",
            "US STD, mm",
            "US B",
            "US C",
            "PS error, mm",
            "PS STD, mm",
            "PS B",
            "PS C",
            "average precision",
            "tuned",
        ],
        rows,
        page_only: false,
    }
}

fn tuned(result: &ClaimsResult) -> Table {
    let name = |key: &str| {
        let found = result.beamformers.iter().find(|(k, _)| k == key);
        found.map_or(key.to_owned(), |(_, name)| name.clone())
    };
    let row = |t: &super::tuning::Tuned| {
        let scales: Vec<String> = t.scales.iter().map(|s| format!("2^{}", s.log2())).collect();
        vec![
            format!("{}, {}", t.medium.name(), name(&t.beamformer)),
            scales.join(" "),
            number(Some(t.threshold)),
            number(Some(t.dynamic_range)),
            number(Some(t.average_precision)),
            if t.at_edge { "yes" } else { "no" }.to_owned(),
        ]
    };
    Table {
        title: "The best filters, found on other bones".into(),
        head: vec![
            "",
            "scales",
            "threshold",
            "dynamic range, dB",
            "average precision on them",
            "at an edge of the grid",
        ],
        rows: result.tuned.iter().map(row).collect(),
        page_only: true,
    }
}

fn zones(result: &ClaimsResult) -> Table {
    let text =
        |interval: &Option<Interval>| interval.map_or("–".into(), |interval| interval.text());
    Table {
        title: "Mixed images, mean over scenes in tissue with its 95 % interval".into(),
        head: vec!["", "mean"],
        rows: result
            .zones
            .iter()
            .map(|(name, interval)| vec![name.clone(), text(interval)])
            .collect(),
        page_only: false,
    }
}

/// The bones, and the brightness of each over tissue.
fn population(result: &ClaimsResult) -> Table {
    let row = |bone: &Bone| {
        let brightness = |condition: Condition| {
            let scene = result.scenes.iter();
            let mut scene = scene.filter(|s| s.bone == bone.number && s.condition == condition);
            Brightness::text(scene.next().and_then(|s| s.brightness.as_ref()))
        };
        vec![
            bone.number.to_string(),
            number(Some(1e3 * bone.slice)),
            number(Some(bone.tilt)),
            number(Some(1e3 * bone.depth)),
            number(bone.shape.map(|s| s.scale)),
            number(bone.shape.map(|s| s.spinous_length)),
            number(bone.shape.map(|s| s.lamina_fall)),
            brightness(Condition::TissueQuiet),
            brightness(Condition::TissueDisturbed),
        ]
    };
    Table {
        title: "The bones, and their echo above the tissue's RMS in DAS (median; 10th to 90th percentile)".into(),
        head: vec![
            "",
            "slice, mm",
            "tilt, °",
            "depth, mm",
            "size",
            "spinous process",
            "fall of the laminae, mm",
            "quiet, dB",
            "disturbed, dB",
        ],
        rows: result.bones.iter().map(row).collect(),
        page_only: false,
    }
}

/// The answer: counts of the claims' verdicts, and the verdict of the main claim.
fn answer(result: &ClaimsResult) -> String {
    let count = |wanted: fn(&Ruling) -> bool| {
        let rulings = result.claims.iter().map(|c| &c.verdict.ruling);
        rulings.filter(|ruling| wanted(ruling)).count()
    };
    let main = result.claims.iter().find(|c| c.measure == MAIN);
    let main = main.map_or(String::new(), |claim| {
        let verdict = match &claim.verdict.ruling {
            Ruling::Holds => "better than on DAS in every condition",
            Ruling::DoesNotHold => "no better than on DAS in any condition, and worse in some",
            Ruling::DependsOn(_) => "better than on DAS in some conditions only",
            Ruling::Open(_) => "neither significantly better nor significantly worse than on DAS",
        };
        format!(" With the best filter for each beamformer, phase symmetry on rank-1 ESMV finds the bone's surface {verdict}.")
    });
    format!(
        "Of {} claims of the paper, {} hold in every condition tried here, {} in some, {} in none, and {} stay open.{main}",
        result.claims.len(),
        count(|r| *r == Ruling::Holds),
        count(|r| matches!(r, Ruling::DependsOn(_))),
        count(|r| *r == Ruling::DoesNotHold),
        count(|r| matches!(r, Ruling::Open(_))),
    )
}
