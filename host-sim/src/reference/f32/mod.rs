//! The f32 reference.

pub mod beamform;
mod covariance;
pub mod delay;
pub mod image;
mod linalg;
pub mod phase_symmetry;
