//! The f32 reference.
