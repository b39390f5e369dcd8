//! Parameters of a list of experiments: one section each, and a common part.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::Error as _;
use std::collections::BTreeMap;
use toml::de::{DeTable, ValueDeserializer};

use crate::{Error, Result};
use bonebeam_drive::check::References;
use bonebeam_files::settings::read_toml_with;

use super::{Common, Context, Covers, Experiment, Outcome, Overrides, Progress};

/// All parameters of the main job, or of the paper.
pub struct Job {
    list: Vec<&'static Kind>,
    experiments: Vec<Box<dyn AnyExperiment>>,
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
        let covers = &kind.covers;
        let none = self.figure.is_empty() && self.table.is_empty() && self.experiment.is_empty();
        (none && !self.claims)
            || self.experiment.iter().any(|name| name == kind.name)
            || self.figure.iter().any(|n| covers.figures.contains(n))
            || self.table.iter().any(|n| covers.tables.contains(n))
            || (self.claims && covers.claims)
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
        let figures: Vec<u32> = list
            .iter()
            .flat_map(|k| k.covers.figures)
            .copied()
            .collect();
        let tables: Vec<u32> = list.iter().flat_map(|k| k.covers.tables).copied().collect();
        for (name, wanted, known) in [
            ("figure", &self.figure, figures),
            ("table", &self.table, tables),
        ] {
            if let Some(number) = wanted.iter().find(|n| !known.contains(n)) {
                let known: Vec<String> = known.iter().map(u32::to_string).collect();
                let known = match known.is_empty() {
                    true => "none".to_owned(),
                    false => known.join(", "),
                };
                return Err(Error::Usage(format!(
                    "--{name} {number} cannot be reproduced; those that can: {known}"
                )));
            }
        }
        Ok(())
    }
}

/// Constructor of an experiment in the list.
pub struct Kind {
    name: &'static str,
    covers: Covers,
    flags: &'static [&'static str],
    full: fn() -> Box<dyn AnyExperiment>,
    quick: fn() -> Box<dyn AnyExperiment>,
}

impl Kind {
    /// The experiment of a type.
    pub const fn of<E: Experiment>() -> Self {
        Kind {
            name: E::NAME,
            covers: E::COVERS,
            flags: E::FLAGS,
            full: || resolved(E::default()),
            quick: || resolved(E::quick()),
        }
    }
}

fn resolved<E: Experiment>(mut experiment: E) -> Box<dyn AnyExperiment> {
    experiment.resolve();
    Box::new(experiment)
}

/// An [`Experiment`] of any type.
trait AnyExperiment {
    fn name(&self) -> &'static str;
    /// The experiment with the parameters of a section.
    fn read(
        &self,
        section: ValueDeserializer<'_>,
    ) -> std::result::Result<Box<dyn AnyExperiment>, toml::de::Error>;
    fn toml(&self) -> Result<String>;
    fn json(&self) -> Result<serde_json::Value>;
    fn apply(&mut self, overrides: &Overrides);
    fn validate(&self) -> Result<()>;
    fn check_merged(&self, data: &serde_json::Value) -> Result<()>;
    fn run(&self, context: &Context<'_>) -> Result<Outcome>;
}

impl<E: Experiment> AnyExperiment for E {
    fn name(&self) -> &'static str {
        E::NAME
    }

    fn read(
        &self,
        section: ValueDeserializer<'_>,
    ) -> std::result::Result<Box<dyn AnyExperiment>, toml::de::Error> {
        Ok(resolved(E::deserialize(section)?))
    }

    fn toml(&self) -> Result<String> {
        toml::to_string(&BTreeMap::from([(E::NAME, self)])).map_err(cannot_be_written)
    }

    fn json(&self) -> Result<serde_json::Value> {
        serde_json::to_value(self).map_err(cannot_be_written)
    }

    fn apply(&mut self, overrides: &Overrides) {
        Experiment::apply(self, overrides);
    }

    fn validate(&self) -> Result<()> {
        Experiment::validate(self)
    }

    fn check_merged(&self, data: &serde_json::Value) -> Result<()> {
        Experiment::check_merged(self, data)
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        Experiment::run(self, context)
    }
}

impl Job {
    fn new(list: Vec<&'static Kind>, quick: bool) -> Self {
        let make = |kind: &&Kind| match quick {
            true => (kind.quick)(),
            false => (kind.full)(),
        };
        Job {
            experiments: list.iter().map(make).collect(),
            list,
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
        Job::new(list.iter().collect(), false)
    }

    /// A coarser job for a first look.
    pub fn quick(list: &'static [Kind]) -> Self {
        Job::new(list.iter().collect(), true)
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
        if let Some(experiment) = experiments.find(|e| e.name() == name) {
            *experiment = experiment.read(section)?;
        } else if !self.common.read(name, section)? {
            let known = self.experiments.iter().map(|e| e.name());
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
        let keep: Vec<bool> = self.list.iter().map(|k| filter.takes(k)).collect();
        let mut positions = keep.iter();
        self.experiments
            .retain(|_| positions.next().copied().unwrap_or(true));
        self.list.retain(|kind| filter.takes(kind));
        Ok(())
    }

    /// Refuses given flags that concern no experiment of the job.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the flag and the experiments that it concerns.
    pub fn check_flags(&self, list: &[Kind], given: &[(&str, bool)]) -> Result<()> {
        for (flag, _) in given.iter().filter(|(_, given)| *given) {
            let concerns = |kind: &Kind| kind.flags.contains(flag);
            if self.list.iter().any(|kind| concerns(kind)) {
                continue;
            }
            let wanted: Vec<&str> = self.list.iter().map(|kind| kind.name).collect();
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
        let takers = self.list.iter().zip(&self.experiments);
        for (_, experiment) in takers.filter(|(kind, _)| kind.flags.contains(&"--merge")) {
            let name = experiment.name();
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
        for experiment in &mut self.experiments {
            experiment.apply(overrides);
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the value and the expected range, or a file that cannot be read.
    pub fn validate(&self) -> Result<()> {
        self.common.validate()?;
        self.experiments.iter().try_for_each(|e| e.validate())
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
            own if own == Job::new(self.list.clone(), false).toml()? => "full",
            own if own == Job::new(self.list.clone(), true).toml()? => "quick",
            _ => "own",
        })
    }

    /// The configuration, which [`Job::read`] accepts.
    ///
    /// # Errors
    /// Parameters that cannot be written.
    pub fn toml(&self) -> Result<String> {
        let mut sections = Vec::new();
        for experiment in &self.experiments {
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
        for experiment in &self.experiments {
            sections.insert(experiment.name().to_owned(), experiment.json()?);
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
        let run = |experiment: &dyn AnyExperiment| {
            let name = experiment.name();
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
        self.experiments
            .iter()
            .map(|experiment| run(&**experiment))
            .collect()
    }
}

fn cannot_be_written(error: impl std::fmt::Display) -> Error {
    Error::Data(format!("the parameters cannot be written: {error}"))
}
