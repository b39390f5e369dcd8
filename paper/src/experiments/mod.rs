//! The experiments of the paper, one folder each.

mod claims;
pub mod common;
mod depth_step;
mod dynamic_range;
mod point_spread;
mod spine;
mod surface;
mod surface_pictures;
pub mod tune;
mod vertebra_in_tissue;
mod water_bath;

pub use bonebeam_report::experiments::*;

/// Experiments of the paper, in the order in which they run and are shown.
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
