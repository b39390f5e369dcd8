//! What a report shows: the outcomes of a job's experiments.

use super::tables;
use crate::Result;
use crate::experiments::outcome::{Comparison, Table, Verdict};
use crate::experiments::{Job, Outcome};
use bonebeam_oracle::verify::Check;

/// Which page a report has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Page {
    /// The main job's, with its pictures beside it.
    MainJob,
    /// The paper's: one file that holds its pictures, and a CSV of every table and number.
    Paper,
}

/// What a run leaves behind.
pub struct Report<'a> {
    pub(super) job: &'a Job,
    pub(super) kind: &'static str,
    pub(super) outcomes: &'a [(&'static str, Outcome)],
    pub(super) page: Page,
}

impl<'a> Report<'a> {
    /// The report of a job's outcomes: name and outcome of each experiment.
    ///
    /// # Errors
    /// Parameters that cannot be written.
    pub fn new(job: &'a Job, outcomes: &'a [(&'static str, Outcome)], page: Page) -> Result<Self> {
        Ok(Report {
            job,
            kind: job.kind()?,
            outcomes,
            page,
        })
    }

    pub(super) fn outcomes(&self) -> impl Iterator<Item = &'a Outcome> {
        self.outcomes.iter().map(|(_, outcome)| outcome)
    }

    pub(super) fn checks(&self) -> Vec<&'a Check> {
        self.outcomes().flat_map(|o| &o.checks).collect()
    }

    pub(super) fn comparisons(&self) -> Vec<&'a Comparison> {
        self.outcomes().flat_map(|o| &o.comparisons).collect()
    }

    pub(super) fn verdicts(&self) -> Vec<&'a Verdict> {
        self.outcomes().flat_map(|o| &o.verdicts).collect()
    }

    /// The tables of every experiment.
    pub(super) fn tables(&self) -> impl Iterator<Item = &'a Table> {
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
        if !self.checks().is_empty() {
            texts.push(tables::text(&tables::checks(&self.checks())));
        }
        if !self.verdicts().is_empty() {
            texts.push(tables::text(&tables::verdicts(&self.verdicts())));
        }
        texts.join("\n")
    }
}
