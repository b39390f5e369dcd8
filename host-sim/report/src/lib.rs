//! Experiments of the main job, their measures, and the page that shows them.

pub mod experiments;
pub mod page;

pub use bonebeam_files::{Error, Result};
pub use bonebeam_measure as measure;
