//! The host simulator of bonebeam: synthetic channel data, files, the drive of the core over
//! threads, two independent references, measures and reports.

pub mod beamform;
pub mod bench;
pub mod checks;
pub mod cli;
mod commands;
pub mod config;
pub mod delay;
pub mod error;
pub mod files;
pub mod frame;
pub mod image;
pub mod instruction_set;
pub mod main_job;
pub mod measure;
pub mod phase_symmetry;
pub mod reference;
pub mod report;
pub mod simulate;
mod threads;
pub mod verify;

pub use error::{Error, Result};
