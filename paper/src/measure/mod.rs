//! Measures that only the paper's experiments need.

pub mod average_precision;
pub mod contrast;
pub mod linearity;
pub mod registration;
pub mod surface;

pub use bonebeam_report::measure::{line, mean, point, profile, signed_distance};
