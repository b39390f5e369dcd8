//! The command `host-sim`: its arguments, its configuration, and what each of its commands does.

mod cli;
mod commands;
pub mod config;
pub mod flags;
mod progress;
pub mod provenance;

pub use bonebeam_files::{Error, Result};
pub use cli::run;
