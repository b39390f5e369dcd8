//! The main job's report: a page for people, the numbers for programs, the pictures, the
//! configuration, and the tables for the terminal. It knows the parts of an outcome, not the
//! experiments.

mod figure;
mod html;
mod pictures;
mod plot;
mod tables;

pub use figure::figure;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use serde::Serialize;

use crate::Result;
use crate::experiments::outcome::{Comparison, Table};
use crate::experiments::{Job, Outcome};
use crate::files::atomic::Outputs;
use crate::files::image;
use crate::validate::Check;

/// The page.
const PAGE: &str = "report.html";
/// The numbers.
pub const DATA: &str = "report.json";
/// The configuration, which can be given back to the main job.
const CONFIGURATION: &str = "config.toml";

/// Everything in `report.json`.
#[derive(Serialize)]
struct Data<'a, P: Serialize> {
    program: &'static str,
    version: &'static str,
    job: &'static str,
    checks_passed: bool,
    parameters: P,
    comparisons: Vec<&'a Comparison>,
    checks: Vec<&'a Check>,
    #[serde(flatten)]
    experiments: BTreeMap<&'static str, &'a serde_json::Value>,
}

/// What a run of the main job leaves behind.
pub struct Report<'a> {
    job: &'a Job,
    kind: &'static str,
    outcomes: &'a [(&'static str, Outcome)],
}

impl<'a> Report<'a> {
    /// The report of a job's outcomes: name and outcome of each experiment.
    ///
    /// # Errors
    /// Parameters that cannot be written.
    pub fn new(job: &'a Job, outcomes: &'a [(&'static str, Outcome)]) -> Result<Self> {
        Ok(Report {
            job,
            kind: job.kind()?,
            outcomes,
        })
    }

    fn outcomes(&self) -> impl Iterator<Item = &'a Outcome> {
        self.outcomes.iter().map(|(_, outcome)| outcome)
    }

    fn checks(&self) -> Vec<&'a Check> {
        self.outcomes().flat_map(|o| &o.checks).collect()
    }

    fn comparisons(&self) -> Vec<&'a Comparison> {
        self.outcomes().flat_map(|o| &o.comparisons).collect()
    }

    /// The tables of every experiment.
    fn tables(&self) -> impl Iterator<Item = &'a Table> {
        self.outcomes().flat_map(|o| &o.tables)
    }

    /// Whether the core agreed with its references everywhere.
    pub fn checks_passed(&self) -> bool {
        self.checks().iter().all(|check| check.passed())
    }

    /// The tables, for the terminal.
    pub fn text(&self) -> String {
        let mut texts: Vec<String> = tables::comparisons(&self.comparisons())
            .iter()
            .map(tables::text)
            .collect();
        let shown = self.tables().filter(|table| !table.page_only);
        texts.extend(shown.map(tables::text));
        texts.push(tables::text(&tables::checks(&self.checks())));
        texts.join("\n")
    }

    /// Stages all files in `folder`; returns their names.
    ///
    /// # Errors
    /// A plot cannot be drawn or a file cannot be written.
    pub fn stage(&self, folder: &Path, outputs: &mut Outputs) -> Result<Vec<String>> {
        let mut names = Vec::new();
        for picture in self.outcomes().flat_map(|o| &o.pictures) {
            image::stage(&picture.pixels, &folder.join(&picture.file), outputs)?;
            names.push(picture.file.clone());
        }
        let data = Data {
            program: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            job: self.kind,
            checks_passed: self.checks_passed(),
            parameters: self.job.json()?,
            comparisons: self.comparisons(),
            checks: self.checks(),
            experiments: self.outcomes.iter().map(|(n, o)| (*n, &o.data)).collect(),
        };
        let page = html::page(self)?;
        outputs.stage(&folder.join(DATA), |sink| {
            serde_json::to_writer_pretty(&mut *sink, &data)?;
            Ok(writeln!(sink)?)
        })?;
        outputs.stage(&folder.join(PAGE), |sink| {
            Ok(sink.write_all(page.as_bytes())?)
        })?;
        outputs.stage(&folder.join(CONFIGURATION), |sink| {
            let version = env!("CARGO_PKG_VERSION");
            let toml = self.job.toml()?;
            Ok(write!(
                sink,
                "# host-sim {version}: the main job\n\n{toml}"
            )?)
        })?;
        names.extend([DATA, PAGE, CONFIGURATION].map(String::from));
        Ok(names)
    }
}
