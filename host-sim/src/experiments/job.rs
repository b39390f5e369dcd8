//! The main job's parameters: a section an experiment, and what they have in common.

use std::path::Path;

use serde::Serialize;
use serde::de::Error as _;
use std::collections::BTreeMap;
use toml::de::{DeTable, ValueDeserializer};

use crate::config::read_toml_with;
use crate::{Error, Result};

use super::{Common, EXPERIMENTS, Experiment, Outcome, Overrides, Progress};

/// All parameters of the main job.
pub struct Job {
    experiments: Vec<Box<dyn AnyExperiment>>,
    common: Common,
}

/// An experiment of the list: how its parameters are made.
pub(super) struct Kind {
    full: fn() -> Box<dyn AnyExperiment>,
    quick: fn() -> Box<dyn AnyExperiment>,
}

impl Kind {
    pub(super) const fn of<E: Experiment>() -> Self {
        Kind {
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
    fn run(&self, common: &Common, progress: Progress<'_>) -> Result<Outcome>;
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

    fn run(&self, common: &Common, progress: Progress<'_>) -> Result<Outcome> {
        Experiment::run(self, common, progress)
    }
}

impl Job {
    /// The full job: the paper's settings.
    pub fn full() -> Self {
        Job {
            experiments: EXPERIMENTS.iter().map(|kind| (kind.full)()).collect(),
            common: Common::default(),
        }
    }

    /// A coarser job for a first look.
    pub fn quick() -> Self {
        Job {
            experiments: EXPERIMENTS.iter().map(|kind| (kind.quick)()).collect(),
            common: Common::quick(),
        }
    }

    /// Reads a TOML file; what it does not mention keeps its default.
    ///
    /// # Errors
    /// As [`crate::config::Config::read`].
    pub fn read(path: &Path) -> Result<Self> {
        read_toml_with(path, |text| {
            let mut job = Job::full();
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

    /// Takes what the command line says in place of parameters.
    pub fn apply(&mut self, overrides: &Overrides) {
        for experiment in &mut self.experiments {
            experiment.apply(overrides);
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the value and what would be right; a file that cannot be read.
    pub fn validate(&self) -> Result<()> {
        self.common.validate()?;
        self.experiments.iter().try_for_each(|e| e.validate())
    }

    /// The parameters that the experiments share.
    pub fn common(&self) -> &Common {
        &self.common
    }

    /// Which job it is: "full", "quick", or "own" where a parameter is the user's.
    ///
    /// # Errors
    /// Parameters that cannot be written.
    pub fn kind(&self) -> Result<&'static str> {
        let own = self.toml()?;
        Ok(match own {
            own if own == Job::full().toml()? => "full",
            own if own == Job::quick().toml()? => "quick",
            _ => "own",
        })
    }

    /// The configuration, which [`Job::read`] takes again.
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

    /// The same by section, for `report.json`.
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

    /// Runs every experiment of a job that is valid: name and outcome, in order. The outcome does not
    /// depend on the number of threads.
    ///
    /// # Errors
    /// Parameters that do not fit together.
    pub fn run(&self, progress: Progress<'_>) -> Result<Vec<(&'static str, Outcome)>> {
        let run = |experiment: &dyn AnyExperiment| {
            Ok((experiment.name(), experiment.run(&self.common, progress)?))
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
