//! The flags of the command, a group a section of the configuration: what was given goes over the section's values.

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
