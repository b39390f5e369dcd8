//! The f32 reference.

pub mod beamform;
mod covariance;
pub mod delay;
pub mod depth_interpolation;
mod dominant_eigenpair;
mod filter;
pub mod image;
pub mod iq;
mod linalg;
pub mod phase_symmetry;
pub mod sub_lines;
pub mod surface;
