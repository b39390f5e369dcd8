//! The list of experiments.

use super::claims::Claims;
use super::depth_step::DepthStep;
use super::dynamic_range::DynamicRange;
use super::point_spread::PointSpread;
use super::spine::Spine;
use super::surface::Surface;
use super::surface_pictures::SurfacePictures;
use super::vertebra_in_tissue::VertebraInTissue;
use super::water_bath::WaterBath;
use bonebeam_report::experiments::Kind;

/// Experiments of the paper, in the order in which they run and are shown.
#[rustfmt::skip]
pub const PAPER: &[Kind] = &[
    Kind::of::<PointSpread>().figures(&[2]),
    Kind::of::<VertebraInTissue>().figures(&[3]).flags(&["--mesh", "--keep"]),
    Kind::of::<WaterBath>().figures(&[4, 5, 6, 7, 8, 9]).tables(&[1]).flags(&["--mesh", "--keep"]),
    Kind::of::<Spine>().figures(&[10, 11, 12]).flags(&["--keep"]),
    Kind::of::<DynamicRange>().flags(&["--keep"]),
    Kind::of::<Claims>().claims().flags(&["--mesh", "--only", "--keep", "--merge"]),
    Kind::of::<Surface>().flags(&["--keep"]),
    Kind::of::<SurfacePictures>(),
    Kind::of::<DepthStep>().flags(&["--mesh", "--keep"]),
];
