//! The program `host-sim`: command line, configuration and commands.

mod cli;
mod commands;
pub mod config;
pub mod flags;
mod progress;
pub mod provenance;

pub use bonebeam_files::{Error, Result};
pub use cli::run;
