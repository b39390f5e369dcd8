//! The report of a job.
//!
//! A page for readers, the numbers for programs, the pictures, the configuration, and the tables for the terminal.
//! It uses the parts of an outcome, not the experiments.

pub mod axes;
pub mod bar;
pub mod colours;
mod contents;
mod embedded;
mod figure;
pub mod html;
mod numbers;
pub mod pictures;
mod plot;
pub mod tables;

pub use contents::{LIVE, Page, Report};
pub use embedded::base64;
pub use figure::figure;
pub use numbers::csv;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use serde::Serialize;

use crate::experiments::Outcome;
use crate::experiments::outcome::{Coloured, Comparison, Section, Verdict};
use crate::{Error, Result};
use bonebeam_drive::check::Check;
use bonebeam_files::atomic::Outputs;

/// The page.
const PAGE: &str = "report.html";
/// The numbers.
pub const DATA: &str = "report.json";
/// The configuration, which the main job accepts.
const CONFIGURATION: &str = "config.toml";

/// Every number of the paper's experiments, one per line.
const NUMBERS: &str = "numbers.csv";

/// Content of `report.json`.
#[derive(Serialize)]
struct Data<'a, P: Serialize> {
    program: &'static str,
    version: &'static str,
    job: &'static str,
    /// None if nothing was compared.
    checks_passed: Option<bool>,
    parameters: P,
    comparisons: Vec<&'a Comparison>,
    checks: Vec<&'a Check>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    verdicts: Vec<&'a Verdict>,
    #[serde(flatten)]
    experiments: BTreeMap<&'static str, &'a serde_json::Value>,
}

impl Report<'_> {
    /// Stages all files in `folder`; returns their names.
    ///
    /// # Errors
    /// A plot cannot be drawn or a file cannot be written.
    pub fn add_to(&self, folder: &Path, outputs: &mut Outputs) -> Result<Vec<String>> {
        let mut names = Vec::new();
        let mut add = |name: &str, bytes: &[u8]| {
            names.push(name.to_owned());
            outputs.add(&folder.join(name), |sink| Ok(sink.write_all(bytes)?))
        };
        for picture in self.outcomes().flat_map(Outcome::pictures) {
            add(&picture.file, &(self.page.picture)(picture)?)?;
        }
        let data = Data {
            program: "host-sim",
            version: env!("CARGO_PKG_VERSION"),
            job: self.kind,
            checks_passed: self.job.compares().then(|| self.checks_passed()),
            parameters: self.job.json()?,
            comparisons: self.comparisons(),
            checks: self.checks(),
            verdicts: self.verdicts(),
            experiments: self.outcomes.iter().map(|(n, o)| (*n, &o.data)).collect(),
        };
        for attachment in self.outcomes().flat_map(|o| &o.files) {
            add(&attachment.file, &attachment.bytes)?;
        }
        for shown in self.outcomes().flat_map(coloured) {
            add(&shown.picture.file, &(self.page.coloured)(shown)?)?;
        }
        let page = (self.page.html)(self)?;
        if self.page.spreadsheets {
            for (name, contents) in self.spreadsheets(&data.experiments)? {
                add(&name, contents.as_bytes())?;
            }
        }
        let cannot = |e| Error::Data(format!("the numbers cannot be written: {e}"));
        let json = serde_json::to_string_pretty(&data).map_err(cannot)?;
        add(DATA, format!("{json}\n").as_bytes())?;
        if let Some(live) = &self.live {
            add(LIVE, live.as_bytes())?;
        }
        add(PAGE, page.as_bytes())?;
        let (version, name) = (data.version, self.page.name);
        let configuration = format!("# host-sim {version}: {name}\n\n{}", self.job.toml()?);
        add(CONFIGURATION, configuration.as_bytes())?;
        Ok(names)
    }

    /// Every table and every number as CSV, with their files' names.
    fn spreadsheets(
        &self,
        data: &BTreeMap<&'static str, &serde_json::Value>,
    ) -> Result<Vec<(String, String)>> {
        let mut sheets = vec![(NUMBERS.to_owned(), numbers::every(data))];
        for (name, outcome) in self.outcomes {
            for (k, table) in tables::every(outcome).iter().enumerate() {
                let file = format!("{name}-table-{}.csv", k + 1);
                sheets.push((file, numbers::table(table)));
            }
        }
        Ok(sheets)
    }
}

/// The pictures of an outcome that are in colours.
fn coloured(outcome: &Outcome) -> impl Iterator<Item = &Coloured> {
    let parts = outcome.parts.iter().filter_map(|part| match part {
        Section::Coloured(all) => Some(all),
        _ => None,
    });
    parts.flatten()
}
