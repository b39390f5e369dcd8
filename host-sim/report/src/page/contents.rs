//! Contents of a report: the outcomes of a job's experiments.

use super::tables;
use crate::experiments::outcome::{Coloured, Comparison, Picture, Table, Verdict};
use crate::experiments::{Job, Outcome};
use crate::{Error, Result};
use bonebeam_drive::check::Check;
use bonebeam_files::document::{is_marked, rewritten};

/// The live page.
pub const LIVE: &str = "live.html";

/// A kind of report: its page and its files.
#[derive(Debug)]
pub struct Page {
    /// Name of the kind, at the head of the configuration.
    pub name: &'static str,
    /// The page of a report.
    pub html: fn(&Report<'_>) -> Result<String>,
    /// The PNG of a picture.
    pub picture: fn(&Picture) -> Result<Vec<u8>>,
    /// The PNG of a coloured picture.
    pub coloured: fn(&Coloured) -> Result<Vec<u8>>,
    /// Whether tables and numbers are also written as CSV.
    pub spreadsheets: bool,
}

/// Report of a run.
pub struct Report<'a> {
    /// The parameters.
    pub job: &'a Job,
    /// "full", "quick" or "own".
    pub kind: &'static str,
    /// Name and outcome of each experiment.
    pub outcomes: &'a [(&'static str, Outcome)],
    pub(super) page: &'a Page,
    /// The live page of the vertebra, if it is built.
    pub live: Option<String>,
}

impl<'a> Report<'a> {
    /// The report of a job's outcomes: name and outcome of each experiment.
    ///
    /// # Errors
    /// Parameters that cannot be written.
    pub fn new(
        job: &'a Job,
        outcomes: &'a [(&'static str, Outcome)],
        page: &'a Page,
    ) -> Result<Self> {
        Ok(Report {
            job,
            kind: job.kind()?,
            outcomes,
            page,
            live: None,
        })
    }

    /// The outcomes.
    pub fn outcomes(&self) -> impl Iterator<Item = &'a Outcome> {
        self.outcomes.iter().map(|(_, outcome)| outcome)
    }

    /// The checks of every experiment.
    pub fn checks(&self) -> Vec<&'a Check> {
        self.outcomes().flat_map(|o| &o.checks).collect()
    }

    /// The comparisons of every experiment.
    pub fn comparisons(&self) -> Vec<&'a Comparison> {
        self.outcomes().flat_map(|o| &o.comparisons).collect()
    }

    /// The verdicts of every experiment.
    pub fn verdicts(&self) -> Vec<&'a Verdict> {
        self.outcomes().flat_map(|o| &o.verdicts).collect()
    }

    /// The tables of every experiment.
    pub(super) fn tables(&self) -> impl Iterator<Item = &'a Table> {
        self.outcomes().flat_map(|o| &o.tables)
    }

    /// Whether the core agreed with its references in every check.
    pub fn checks_passed(&self) -> bool {
        self.checks().iter().all(|check| check.passed())
    }

    /// Rewrites the tables of every experiment in a document.
    ///
    /// They are between its comments `<!-- NAME -->` and `<!-- end of NAME -->`, below `head`.
    ///
    /// # Errors
    /// A document without comments of any experiment.
    pub fn rewrite(&self, document: &str, head: &str) -> Result<String> {
        let mut text = document.to_owned();
        let mut found = false;
        for (name, outcome) in self.outcomes {
            if !is_marked(&text, name) {
                continue;
            }
            let verdicts: Vec<&Verdict> = outcome.verdicts.iter().collect();
            let verdicts = (!verdicts.is_empty()).then(|| tables::verdicts(&verdicts));
            let others = tables::every(outcome).into_iter();
            let all = verdicts
                .into_iter()
                .chain(others.filter(|table| !table.page_only));
            let tables: Vec<String> = all.map(|table| tables::markdown(&table)).collect();
            text = rewritten(&text, name, &format!("{head}\n\n{}", tables.join("\n")))?;
            found = true;
        }
        match found {
            true => Ok(text),
            false => Err(Error::Data(
                "has no comments `<!-- NAME -->` and `<!-- end of NAME -->` of an experiment that was run".into(),
            )),
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::MAIN_JOB;

    #[test]
    fn tables_stand_between_their_comments() {
        let job = Job::full(MAIN_JOB);
        let table = Table {
            title: "A table".into(),
            head: vec!["", "a", "b"],
            rows: vec![vec!["x".into(), "1".into(), "2".into()]],
            page_only: false,
        };
        let outcome = Outcome {
            tables: vec![table],
            ..Outcome::default()
        };
        let outcomes = [("point", outcome)];
        let report = Report::new(&job, &outcomes, &Page::MAIN_JOB).unwrap();
        let document = "before\n<!-- point -->\nold\n<!-- end of point -->\nafter\n";
        let expected = "\n\nHead.\n\n**A table**\n\n| | a | b |\n|---|---|---|\n| x | 1 | 2 |\n\n";
        let written = report.rewrite(document, "Head.").unwrap();
        let (_, tables) = written.split_once("before\n<!-- point -->").unwrap();
        assert!(tables.starts_with(expected), "{written}");
        let other = "<!-- vertebra -->\n<!-- end of vertebra -->";
        assert!(report.rewrite(other, "").is_err());
    }
}
