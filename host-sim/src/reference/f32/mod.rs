//! The f32 reference.

pub mod beamform;
mod covariance;
pub mod delay;
mod first_pair;
pub mod image;
mod linalg;
pub mod phase_symmetry;
