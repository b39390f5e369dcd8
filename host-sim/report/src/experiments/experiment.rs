//! The trait of an experiment, and its context.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::common::{Checking, Common, Receive};
use super::outcome::Outcome;
use crate::{Error, Result};
use bonebeam_drive::check::References;
use bonebeam_drive::config::Image;
use bonebeam_simulate::Settings;

/// Callback with the current step and the fraction done, from any thread.
pub type Progress<'a> = &'a (dyn Fn(&str, f64) + Sync);

/// Parameters of an experiment, a section of the configuration, by [`parameters!`](crate::parameters!).
///
/// The default is that of the full job.
pub trait Parameters: Serialize + DeserializeOwned + Default {
    /// Name of the section and of the experiment's data in `report.json`.
    ///
    /// Names of its pictures and checks begin with it.
    const NAME: &'static str;

    /// Checks each value that has a range.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the value and the range.
    fn check(&self) -> Result<()>;

    /// The keys of a scanner, if the section has them.
    ///
    /// Receiver and image follow the array, the seed the flag.
    fn scanner(&mut self) -> Option<Scanner<'_>> {
        None
    }
}

/// Array and pulse, receiver and image.
pub type Scanner<'a> = (&'a mut Settings, &'a mut Receive, &'a mut Image);

/// An experiment: the value is its parameters.
pub trait Experiment: Sync + 'static {
    /// Coarser parameters, for a first look.
    fn quick() -> Self
    where
        Self: Sized;

    /// Fills in missing values that follow from other parameters than the scanner's.
    fn resolve(&mut self) {}

    /// Applies overrides of the command line.
    ///
    /// Those that do not concern the experiment change nothing.
    fn apply(&mut self, _overrides: &Overrides) {}

    /// Checks what [`Parameters::check`] does not, before anything is computed.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the value and the expected range, or a file that cannot be read.
    fn validate(&self) -> Result<()> {
        Ok(())
    }

    /// Checks the data of the same experiment in another run's `report.json`.
    ///
    /// # Errors
    /// [`crate::Error::Data`] if the experiment cannot merge them.
    fn check_merged(&self, _data: &serde_json::Value) -> Result<()> {
        Ok(())
    }

    /// Runs the experiment. The outcome does not depend on the number of threads.
    ///
    /// # Errors
    /// Parameters that do not fit together.
    fn run(&self, context: &Context<'_>) -> Result<Outcome>;
}

/// Context of an experiment's run.
pub struct Context<'a> {
    /// Parameters shared by all experiments.
    pub common: &'a Common,
    /// Folder of recordings and long results for the next run.
    ///
    /// `None` if nothing is kept.
    pub kept: Option<&'a Path>,
    /// The data of the same experiment in other runs' `report.json`.
    pub merged: &'a [serde_json::Value],
    /// What results are compared with, if the program has it.
    pub references: Option<&'static References>,
    /// Callback for progress.
    pub progress: Progress<'a>,
}

impl Context<'_> {
    /// The comparisons to make, if the program can.
    pub fn checking(&self) -> Option<Checking<'_>> {
        let extent = &self.common.checks;
        self.references
            .map(|references| Checking { references, extent })
    }

    /// The folder of kept results, created if necessary.
    ///
    /// # Errors
    /// A folder that cannot be created.
    pub fn kept(&self) -> Result<Option<&Path>> {
        if let Some(folder) = self.kept {
            std::fs::create_dir_all(folder).map_err(|e| Error::File {
                path: folder.to_path_buf(),
                message: format!("the folder cannot be created: {}", e.kind()),
            })?;
        }
        Ok(self.kept)
    }
}

/// Values of the main job's command line that override parameters.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Overrides {
    /// Closed surface in mm in place of the main job's built-in vertebra
    ///
    /// +x towards the front and +z towards the head.
    #[arg(long, value_name = "FILE.ply")]
    pub mesh: Option<PathBuf>,

    /// Height of the main job's slice through the vertebra, m [default: -0.004]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub slice: Option<f64>,

    /// First seed.
    ///
    /// Not a flag of the main job, whose seeds are in the configuration.
    #[arg(skip)]
    pub seed: Option<u64>,

    /// Parts to run of an experiment, by words in their names; if empty, all.
    #[arg(skip)]
    pub only: Vec<String>,
}

impl Overrides {
    /// Overrides a mesh by the given one.
    pub fn replace_mesh(&self, mesh: &mut Option<PathBuf>) {
        if self.mesh.is_some() {
            mesh.clone_from(&self.mesh);
        }
    }

    /// The flags, and whether each was given.
    pub fn given(&self) -> [(&'static str, bool); 2] {
        [
            ("--mesh", self.mesh.is_some()),
            ("--slice", self.slice.is_some()),
        ]
    }
}
