//! Measures of points, regions, images of bone and surfaces.

pub mod contrast;
pub mod line;
pub mod point;
pub mod profile;
pub mod signed_distance;
pub mod surface;

pub use bonebeam_files::{Error, Result};

/// The mean of values; `None` without values.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.into_iter().collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
