//! Parameters of a list of experiments: one section each, and a common part.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::Error as _;
use std::collections::BTreeMap;
use toml::de::{DeTable, ValueDeserializer};

use crate::{Error, Result};
use bonebeam_drive::check::References;
use bonebeam_files::settings::read_toml_with;

use super::{Common, Context, Experiment, Outcome, Overrides, Parameters, Progress};

/// All parameters of the main job, or of the paper.
pub struct Job {
    experiments: Vec<(&'static Kind, Box<dyn Stored>)>,
    common: Common,
    kept: Option<PathBuf>,
    merged: Vec<serde_json::Value>,
    references: Option<&'static References>,
}

/// Selected experiments of the paper; if empty, all.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct ExperimentFilter {
    /// Only experiments that show this figure of the paper, such as 2; repeatable
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub figure: Vec<u32>,

    /// Only experiments that show this table of the paper; repeatable
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub table: Vec<u32>,

    /// Only experiments that judge the paper's claims
    #[arg(long)]
    pub claims: bool,

    /// Only the experiment of this name, as in the sections of config.toml; repeatable
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub experiment: Vec<String>,
}

impl ExperimentFilter {
    fn takes(&self, kind: &Kind) -> bool {
        let none = self.figure.is_empty() && self.table.is_empty() && self.experiment.is_empty();
        (none && !self.claims)
            || self.experiment.iter().any(|name| name == kind.name)
            || self.figure.iter().any(|n| kind.figures.contains(n))
            || self.table.iter().any(|n| kind.tables.contains(n))
            || (self.claims && kind.claims)
    }

    /// Refuses selections that no experiment shows.
    fn check(&self, list: &[Kind]) -> Result<()> {
        let names: Vec<&str> = list.iter().map(|kind| kind.name).collect();
        if let Some(name) = self.experiment.iter().find(|n| !names.contains(&&n[..])) {
            return Err(Error::Usage(format!(
                "--experiment {name} is not one of {}",
                names.join(", ")
            )));
        }
        type Shown = fn(&Kind) -> &'static [u32];
        let kinds: [(&str, &[u32], Shown); 2] = [
            ("figure", &self.figure, |kind| kind.figures),
            ("table", &self.table, |kind| kind.tables),
        ];
        for (name, wanted, shown) in kinds {
            let known = || list.iter().flat_map(shown);
            if let Some(number) = wanted.iter().find(|n| !known().any(|k| k == *n)) {
                let known = match known().count() {
                    0 => "none".to_owned(),
                    _ => known().map(u32::to_string).collect::<Vec<_>>().join(", "),
                };
                return Err(Error::Usage(format!(
                    "--{name} {number} cannot be reproduced; those that can: {known}"
                )));
            }
        }
        Ok(())
    }
}

/// A row of a list of experiments.
pub struct Kind {
    name: &'static str,
    figures: &'static [u32],
    tables: &'static [u32],
    claims: bool,
    flags: &'static [&'static str],
    full: fn() -> Box<dyn Stored>,
    quick: fn() -> Box<dyn Stored>,
    read: fn(ValueDeserializer<'_>) -> std::result::Result<Box<dyn Stored>, toml::de::Error>,
}

impl Kind {
    /// The experiment of a type, which shows no part of the paper and has no flags.
    pub const fn of<E: Experiment + Parameters>() -> Self {
        Kind {
            name: E::NAME,
            figures: &[],
            tables: &[],
            claims: false,
            flags: &[],
            full: || resolved(E::default()),
            quick: || resolved(E::quick()),
            read: |section| Ok(resolved(E::deserialize(section)?)),
        }
    }

    /// It shows these figures of the paper.
    pub const fn figures(self, figures: &'static [u32]) -> Self {
        Kind { figures, ..self }
    }

    /// It shows these tables of the paper.
    pub const fn tables(self, tables: &'static [u32]) -> Self {
        Kind { tables, ..self }
    }

    /// It judges the paper's claims.
    pub const fn claims(self) -> Self {
        Kind {
            claims: true,
            ..self
        }
    }

    /// These flags of `host-sim paper` apply to it.
    ///
    /// They are some of `--mesh`, `--only`, `--keep` and `--merge`.
    pub const fn flags(self, flags: &'static [&'static str]) -> Self {
        Kind { flags, ..self }
    }
}

