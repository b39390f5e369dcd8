//! The f64 reference.
pub mod beamform;
pub mod coherence;
pub mod delay;
pub mod depth_interpolation;
pub mod image;
pub mod iq;
pub mod phase_symmetry;
pub mod steering;
pub mod surface;
