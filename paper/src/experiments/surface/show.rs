//! The tables of the detectors.

use super::detectors::DETECTORS;
use super::disturb::Condition;
use crate::experiments::study::*;
use bonebeam_simulate::Bone;

/// The views, and the same layers without bone.
pub const FAMILIES: [(&str, Option<Bone<'static>>); 4] = [
    ("spinous processes", Some(Bone::SpinousProcesses)),
    ("laminae", Some(Bone::Laminae)),
    ("facet joint", Some(Bone::FacetJoint)),
    ("no bone", None),
];

/// Result of a detector in a scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneResult {
    pub family: &'static str,
    pub condition: Condition,
    pub detector: &'static str,
    pub judged: Judged,
}

pub fn outcome(seeds: u64, results: &[SceneResult]) -> Result<Outcome> {
    let tables = Condition::ALL
        .map(|condition| table(condition, results))
        .into();
    let parts = vec![Section::Text(format!(
        "Three views of the built-in spine under skin, fat, fasciae and muscle, {} seeds each, and the same layers \
         without bone; delay and sum unless a row has another beamformer, 60 dB. One answer or none a line, from 5 to 40 mm; a hit lies within 0.5 mm of the \
         surface that lines meet first, by the shortest way, in a line that meets it. Phase symmetry, onset and Foroughi 2007 answer with the largest value of a \
         line, from the threshold on that has the largest F1 over all of a table's frames: the best that is possible. \
         Paths have the prices of the yardstick. Intervals are Student's t over the frames with bone, 95 %.",
        seeds
    ))];
    Ok(Outcome {
        title: "The bone surface: detectors beside each other",
        parts,
        tables,
        data: data(&results)?,
        ..Outcome::default()
    })
}

fn table(condition: Condition, results: &[SceneResult]) -> Table {
    let rows = DETECTORS.iter().map(|detector| {
        let of = |family: Option<&str>| -> Vec<&Judged> {
            let scenes = results.iter().filter(|r| {
                let wanted = family.map_or(r.judged.surfaces > 0, |family| r.family == family);
                r.condition == condition && r.detector == detector.name && wanted
            });
            scenes.map(|r| &r.judged).collect()
        };
        let bones = of(None);
        let all = Judged::of_all(bones.iter().copied());
        let families = FAMILIES.each_ref();
        let families = families.map(|(family, _)| Judged::of_all(of(Some(family))));
        (detector.name, bones, families, all)
    });
    Table::of(
        format!("Bone surface: {}", condition.title()),
        rows,
        &[
            ("", |(name, ..)| (*name).to_owned()),
            ("precision", |(_, bones, ..)| {
                interval(bones, Judged::precision)
            }),
            ("recall", |(_, bones, ..)| interval(bones, Judged::recall)),
            ("recall, spinous processes", |(_, _, of, _)| {
                number(of[0].recall())
            }),
            ("laminae", |(_, _, of, _)| number(of[1].recall())),
            ("facet joint", |(_, _, of, _)| number(of[2].recall())),
            ("answers without bone", |(_, _, of, _)| {
                of[3].answers.to_string()
            }),
            ("mean of hits, mm", |(.., all)| number(all.mean_mm())),
            ("95th percentile, mm", |(.., all)| number(all.p95_mm())),
        ],
    )
}

/// The mean of a share over frames, with its interval.
pub fn interval(frames: &[&Judged], pick: fn(&Judged) -> Option<f64>) -> String {
    let values = frames.iter().filter_map(|judged| pick(judged));
    Interval::cell(Interval::of_shares(values))
}
