//! The files: recordings in many formats, beamformed lines as `.npz`, images as `.npy` and PNG.
//!
//! Everything read is validated before it is returned, and every error names the file, the key,
//! the index and what would be right. Everything written is written whole or not at all.

mod aligned;
pub mod atomic;
mod channel_data;
pub mod formats;
pub mod image;
pub mod leftovers;
mod lines;
mod npy;
mod npy_header;
mod npz;
mod partial;
mod samples;
mod truth;
mod units;
mod validate;

pub use aligned::AlignedData;
pub use channel_data::{ChannelData, Transmits};
pub use formats::{Format, Variables};
pub use lines::{BeamRays, Lines};
pub use npy::read_array;
pub use partial::Partial;
pub use samples::{Frame, Samples};
pub use truth::{Truth, stage_surface};

use std::io;
use std::path::Path;

use crate::{Error, Result};

/// A recording, of a kind that its keys tell.
pub enum Recording {
    /// Channel data as recorded (`rf` or `iq`).
    Channel(ChannelData),
    /// Aligned data (`x`): no delaying is left to do.
    Aligned(AlignedData),
}

impl Recording {
    /// Reads channel data or aligned data, in the format that the file or folder turns out to be of.
    ///
    /// # Errors
    /// The file cannot be opened, is of a format that is not read, holds several kinds of data or
    /// none, or what it holds is not valid.
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_with(path, &Variables::default()).map(|(recording, _)| recording)
    }

    /// The same, with what `variables` say of the file's arrays, and the format that it was of.
    ///
    /// # Errors
    /// As [`Recording::read`], and variables that have no effect on that format.
    pub fn read_with(path: &Path, variables: &Variables) -> Result<(Self, Format)> {
        formats::read(path, variables)
    }
}

/// What a `.npz` file holds, told by its keys.
fn read_npz(file: &mut npz::Reader) -> Result<Recording> {
    let channel_data = file.has("rf") || file.has("iq");
    match (channel_data, file.has("x")) {
        (true, false) => ChannelData::from_npz(file).map(Recording::Channel),
        (false, true) => AlignedData::from_npz(file).map(Recording::Aligned),
        (true, true) => Err(file.error(
            "holds both `rf` or `iq` (channel data) and `x` (aligned data); expected one of them",
        )),
        (false, false) => Err(file.error(
            "holds neither `rf` or `iq` (channel data) nor `x` (aligned data); expected one of them",
        )),
    }
}

/// The error for a file whose contents are wrong.
fn file_error(path: &Path, message: impl Into<String>) -> Error {
    Error::File {
        path: path.to_path_buf(),
        message: message.into(),
    }
}

/// Why a file cannot be opened.
pub(crate) fn cannot_be_opened(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "cannot be opened: no such file".into(),
        kind => format!("cannot be opened: {kind}"),
    }
}
