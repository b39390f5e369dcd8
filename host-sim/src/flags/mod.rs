//! Flags of the commands, one group per section of the configuration.

mod beamform;
mod core;
mod image;
mod phase_symmetry;
mod simulate;
mod surface;

pub use beamform::BeamformFlags;
pub use image::ImageFlags;
pub use phase_symmetry::{PhaseSymmetryFlags, parse_scale};
pub use simulate::SimulateFlags;
pub use surface::{SurfaceFlags, SurfacePictureFlags};
