//! Tables of the surface detectors.

use crate::experiments::study::*;
use std::ops::Range;

use super::condition::{Condition, Medium};
use super::judge::ClaimsResult;
use super::scene::{DETECTORS, SceneResult};

/// Ranges of the bone's echo above the tissue's RMS in quiet tissue, dB.
///
/// Each has about as many bones.
const RANGES: [Range<f64>; 3] = [0.0..20.0, 20.0..30.0, 30.0..f64::INFINITY];

/// F1 of a detector in each scene that has a surface or detected points.
fn f1<'a>(name: &str, scenes: impl IntoIterator<Item = &'a SceneResult>) -> Vec<f64> {
    let found = scenes.into_iter().flat_map(|s| &s.detectors);
    let found = found.filter(|(of, _)| of == name);
    found.filter_map(|(_, judged)| judged.f1()).collect()
}

/// F1 of the detectors by condition.
pub fn by_condition(result: &ClaimsResult) -> Table {
    let present = |condition: &Condition| result.scenes.iter().any(|s| s.condition == *condition);
    let row = |condition: Condition| {
        let scenes = || result.scenes.iter().filter(|s| s.condition == condition);
        let cell = |name| Interval::of_shares(f1(name, scenes()));
        (condition.title().to_owned(), DETECTORS.map(cell))
    };
    let conditions = Condition::ALL.into_iter().filter(present);
    table(
        "Surface detectors: F1 of points within 0.5 mm, at most one per line",
        conditions.map(row),
    )
}

/// F1 of the detectors by the bone's brightness, over all scenes in tissue.
///
/// Each bone counts once.
pub fn by_brightness(result: &ClaimsResult) -> Table {
    let row = |range: Range<f64>| {
        let inside = |scene: &&SceneResult| {
            let quiet = scene.condition == Condition::TissueQuiet;
            let brightness = scene.brightness.as_ref().filter(|_| quiet);
            brightness.is_some_and(|b| range.contains(&b.median_db))
        };
        let bones = result.scenes.iter().filter(inside);
        let bones: Vec<u64> = bones.map(|s| s.bone).collect();
        let cell = |name| {
            let of_bone = |bone: &u64| {
                let all = result.scenes.iter().filter(|s| s.bone == *bone);
                mean(f1(
                    name,
                    all.filter(|s| s.condition.medium() == Medium::Tissue),
                ))
            };
            Interval::of_shares(bones.iter().filter_map(of_bone))
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
        "Surface detectors in tissue, by the bone's echo above the tissue's RMS",
        RANGES.into_iter().map(row),
    )
}

fn table(
    title: &str,
    rows: impl Iterator<Item = (String, [Option<Interval>; DETECTORS.len()])>,
) -> Table {
    let row = |(name, cells): (String, [Option<Interval>; DETECTORS.len()])| {
        std::iter::once(name)
            .chain(cells.map(Interval::cell))
            .collect()
    };
    let head = std::iter::once("").chain(DETECTORS).collect();
    Table::new(title, head, rows.map(row))
}
