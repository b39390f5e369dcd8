//! The experiments of the paper, one folder each.

pub mod all;
mod claims;
pub mod common;
mod depth_step;
mod dynamic_range;
mod point_spread;
mod spine;
pub(crate) mod study;
mod surface;
mod surface_pictures;
pub mod tune;
mod vertebra_in_tissue;
mod water_bath;

pub use bonebeam_report::experiments::*;
