//! Tables, texts and pictures of the claims.

use crate::experiments::outcome::Ruling;
use crate::experiments::study::*;

use super::condition::Condition;
use super::detectors;
use super::judge::{Claim, ClaimsResult};
use super::population::Bone;
use super::scene::SceneMeasure;

/// The measure of the main claim.
const MAIN: &str = "PS, tuned: average precision";

/// The outcome of a result.
pub fn outcome(
    result: &ClaimsResult,
    bones: Vec<Section>,
    mechanism: Vec<Section>,
) -> Result<Outcome> {
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
    if !bones.is_empty() {
        parts.push(Section::Heading("The first two bones, disturbed"));
        parts.extend(bones);
    }
    if !mechanism.is_empty() {
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
        parts.extend(mechanism);
    }
    Ok(Outcome {
        title: "Do the claims hold?",
        answer: answer(result),
        parts,
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
        let name = cell.condition.title();
        if rows.last().is_none_or(|row| row[0] != name) {
            let mut row = vec!["–".to_owned(); result.beamformers.len()];
            name.clone_into(&mut row[0]);
            rows.push(row);
        }
        let mut columns = result.beamformers.iter();
        let column = columns.position(|(key, _)| *key == cell.beamformer);
        if let (Some(row), Some(column)) = (rows.last_mut(), column) {
            row[column] = cell.difference.text();
        }
    }
    Table::new(format!("{}: ESMV − DAS", claim.measure), head(result), rows).on_page()
}

/// Means of the main measures of DAS and every ESMV, with a uniform image.
fn absolute(result: &ClaimsResult) -> Table {
    type Of<T> = fn(&T) -> Option<f64>;
    /// A measure of a beamformer, and the same of a uniform image if it has a meaning there.
    type Measure = (&'static str, Of<SceneMeasure>, Option<Of<[BoneMeasure; 2]>>);
    #[rustfmt::skip]
    const MEASURES: [Measure; 10] = [
        ("US error, mm", |m| m.b_mode.mean_mm, Some(|u| u[0].mean_mm)),
        ("US STD, mm", |m| m.b_mode.std_mm, Some(|u| u[0].std_mm)),
        ("US B", |m| m.b_mode.intensity_b, None),
        ("US C", |m| m.b_mode.intensity_c, None),
        ("PS error, mm", |m| m.phase_symmetry.mean_mm, Some(|u| u[1].mean_mm)),
        ("PS STD, mm", |m| m.phase_symmetry.std_mm, Some(|u| u[1].std_mm)),
        ("PS B", |m| m.phase_symmetry.intensity_b, None),
        ("PS C", |m| m.phase_symmetry.intensity_c, None),
        ("average precision", |m| m.phase_symmetry.average_precision, Some(|u| u[1].average_precision)),
        ("tuned", |m| m.tuned.average_precision, None),
    ];
    let mut rows = Vec::new();
    for condition in Condition::ALL {
        let scenes = || result.scenes.iter().filter(|s| s.condition == condition);
        if scenes().next().is_none() {
            continue;
        }
        let mut row = |name: &str, cell: &dyn Fn(&Measure) -> Option<f64>| {
            let cells = MEASURES.iter().map(|measure| number(cell(measure)));
            let name = format!("{}, {name}", condition.title());
            rows.push(std::iter::once(name).chain(cells).collect());
        };
        for (key, name) in &result.beamformers {
            let found =
                || scenes().filter_map(|s| s.beamformers.iter().find(|m| m.beamformer == *key));
            row(name, &|(_, of, _)| mean(found().filter_map(of)));
        }
        row("a uniform image", &|(.., of)| {
            mean(scenes().filter_map(|s| of.as_ref()?(&s.uniform)))
        });
    }
    let head = std::iter::once("").chain(MEASURES.map(|(head, ..)| head));
    Table::new("Means over bones", head.collect(), rows)
}

fn tuned(result: &ClaimsResult) -> Table {
    let name = |key: &str| {
        let found = result.beamformers.iter().find(|(k, _)| k == key);
        found.map_or(key.to_owned(), |(_, name)| name.clone())
    };
    let rows = result.tuned.iter().map(|t| (name(&t.beamformer), t));
    Table::of(
        "The best filters, found on other bones",
        rows,
        &[
            ("", |(name, t)| format!("{}, {name}", t.medium)),
            ("scales", |(_, t)| {
                let scales = t.scales.iter().map(|s| format!("2^{}", s.log2()));
                scales.collect::<Vec<_>>().join(" ")
            }),
            ("threshold", |(_, t)| number(t.threshold)),
            ("dynamic range, dB", |(_, t)| number(t.dynamic_range)),
            ("average precision on them", |(_, t)| {
                number(t.average_precision)
            }),
            ("at an edge of the grid", |(_, t)| {
                if t.at_edge { "yes" } else { "no" }.to_owned()
            }),
        ],
    )
    .on_page()
}

fn zones(result: &ClaimsResult) -> Table {
    Table::of(
        "Mixed images, mean over scenes in tissue with its 95 % interval",
        &result.zones,
        &[
            ("", |(name, _)| name.clone()),
            ("mean", |(_, interval)| Interval::cell(*interval)),
        ],
    )
}

/// The bones, and the brightness of each over tissue.
fn population(result: &ClaimsResult) -> Table {
    let brightness = |bone: &Bone, condition: Condition| {
        let scene = result.scenes.iter();
        let mut scene = scene.filter(|s| s.bone == bone.number && s.condition == condition);
        Brightness::text(scene.next().and_then(|s| s.brightness.as_ref()))
    };
    let conditions = [Condition::TissueQuiet, Condition::TissueDisturbed];
    let bones = result.bones.iter();
    Table::of(
        "The bones, and their echo above the tissue's RMS in DAS (median; 10th to 90th percentile)",
        bones.map(|bone| (bone, conditions.map(|c| brightness(bone, c)))),
        &[
            ("", |(bone, _)| bone.number.to_string()),
            ("slice, mm", |(bone, _)| number(1e3 * bone.slice)),
            ("tilt, °", |(bone, _)| number(bone.tilt)),
            ("depth, mm", |(bone, _)| number(1e3 * bone.depth)),
            ("size", |(bone, _)| number(bone.shape.map(|s| s.scale))),
            ("spinous process", |(bone, _)| {
                number(bone.shape.map(|s| s.spinous_length))
            }),
            ("fall of the laminae, mm", |(bone, _)| {
                number(bone.shape.map(|s| s.lamina_fall))
            }),
            ("quiet, dB", |(_, [quiet, _])| quiet.clone()),
            ("disturbed, dB", |(_, [_, disturbed])| disturbed.clone()),
        ],
    )
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
