//! The kernels of the core, each stated once.

pub mod beamform;
pub mod delay;
pub mod upsampled;
