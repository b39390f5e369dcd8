//! Experiments of the paper, their measures, and the report.

pub mod experiments;
pub mod measure;
pub mod report;

pub use bonebeam_files::{Error, Result};
