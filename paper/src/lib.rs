//! The paper's experiments, the search for parameters, and the program for both.

mod commands;
pub mod experiments;
pub mod measure;
pub mod page;

pub use bonebeam_files::{Error, Result};
pub(crate) use bonebeam_report::parameters;
pub use commands::run;
