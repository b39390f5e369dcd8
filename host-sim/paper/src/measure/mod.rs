//! Measures on lines and images.

pub mod average_precision;
pub mod contrast;
pub mod linearity;
pub mod point;
pub mod profile;
pub mod registration;
pub mod signed_distance;
pub mod surface;
