//! The f32 reference.

pub mod delay;
pub mod image;
pub mod phase_symmetry;
