//! Measures on lines and images.

pub mod point;
pub mod profile;
pub mod signed_distance;
