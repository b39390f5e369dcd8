//! The host simulator of bonebeam: synthetic channel data, files, the drive of the core over
//! threads, two independent references, measures and reports.

#[cfg(feature = "bench")]
pub mod bench;
pub mod cli;
pub mod commands;
pub mod config;
pub mod drive;
pub mod error;
pub mod experiments;
pub mod files;
pub mod golden;
pub mod measure;
pub mod memory;
pub mod methods;
pub mod reference;
pub mod report;
pub mod simulate;
mod terminal;
pub mod validate;

pub use error::{Error, Result};
