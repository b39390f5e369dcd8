//! Parameters of the drive, one section per stage.

mod beamform;
mod core;
mod image;
mod phase_symmetry;
mod surface;

pub use beamform::{
    Beamform, DELAY, Interpolation, LineKind, Preset, RfInterpolation, TransmitWeights,
};
pub use image::{Grid, Image, LONGER_SIDE, PixelSize, SubLines};
pub use phase_symmetry::{PhaseSymmetry, Size};
pub use surface::Surface;
