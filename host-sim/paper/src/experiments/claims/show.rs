//! What is shown of the claims.

use crate::Result;
use crate::experiments::Outcome;
use crate::experiments::common::interval::Interval;
use crate::experiments::outcome::{Attachment, Section, Table, data, number};

use super::judge::{Claim, ClaimsResult};
use super::mechanism::Figure;
use super::medium::{Medium, disturbance};

/// The outcome of a result.
///
/// # Errors
/// Numbers that cannot be written.
pub fn outcome(
    result: &ClaimsResult,
    bones: Figure,
    mechanism: Option<Figure>,
    mesh: Option<Attachment>,
) -> Result<Outcome> {
    let seeds = result.scenes.iter().map(|s| s.seed);
    let seeds: std::collections::BTreeSet<u64> = seeds.collect();
    let mut parts = vec![Section::Text(format!(
        "DAS and rank-1 ESMV on {} scenes of {} seeds: two bones (the built-in vertebra and a mesh) in water and \
         in tissue, each once quiet (noise at −60 dB) and once disturbed (noise at −40 dB, clutter in the bone's \
         shadow that is coherent over about three elements, a reverberation of the bone). A seed moves the bone by up to 1 mm each way and has tissue, clutter \
         and noise of its own. The scenes lie in the image plane alone. Rank 1 has K = 0, 2 and 10, forward (Eq. 5) \
         and forward-backward (FB). Each table has the mean of ESMV − DAS with its 95 % interval (paired, \
         Student's t over the scenes). A claim is shown in a condition where a two-sided test says so at 5 % after \
         Holm's correction for all conditions of the claim. A claim with a figure, as \"some 20 %\", also \
         needs an interval of the reduction that reaches it to within 5 points. Errors are the same where two one-sided \
         tests put their difference within ±0.2 mm.",
        result.scenes.len(),
        seeds.len()
    ))];
    parts.push(Section::Table(absolute(result)));
    for claim in &result.claims {
        parts.push(Section::Table(differences(claim, result)));
    }
    parts.push(Section::Table(tuned(result)));
    let mut pictures = bones.pictures;
    if !bones.parts.is_empty() {
        parts.push(Section::Heading("The two bones in disturbed water"));
        parts.extend(bones.parts);
    }
    if let Some(figure) = mechanism {
        parts.push(Section::Heading(
            "Where phase symmetry loses the bone in tissue",
        ));
        parts.push(Section::Text(
            "The image of DAS with one part of that of rank-1 ESMV (forward, the longest time window) put into it: \
             the echo of the surface (0.5 mm before it to 1.5 mm behind), what lies within 4 mm beside it at the \
             same depth, where its halos are, and the rest. Average precision of phase symmetry with the paper's \
             filter over all scenes in tissue:"
                .into(),
        ));
        parts.push(Section::Table(zones(result)));
        parts.extend(figure.parts);
        pictures.extend(figure.pictures);
    }
    Ok(Outcome {
        title: "Do the claims hold?",
        parts,
        pictures,
        verdicts: result.claims.iter().map(|c| c.verdict.clone()).collect(),
        files: mesh.into_iter().collect(),
        data: data(result)?,
        ..Outcome::default()
    })
}

fn condition(medium: Medium, disturbed: bool, geometry: &str) -> String {
    format!("{}, {}, {geometry}", medium.name(), disturbance(disturbed))
}

/// The columns of the tables: the beamformers but DAS.
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
        let name = condition(cell.medium, cell.disturbed, &cell.geometry);
        if rows.last().is_none_or(|row| row[0] != name) {
            let mut row = vec!["–".to_owned(); result.beamformers.len()];
            row[0].clone_from(&name);
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

/// Means of the main measures of DAS and of every ESMV, beside a uniform image.
fn absolute(result: &ClaimsResult) -> Table {
    let mut rows = Vec::new();
    for medium in [Medium::Water, Medium::Tissue] {
        for disturbed in [false, true] {
            let scenes: Vec<_> = result
                .scenes
                .iter()
                .filter(|s| s.medium == medium && s.disturbed == disturbed)
                .collect();
            if scenes.is_empty() {
                continue;
            }
            let mean = |values: Vec<f64>| {
                let n = values.len();
                (n > 0).then(|| values.iter().sum::<f64>() / n as f64)
            };
            let place = format!("{}, {}", medium.name(), disturbance(disturbed));
            for (key, name) in &result.beamformers {
                let found: Vec<_> = scenes
                    .iter()
                    .filter_map(|s| s.beamformers.iter().find(|m| m.beamformer == *key))
                    .collect();
                let over = |pick: fn(&super::scene::SceneMeasure) -> Option<f64>| {
                    number(mean(found.iter().filter_map(|m| pick(m)).collect()))
                };
                rows.push(vec![
                    format!("{place}, {name}"),
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
                let over =
                    |pick: fn(&crate::experiments::common::bone::BoneMeasure) -> Option<f64>| {
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
                format!("{place}, a uniform image"),
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
    }
    Table {
        title: "Means over seeds and geometries".into(),
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
            number(Some(t.average_precision)),
        ]
    };
    Table {
        title: "Filters that are best on other seeds".into(),
        head: vec!["", "scales", "threshold", "average precision there"],
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
