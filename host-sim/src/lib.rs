//! The program `host-sim`: command line, configuration and commands.

mod arguments;
mod cli;
pub mod commands;
pub mod config;
pub mod flags;
pub mod progress;
pub mod provenance;

pub use bonebeam_files::{Error, Result};
pub use cli::{run, run_as, run_within, start};
