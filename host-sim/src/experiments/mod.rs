//! The main job: experiments, a folder each, behind one trait.
//!
//! An [`Experiment`] is its parameters, which are a section of the configuration, and what it makes of
//! them: an [`Outcome`] of pictures, plots, tables, comparisons with the paper, checks and data. The
//! configuration, the command line and the report know these parts, and no experiment by name.

pub mod common;
mod job;
pub mod outcome;
mod point;
mod vertebra;

pub use common::Common;
pub use job::Job;
pub use outcome::Outcome;

use std::path::PathBuf;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::Result;
use job::Kind;

/// Every experiment, in the order in which they run and are shown: the only list of them.
const EXPERIMENTS: [Kind; 2] = [Kind::of::<point::Point>(), Kind::of::<vertebra::Vertebra>()];

/// Hears, from any thread, what is being done and the fraction of it that is done.
pub type Progress<'a> = &'a (dyn Fn(&str, f64) + Sync);

/// An experiment: the value is its parameters, the default those of the full job.
pub trait Experiment: Serialize + DeserializeOwned + Default + Sync + 'static {
    /// The name of its section of the configuration and of its data in `report.json`; the names of its
    /// pictures and checks begin with it.
    const NAME: &'static str;

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

    /// Runs the experiment. The outcome does not depend on the number of threads.
    ///
    /// # Errors
    /// Parameters that do not fit together.
    fn run(&self, common: &Common, progress: Progress<'_>) -> Result<Outcome>;
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
}

impl Overrides {
    /// The flags, and whether each was given.
    pub fn given(&self) -> [(&'static str, bool); 2] {
        [
            ("--mesh", self.mesh.is_some()),
            ("--slice", self.slice.is_some()),
        ]
    }
}
