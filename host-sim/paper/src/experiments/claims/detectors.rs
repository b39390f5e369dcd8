//! Detectors of the surface beside each other.

use std::ops::Range;

use crate::experiments::common::interval::Interval;
use crate::experiments::outcome::Table;

use super::condition::{Condition, Medium};
use super::judge::ClaimsResult;
use super::scene::{DETECTORS, SceneResult};

/// The bone's echo over the tissue's RMS in quiet tissue, dB: ranges with as many bones each, about.
const RANGES: [Range<f64>; 3] = [0.0..20.0, 20.0..30.0, 30.0..f64::INFINITY];

/// F1 of a detector in scenes; none without surface and answers.
fn f1<'a>(name: &str, scenes: impl IntoIterator<Item = &'a SceneResult>) -> Vec<f64> {
    let found = scenes.into_iter().flat_map(|s| &s.detectors);
    let found = found.filter(|(of, _)| of == name);
    found.filter_map(|(_, judged)| judged.f1()).collect()
}

/// By condition.
pub fn by_condition(result: &ClaimsResult) -> Table {
    let present = |condition: &Condition| result.scenes.iter().any(|s| s.condition == *condition);
    let row = |condition: Condition| {
        let scenes = || result.scenes.iter().filter(|s| s.condition == condition);
        let cell = |name| Interval::of(&f1(name, scenes()));
        (condition.name().to_owned(), DETECTORS.map(cell))
    };
    let conditions = Condition::ALL.into_iter().filter(present);
    table(
        "Detectors of the surface: F1 of answers within 0.5 mm, at most one a line",
        conditions.map(row),
    )
}

/// By how bright the bone is, over all scenes in tissue. A bone counts once.
pub fn by_brightness(result: &ClaimsResult) -> Table {
    let row = |range: Range<f64>| {
        let inside = |scene: &&SceneResult| {
            let quiet = scene.condition == Condition::TissueQuiet;
            let brightness = scene.brightness.as_ref().filter(|_| quiet);
            brightness.is_some_and(|b| range.contains(&b.median_db))
        };
        let bones: Vec<u64> = result
            .scenes
            .iter()
            .filter(inside)
            .map(|s| s.bone)
            .collect();
        let cell = |name| {
            let mean = |bone: &u64| {
                let all = result.scenes.iter().filter(|s| s.bone == *bone);
                let values = f1(name, all.filter(|s| s.condition.medium() == Medium::Tissue));
                (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
            };
            Interval::of(&bones.iter().filter_map(mean).collect::<Vec<_>>())
        };
        let name = match range.end.is_finite() {
            true => format!("{} to {} dB", range.start, range.end),
            false => format!("above {} dB", range.start),
        };
        (
            format!("{name}, {} bones", bones.len()),
            DETECTORS.map(cell),
        )
    };
    table(
        "The same in tissue by the bone's echo over the tissue's RMS",
        RANGES.into_iter().map(row),
    )
}

fn table(
    title: &str,
    rows: impl Iterator<Item = (String, [Option<Interval>; DETECTORS.len()])>,
) -> Table {
    let text = |interval: Option<Interval>| interval.map_or("–".into(), |i| i.text());
    Table {
        title: title.into(),
        head: std::iter::once("").chain(DETECTORS).collect(),
        rows: rows
            .map(|(name, cells)| std::iter::once(name).chain(cells.map(text)).collect())
            .collect(),
        page_only: false,
    }
}