fn resolved<E: Experiment + Parameters>(mut experiment: E) -> Box<dyn Stored> {
    if let Some((simulation, receive, image)) = experiment.scanner() {
        receive.resolve(simulation);
        image.resolve_square();
    }
    experiment.resolve();
    Box::new(experiment)
}

/// An experiment whose parameters are written.
trait Stored: Experiment {
    fn overridden(&mut self, overrides: &Overrides);
    fn checked(&self) -> Result<()>;
    fn toml(&self) -> Result<String>;
    fn json(&self) -> Result<serde_json::Value>;
}

impl<E: Experiment + Parameters> Stored for E {
    fn overridden(&mut self, overrides: &Overrides) {
        if let (Some((simulation, ..)), Some(seed)) = (self.scanner(), overrides.seed) {
            simulation.seed = seed;
        }
        self.apply(overrides);
    }

    fn checked(&self) -> Result<()> {
        self.check()?;
        self.validate()
    }

    fn toml(&self) -> Result<String> {
        toml::to_string(&BTreeMap::from([(E::NAME, self)])).map_err(cannot_be_written)
    }

    fn json(&self) -> Result<serde_json::Value> {
        serde_json::to_value(self).map_err(cannot_be_written)
    }
}

impl Job {
    fn new(list: impl IntoIterator<Item = &'static Kind>, quick: bool) -> Self {
        let make = |kind: &'static Kind| match quick {
            true => (kind, (kind.quick)()),
            false => (kind, (kind.full)()),
        };
        Job {
            experiments: list.into_iter().map(make).collect(),
            common: match quick {
                true => Common::quick(),
                false => Common::default(),
            },
            kept: None,
            merged: Vec::new(),
            references: None,
        }
    }

    /// The full job: the paper's settings.
    pub fn full(list: &'static [Kind]) -> Self {
        Job::new(list, false)
    }

    /// A coarser job for a first look.
    pub fn quick(list: &'static [Kind]) -> Self {
        Job::new(list, true)
    }

    /// Reads a TOML file; keys that it lacks keep their defaults.
    ///
    /// # Errors
    /// As the configuration of the command.
    pub fn read(list: &'static [Kind], path: &Path) -> Result<Self> {
        read_toml_with(path, |text| {
            let mut job = Job::full(list);
            for (key, section) in DeTable::parse(text)?.into_inner() {
                job.read_section(key.get_ref(), section.into())?;
            }
            Ok(job)
        })
    }

    fn read_section(
        &mut self,
        name: &str,
        section: ValueDeserializer<'_>,
    ) -> std::result::Result<(), toml::de::Error> {
        let mut experiments = self.experiments.iter_mut();
        if let Some((kind, experiment)) = experiments.find(|(kind, _)| kind.name == name) {
            *experiment = (kind.read)(section)?;
        } else if !self.common.read(name, section)? {
            let known = self.kinds().map(|kind| kind.name);
            let known: Vec<&str> = known.chain(Common::SECTIONS).collect();
            return Err(toml::de::Error::custom(format!(
                "unknown section `{name}`, expected one of {}",
                known.join(", ")
            )));
        }
        Ok(())
    }

    /// Keeps the selected experiments and removes the rest.
    ///
    /// # Errors
    /// A figure or a table that no experiment shows.
    pub fn select(&mut self, filter: &ExperimentFilter, list: &[Kind]) -> Result<()> {
        filter.check(list)?;
        self.experiments.retain(|(kind, _)| filter.takes(kind));
        Ok(())
    }

    fn kinds(&self) -> impl Iterator<Item = &'static Kind> {
        self.experiments.iter().map(|(kind, _)| *kind)
    }

    /// Refuses given flags that concern no experiment of the job.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the flag and the experiments that it concerns.
    pub fn check_flags(&self, list: &[Kind], given: &[(&str, bool)]) -> Result<()> {
        for (flag, _) in given.iter().filter(|(_, given)| *given) {
            let concerns = |kind: &Kind| kind.flags.contains(flag);
            if self.kinds().any(concerns) {
                continue;
            }
            let wanted: Vec<&str> = self.kinds().map(|kind| kind.name).collect();
            let others = list.iter().filter(|kind| concerns(kind));
            let others: Vec<&str> = others.map(|kind| kind.name).collect();
            return Err(Error::Usage(format!(
                "{flag} has no effect on {}; it has on {}",
                wanted.join(", "),
                others.join(", ")
            )));
        }
        Ok(())
    }

    /// Sets the folder of recordings and long results.
    ///
    /// It is created with the first of them.
    pub fn keep_in(&mut self, folder: &Path) {
        self.kept = Some(folder.to_path_buf());
    }

    /// Compares results with these references.
    pub fn compare_with(&mut self, references: Option<&'static References>) {
        self.references = references;
    }

    /// Whether results are compared with references.
    pub fn compares(&self) -> bool {
        self.references.is_some()
    }

    /// Merges another run's parsed `report.json`.
    ///
    /// # Errors
    /// [`Error::Data`] for a report without data of an experiment that can merge them, or with data that it cannot
    /// merge.
    pub fn merge(&mut self, report: serde_json::Value) -> Result<()> {
        let takers = self.experiments.iter();
        for (kind, experiment) in takers.filter(|(kind, _)| kind.flags.contains(&"--merge")) {
            let name = kind.name;
            let data = report.get(name);
            let data =
                data.ok_or_else(|| Error::Data(format!("has no `{name}` of another run")))?;
            experiment.check_merged(data)?;
        }
        self.merged.push(report);
        Ok(())
    }

    /// Applies overrides of the command line.
    pub fn apply(&mut self, overrides: &Overrides) {
        let all = self.experiments.iter_mut();
        all.for_each(|(_, experiment)| experiment.overridden(overrides));
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the value and the expected range, or a file that cannot be read.
    pub fn validate(&self) -> Result<()> {
        self.common.validate()?;
        self.experiments.iter().try_for_each(|(_, e)| e.checked())
    }

    /// The parameters that the experiments share.
    pub fn common(&self) -> &Common {
        &self.common
    }

    /// Kind of job: "full", "quick", or "own" if the user changed a parameter.
    ///
    /// # Errors
    /// Parameters that cannot be written.
    pub fn kind(&self) -> Result<&'static str> {
        let own = self.toml()?;
        Ok(match own {
            own if own == Job::new(self.kinds(), false).toml()? => "full",
            own if own == Job::new(self.kinds(), true).toml()? => "quick",
            _ => "own",
        })
    }

    /// The configuration, which [`Job::read`] accepts.
    ///
    /// # Errors
    /// Parameters that cannot be written.
    pub fn toml(&self) -> Result<String> {
        let mut sections = Vec::new();
        for (_, experiment) in &self.experiments {
            sections.push(experiment.toml()?);
        }
        sections.push(toml::to_string(&self.common).map_err(cannot_be_written)?);
        Ok(sections.join("\n"))
    }

    /// The configuration by section, for `report.json`.
    ///
    /// # Errors
    /// Parameters that cannot be written.
    pub fn json(&self) -> Result<impl Serialize> {
        let mut sections = BTreeMap::new();
        for (kind, experiment) in &self.experiments {
            sections.insert(kind.name.to_owned(), experiment.json()?);
        }
        let common = serde_json::to_value(&self.common).map_err(cannot_be_written)?;
        if let serde_json::Value::Object(common) = common {
            sections.extend(common);
        }
        Ok(sections)
    }

    /// Runs every experiment of a valid job; returns name and outcome, in order.
    ///
    /// The outcome does not depend on the number of threads.
    ///
    /// # Errors
    /// Parameters that do not fit together.
    pub fn run(&self, progress: Progress<'_>) -> Result<Vec<(&'static str, Outcome)>> {
        let run = |(kind, experiment): &(&'static Kind, Box<dyn Stored>)| {
            let name = kind.name;
            let merged = self.merged.iter().filter_map(|report| report.get(name));
            let context = Context {
                common: &self.common,
                kept: self.kept.as_deref(),
                merged: &merged.cloned().collect::<Vec<_>>(),
                references: self.references,
                progress,
            };
            Ok((name, experiment.run(&context)?))
        };
        self.experiments.iter().map(run).collect()
    }
}

fn cannot_be_written(error: impl std::fmt::Display) -> Error {
    Error::Data(format!("the parameters cannot be written: {error}"))
}
