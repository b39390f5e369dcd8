//! The configuration, the tables and the numbers of a tuning.

use super::scenes::{CONDITIONS, Found, score};
use super::search::DETECTORS;
use super::{Candidate, JudgedBone, Tune};
use crate::experiments::study::*;
use crate::experiments::surface::disturb::Condition;
use bonebeam_files::document::rewritten;
use bonebeam_report::page::csv;
use bonebeam_report::page::tables::{markdown, text};

/// Index of DAS with the detector tuned alone, the reference for joint tuning.
const DETECTOR_ALONE: usize = 1;

/// Outputs of a tuning.
pub struct Shown {
    /// The best sections, as TOML.
    pub configuration: String,
    /// Every number.
    pub report: serde_json::Value,
    /// Every evaluation, one per line.
    pub evaluations: String,
    tables: [Table; 2],
}

/// Means over the judged bones, %.
#[derive(Serialize)]
struct Summary<'a> {
    #[serde(flatten)]
    candidate: &'a Candidate,
    /// F1 in each condition.
    f1: Vec<Option<Interval>>,
    /// Mean F1 of all conditions.
    mean_f1: Option<Interval>,
    /// Gain in F1 over DAS with the detector tuned alone, paired by bone.
    gain: Option<Interval>,
    precision: Option<f64>,
    recall: Option<f64>,
}

#[derive(Serialize)]
struct Report<'a> {
    program: &'static str,
    version: &'static str,
    parameters: &'a Tune,
    best: &'a str,
    candidates: &'a [Summary<'a>],
    bones: &'a [JudgedBone],
}

impl Shown {
    pub(super) fn new(tune: &Tune, candidates: &[Candidate], bones: &[JudgedBone]) -> Result<Self> {
        let all = candidates.iter().enumerate();
        let summaries: Vec<Summary<'_>> = all.map(|(k, c)| summary(c, k, bones)).collect();
        let wanted = |c: &&Candidate| tune.methods.contains(&c.sections.beamform.method);
        let wanted = candidates.iter().rev().filter(wanted);
        let best = wanted.max_by(|a, b| a.score.total_cmp(&b.score));
        let best = best.unwrap_or(&candidates[DETECTOR_ALONE]);
        let report = Report {
            program: "host-sim tune",
            version: env!("CARGO_PKG_VERSION"),
            parameters: tune,
            best: &best.name,
            candidates: &summaries,
            bones,
        };
        Ok(Shown {
            configuration: best.sections.toml()?,
            report: data(&report)?,
            evaluations: csv(&evaluations(candidates)),
            tables: [judged(&summaries, tune), values(candidates)?],
        })
    }

    /// The tables, for the terminal.
    pub fn text(&self) -> String {
        format!("{}\n{}", text(&self.tables[0]), text(&self.tables[1]))
    }

    /// Rewrites the tables in a document, under `head`.
    ///
    /// They are between its comments `<!-- tune -->` and `<!-- end of tune -->`.
    ///
    /// # Errors
    /// A document without those comments.
    pub fn rewrite(&self, document: &str, head: &str) -> Result<String> {
        let [judged, values] = self.tables.each_ref().map(markdown);
        rewritten(document, "tune", &format!("{head}\n\n{judged}\n{values}"))
    }
}

fn summary<'a>(candidate: &'a Candidate, k: usize, bones: &[JudgedBone]) -> Summary<'a> {
    let by_bone =
        |of: &dyn Fn(&JudgedBone) -> f64| Interval::of(bones.iter().map(|bone| 100.0 * of(bone)));
    let all = bones.iter().flat_map(|bone| &bone.found[k]);
    let all = Judged::of_all(all.map(|found| &found.judged));
    let f1 = CONDITIONS.into_iter().map(|condition| {
        let is = |found: &&Found| found.condition == condition;
        by_bone(&|bone| score(bone.found[k].iter().filter(is)))
    });
    Summary {
        candidate,
        f1: f1.collect(),
        mean_f1: by_bone(&|bone| score(&bone.found[k])),
        gain: by_bone(&|bone| score(&bone.found[k]) - score(&bone.found[DETECTOR_ALONE])),
        precision: all.precision(),
        recall: all.recall(),
    }
}

fn judged(summaries: &[Summary<'_>], tune: &Tune) -> Table {
    let row = |s: &Summary<'_>| {
        let shares = [s.precision, s.recall, Some(s.candidate.score)];
        std::iter::once(s.candidate.name.clone())
            .chain(s.f1.iter().map(|i| number(i.map(|i| i.mean))))
            .chain([s.mean_f1, s.gain].map(Interval::cell))
            .chain(shares.map(|share| number(share.map(|share| 100.0 * share))))
            .collect()
    };
    let title = format!(
        "F1 of the bone surface, %, on {} bones that no tuning saw; tuned on {} others by {} evaluations for each \
         method, {} for the detector alone, seed {}",
        tune.bones,
        tune.bones,
        tune.evaluations,
        tune.evaluations.saturating_mul(DETECTORS),
        tune.seed
    );
    let conditions = CONDITIONS.map(Condition::name);
    let rest = [
        "mean (95 %)",
        "less DAS, detector tuned (95 %)",
        "precision, %",
        "recall, %",
        "F1 on the tuning bones",
    ];
    let head = std::iter::once("").chain(conditions).chain(rest);
    Table::new(title, head.collect(), summaries.iter().map(row))
}

/// The keys of all candidates, each once.
fn keys(candidates: &[Candidate]) -> Vec<&'static str> {
    let mut keys: Vec<&'static str> = Vec::new();
    for variable in candidates.iter().flat_map(|c| &c.variables) {
        if !keys.contains(&variable.key) {
            keys.push(variable.key);
        }
    }
    keys
}

/// The value of each key; empty for keys that are not tuned.
fn by_key(candidate: &Candidate, keys: &[&str], values: &[f64]) -> Vec<String> {
    let value = |key: &&str| {
        let position = candidate.variables.iter().position(|v| v.key == *key);
        position.map_or(String::new(), |k| values[k].to_string())
    };
    keys.iter().map(value).collect()
}

fn values(candidates: &[Candidate]) -> Result<Table> {
    let keys = keys(candidates);
    let tuned = candidates.iter().filter(|c| !c.variables.is_empty());
    let row = |candidate: &Candidate| {
        let values = candidate.sections.values(&candidate.variables)?;
        let mut row = vec![candidate.name.clone()];
        row.extend(by_key(candidate, &keys, &values));
        Ok(row)
    };
    let rows = tuned.map(row).collect::<Result<Vec<_>>>()?;
    let title = "Tuned values; `sub_lines`: 0 as many as the recording asks for, 1 one, 2 two";
    let head = std::iter::once("").chain(keys.iter().copied());
    Ok(Table::new(title, head.collect(), rows))
}

fn evaluations(candidates: &[Candidate]) -> Vec<Vec<String>> {
    let keys = keys(candidates);
    let head = ["search", "evaluation", "score"].into_iter();
    let mut lines: Vec<Vec<String>> =
        vec![head.chain(keys.iter().copied()).map(String::from).collect()];
    for candidate in candidates {
        for (n, evaluation) in candidate.evaluations.iter().enumerate() {
            let mut line = vec![candidate.name.clone(), (n + 1).to_string()];
            line.push(evaluation.score.to_string());
            line.extend(by_key(candidate, &keys, &evaluation.values));
            lines.push(line);
        }
    }
    lines
}
