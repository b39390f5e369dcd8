//! The main job and the trait of experiments, each in a folder of its own.
//!
//! An [`Experiment`] holds its [`Parameters`], which are a section of the configuration, and makes an [`Outcome`]:
//! pictures, plots, tables, comparisons with the paper, verdicts, checks and data. The configuration, the command
//! line and the page use only these parts, and no experiment by name. [`MAIN_JOB`] has a row for each experiment;
//! `paper/` has the others.

pub mod common;
pub mod experiment;
mod job;
pub mod outcome;
pub mod parameters;
mod point;
mod vertebra;

pub use common::Common;
pub use experiment::{Context, Experiment, Overrides, Parameters, Progress};
pub use job::{ExperimentFilter, Job, Kind};
pub use outcome::Outcome;

/// Experiments of the main job, in the order in which they run and are shown.
pub const MAIN_JOB: &[Kind] = &[Kind::of::<point::Point>(), Kind::of::<vertebra::Vertebra>()];
