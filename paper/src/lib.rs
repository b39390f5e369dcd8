//! The experiments of the paper, the search for parameters, and the program that runs them.

mod commands;
pub mod experiments;
pub mod measure;
pub mod page;

pub use bonebeam_files::{Error, Result};
pub use commands::run;
