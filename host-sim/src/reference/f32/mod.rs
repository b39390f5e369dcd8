//! The f32 reference.

pub mod delay;
