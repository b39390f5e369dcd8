//! Errors for the user: one line that names the thing, and an exit status.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

/// Every failure of the host simulator.
#[derive(Debug)]
pub enum Error {
    /// The command line or the configuration is wrong (exit status 2).
    Usage(String),
    /// A file or its contents are wrong (exit status 1).
    File {
        /// The file or folder.
        path: PathBuf,
        /// The problem, and the expected content.
        message: String,
    },
    /// Data in memory are wrong (exit status 1).
    Data(String),
    /// The core returned an error (exit status 1).
    Core(bonebeam::Error),
}

impl Display for Error {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Error::Usage(message) | Error::Data(message) => f.write_str(message),
            Error::File { path, message } => write!(f, "{}: {message}", path.display()),
            Error::Core(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for Error {}

impl From<bonebeam::Error> for Error {
    fn from(error: bonebeam::Error) -> Self {
        Error::Core(error)
    }
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
