//! The main job and the paper: experiments, a folder each, behind one trait.
//!
//! An [`Experiment`] is its parameters, which are a section of the configuration, and what it makes of
//! them: an [`Outcome`] of pictures, plots, tables, comparisons with the paper, verdicts, checks and data.
//! The configuration, the command line and the report know these parts, and no experiment by name.
//! [`MAIN_JOB`] and [`PAPER`] are the two lists of them.

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
pub mod tune;
mod vertebra;
mod vertebra_in_tissue;
mod water_bath;

pub use common::Common;
pub use experiment::{Context, Covers, Experiment, Overrides, Progress};
pub use job::{ExperimentFilter, Job, Kind};
pub use outcome::Outcome;

/// The main job's experiments, in the order in which they run and are shown.
pub const MAIN_JOB: &[Kind] = &[Kind::of::<point::Point>(), Kind::of::<vertebra::Vertebra>()];

/// The experiments of `host-sim paper`, likewise.
pub const PAPER: &[Kind] = &[
    Kind::of::<point_spread::PointSpread>(),
    Kind::of::<vertebra_in_tissue::VertebraInTissue>(),
    Kind::of::<water_bath::WaterBath>(),
    Kind::of::<spine::Spine>(),
    Kind::of::<dynamic_range::DynamicRange>(),
    Kind::of::<claims::Claims>(),
    Kind::of::<surface::Surface>(),
    Kind::of::<depth_step::DepthStep>(),
];
