//! The main job and the paper: one folder per experiment, behind one trait.
//!
//! An [`Experiment`] holds its parameters, which are a section of the configuration, and makes an [`Outcome`]:
//! pictures, plots, tables, comparisons with the paper, verdicts, checks and data. The configuration, the command
//! line and the report use only these parts, and no experiment by name. [`MAIN_JOB`] and [`PAPER`] are the two
//! lists of experiments.

mod claims;
pub mod common;
mod depth_step;
mod dynamic_range;
mod experiment;
mod job;
pub mod outcome;
mod point;
mod point_spread;
mod spine;
mod surface;
mod surface_pictures;
pub mod tune;
mod vertebra;
mod vertebra_in_tissue;
mod water_bath;

pub use common::Common;
pub use experiment::{Context, Covers, Experiment, Overrides, Progress};
pub use job::{ExperimentFilter, Job, Kind};
pub use outcome::Outcome;

/// Experiments of the main job, in the order in which they run and are shown.
pub const MAIN_JOB: &[Kind] = &[Kind::of::<point::Point>(), Kind::of::<vertebra::Vertebra>()];

/// Experiments of `host-sim paper`, in the order in which they run and are shown.
pub const PAPER: &[Kind] = &[
    Kind::of::<point_spread::PointSpread>(),
    Kind::of::<vertebra_in_tissue::VertebraInTissue>(),
    Kind::of::<water_bath::WaterBath>(),
    Kind::of::<spine::Spine>(),
    Kind::of::<dynamic_range::DynamicRange>(),
    Kind::of::<claims::Claims>(),
    Kind::of::<surface::Surface>(),
    Kind::of::<surface_pictures::SurfacePictures>(),
    Kind::of::<depth_step::DepthStep>(),
];
