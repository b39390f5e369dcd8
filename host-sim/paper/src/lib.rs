//! The paper: its experiments, their measures, and the report of both.

pub mod experiments;
pub mod measure;
pub mod report;

pub use bonebeam_files::{Error, Result};
