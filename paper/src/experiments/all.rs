//! The list of experiments.

use super::{
    claims, depth_step, dynamic_range, point_spread, spine, surface, surface_pictures,
    vertebra_in_tissue, water_bath,
};
use bonebeam_report::experiments::Kind;

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
