//! What a study is made of: scenes, variants, measures, and the parts of a page.

pub use super::common::bone::{BoneMeasure, View};
pub use super::common::brightness::Brightness;
pub use super::common::interval::Interval;
pub use super::common::kept::kept;
pub use super::common::pair::pair;
pub use super::common::pictures::{Pair, picture, ridges, scales};
pub use super::common::recording::{recording, rf};
pub use super::common::truth::{TOLERANCE, beside, precision};
pub use super::common::variants::{Scene, Variant, lines_of};
pub use super::common::{Receive, octaves};
pub use super::outcome::{
    Column, Comparison, Curve, Gallery, PaperComparison, Picture, Plot, Scale, Section, SideBySide,
    Table, data, number, percent, ranged,
};
pub use super::parameters::{level, positive, within};
pub use super::{Context, Experiment, Outcome, Overrides, Parameters, common};
pub use crate::measure::mean;
pub use crate::measure::signed_distance::{REGIONS, Region, measure};
pub use crate::measure::surface::{Judged, Known, judge};
pub use crate::{Error, Result};
pub use bonebeam_drive::config::{Image, PhaseSymmetry};
pub use bonebeam_drive::image::{PixelGrid, b_mode, grid_of_picture};
pub use bonebeam_files::settings::{LENGTHS, out_of_range};
pub use bonebeam_files::{BeamformedLines, ChannelData, Samples};
pub use bonebeam_report::parameters;
pub use bonebeam_simulate::{
    BoneSurface, Clutter, DiffuseClutter, NoiseSpectrum, Outline, Phantom, Settings,
};
pub use ndarray::Array2;
pub use serde::{Deserialize, Serialize};
pub use std::path::PathBuf;
