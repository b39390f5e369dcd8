//! Errors that a person reads: one line that names the thing, and an exit status.

use std::path::PathBuf;

/// Every failure of the host simulator.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The command line or the configuration asks for something impossible (exit status 2).
    #[error("{0}")]
    Usage(String),
    /// A file or its contents are wrong (exit status 1).
    #[error("{}: {message}", .path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong with it, and what would be right.
        message: String,
    },
    /// Data in memory are wrong (exit status 1).
    #[error("{0}")]
    Data(String),
    /// The core refused (exit status 1).
    #[error(transparent)]
    Core(#[from] bonebeam::Error),
}

impl Error {
    /// The process's exit status: 2 for usage, 1 for data.
    pub fn exit_status(&self) -> u8 {
        match self {
            Error::Usage(_) => 2,
            _ => 1,
        }
    }
}

/// A result with this crate's error.
pub type Result<T> = std::result::Result<T, Error>;
