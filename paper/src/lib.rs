//! The paper's experiments, the search for parameters, and the program for both.

mod commands;
pub mod experiments;
pub mod measure;
pub mod page;

pub use bonebeam_files::{Error, Result};
pub use commands::run;
