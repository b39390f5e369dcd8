//! Measures that only the paper's experiments need.

pub mod average_precision;
pub mod linearity;
pub mod registration;

pub use bonebeam_measure::{contrast, line, mean, point, profile, signed_distance, surface};
