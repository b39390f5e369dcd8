//! The f64 reference.
pub mod beamform;
pub mod delay;
