//! The main job's report: a page for people, the numbers for programs, the pictures, the
//! configuration, and the tables for the terminal.

mod comparison;
mod html;
mod pictures;
mod plot;
mod profiles;
mod text;

use std::io::Write;
use std::path::Path;

use serde::Serialize;

use crate::Result;
use crate::experiments::{Outcome, Parameters};
use crate::files::atomic::Outputs;
use crate::files::image;

use comparison::Comparison;

/// The page.
const PAGE: &str = "report.html";
/// The numbers.
pub const DATA: &str = "report.json";
/// The configuration, which can be given back to the main job.
const CONFIGURATION: &str = "config.toml";

/// Everything in `report.json`.
#[derive(Serialize)]
struct Data<'a> {
    program: &'static str,
    version: &'static str,
    job: &'static str,
    checks_passed: bool,
    parameters: &'a Parameters,
    comparisons: &'a [Comparison],
    #[serde(flatten)]
    outcome: &'a Outcome,
}

/// What a run of the main job leaves behind.
pub struct Report<'a> {
    parameters: &'a Parameters,
    outcome: &'a Outcome,
    comparisons: Vec<Comparison>,
}

impl<'a> Report<'a> {
    /// The report of an outcome.
    pub fn new(parameters: &'a Parameters, outcome: &'a Outcome) -> Self {
        Report {
            parameters,
            outcome,
            comparisons: comparison::comparisons(outcome),
        }
    }

    /// Which main job it was: "full", "quick", or "own" where a parameter is the user's.
    pub fn job(&self) -> &'static str {
        match self.parameters {
            p if *p == Parameters::default() => "full",
            p if *p == Parameters::quick() => "quick",
            _ => "own",
        }
    }

    /// Whether the core agreed with its references everywhere.
    pub fn checks_passed(&self) -> bool {
        self.outcome.checks.iter().all(|check| check.passed())
    }

    /// The tables, for the terminal.
    pub fn text(&self) -> String {
        let mut tables = text::comparison_tables(&self.comparisons);
        tables.extend(text::surface_tables(self.outcome));
        tables.push(text::check_table(&self.outcome.checks));
        let tables: Vec<String> = tables.iter().map(text::Table::text).collect();
        tables.join("\n")
    }

    /// Stages all files in `folder`; returns their names.
    ///
    /// # Errors
    /// A plot cannot be drawn or a file cannot be written.
    pub fn stage(&self, folder: &Path, outputs: &mut Outputs) -> Result<Vec<String>> {
        let mut names = Vec::new();
        let pairs = self.outcome.point.pictures.iter();
        for pair in pairs.chain(&self.outcome.vertebra.pictures) {
            for picture in [&pair.b_mode, &pair.phase_symmetry] {
                image::stage(&picture.pixels, &folder.join(&picture.file), outputs)?;
                names.push(picture.file.clone());
            }
        }
        let data = Data {
            program: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            job: self.job(),
            checks_passed: self.checks_passed(),
            parameters: self.parameters,
            comparisons: &self.comparisons,
            outcome: self.outcome,
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
            let toml = toml::to_string(self.parameters)?;
            Ok(write!(
                sink,
                "# host-sim {version}: the main job\n\n{toml}"
            )?)
        })?;
        names.extend([DATA, PAGE, CONFIGURATION].map(String::from));
        Ok(names)
    }
}
