//! What an experiment is, and what it runs with.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::common::Common;
use super::outcome::Outcome;
use crate::{Error, Result};

/// Hears, from any thread, what is being done and the fraction of it that is done.
pub type Progress<'a> = &'a (dyn Fn(&str, f64) + Sync);

/// An experiment: the value is its parameters, the default those of the full job.
pub trait Experiment: Serialize + DeserializeOwned + Default + Sync + 'static {
    /// The name of its section of the configuration and of its data in `report.json`; the names of its
    /// pictures and checks begin with it.
    const NAME: &'static str;

    /// What of the paper it shows; nothing, where it belongs to the main job alone.
    const COVERS: Covers = Covers::NOTHING;

    /// Which of `--mesh`, `--only`, `--keep` and `--merge` of `host-sim paper` concern it.
    const FLAGS: &'static [&'static str] = &[];

    /// Coarser parameters, for a first look.
    fn quick() -> Self;

    /// Fills in what follows from other parameters where it is not told.
    fn resolve(&mut self);

    /// Takes what the command line says in place of parameters; what does not concern the experiment it
    /// leaves alone.
    fn apply(&mut self, _overrides: &Overrides) {}

    /// Checks the parameters before anything is computed.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the value and what would be right; a file that cannot be read.
    fn validate(&self) -> Result<()>;

    /// Checks the data of the same experiment in another run's `report.json`.
    ///
    /// # Errors
    /// [`crate::Error::Data`] where the experiment cannot take them in.
    fn check_merged(&self, _data: &serde_json::Value) -> Result<()> {
        Ok(())
    }

    /// Runs the experiment. The outcome does not depend on the number of threads.
    ///
    /// # Errors
    /// Parameters that do not fit together.
    fn run(&self, context: &Context<'_>) -> Result<Outcome>;
}

/// What an experiment shows of the paper.
#[derive(Clone, Copy, Debug)]
pub struct Covers {
    /// The numbers of its figures.
    pub figures: &'static [u32],
    /// The numbers of its tables.
    pub tables: &'static [u32],
    /// Whether it judges the paper's claims.
    pub claims: bool,
}

impl Covers {
    /// Nothing of it.
    pub const NOTHING: Covers = Covers {
        figures: &[],
        tables: &[],
        claims: false,
    };
}

/// What an experiment runs with beside its own parameters.
pub struct Context<'a> {
    /// The parameters that are the same for every experiment.
    pub common: &'a Common,
    /// The folder in which recordings, and results that took long, are kept for the next run; none where
    /// nothing is kept.
    pub kept: Option<&'a Path>,
    /// The data of the same experiment in other runs' `report.json`.
    pub merged: &'a [serde_json::Value],
    /// Hears how far it is.
    pub progress: Progress<'a>,
}

impl Context<'_> {
    /// The folder of what is kept, made if it is not there.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub fn kept(&self) -> Result<Option<&Path>> {
        if let Some(folder) = self.kept {
            std::fs::create_dir_all(folder).map_err(|e| Error::File {
                path: folder.to_path_buf(),
                message: format!("the folder cannot be made: {}", e.kind()),
            })?;
        }
        Ok(self.kept)
    }
}

/// What the main job's command line can say in place of parameters.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Overrides {
    /// A closed surface in mm, +x towards the front and +z towards the head, in place of the
    /// main job's built-in vertebra
    #[arg(long, value_name = "FILE.ply")]
    pub mesh: Option<PathBuf>,

    /// Height of the main job's slice through the vertebra, m [default: -0.004]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub slice: Option<f64>,

    /// The first of the seeds; not a flag of the main job, which has its seeds in the configuration.
    #[arg(skip)]
    pub seed: Option<u64>,

    /// Which parts of an experiment are wanted, by words in their names; all without any.
    #[arg(skip)]
    pub only: Vec<String>,
}

impl Overrides {
    /// Puts what is given in place of a seed and of a mesh.
    pub(super) fn replace(&self, seed: &mut u64, mesh: Option<&mut Option<PathBuf>>) {
        *seed = self.seed.unwrap_or(*seed);
        if let (Some(mesh), Some(given)) = (mesh, &self.mesh) {
            *mesh = Some(given.clone());
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
