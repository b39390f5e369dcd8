//! Parameters of the drive, a section a stage, from TOML and from the command line.

mod beamform;
mod core;
mod image;
mod phase_symmetry;

pub(crate) use core::plain;

pub use beamform::{Beamform, BeamformFlags, Interpolation, Kind, LineKind, RfInterpolation};
pub use image::{Image, ImageFlags, LONGER_SIDE};
pub use phase_symmetry::{PhaseSymmetry, PhaseSymmetryFlags, Size, parse_scale};
