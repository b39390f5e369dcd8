//! The files: channel data, aligned data and beamformed lines as `.npz`, images as `.npy` and PNG.
//!
//! Everything read is validated before it is returned, and every error names the file, the key,
//! the index and what would be right. Everything written is written whole or not at all.

mod aligned;
pub mod atomic;
mod channel_data;
pub mod image;
pub mod leftovers;
mod lines;
mod npy;
mod npy_header;
mod npz;
mod validate;

pub use aligned::AlignedData;
pub use channel_data::{ChannelData, Transmits};
pub use lines::Lines;

use std::path::Path;

use crate::{Error, Result};

/// What a `.npz` file holds, told by its keys.
pub enum Recording {
    /// Channel data as recorded (`rf`).
    Channel(ChannelData),
    /// Aligned data (`x`): no delaying is left to do.
    Aligned(AlignedData),
}

impl Recording {
    /// Reads channel data or aligned data, whichever the file holds.
    ///
    /// # Errors
    /// The file holds both `rf` and `x`, or neither, or what it holds is not valid.
    pub fn read(path: &Path) -> Result<Self> {
        let mut file = npz::Reader::open(path)?;
        match (file.has("rf"), file.has("x")) {
            (true, false) => ChannelData::from_npz(&mut file).map(Self::Channel),
            (false, true) => AlignedData::from_npz(&mut file).map(Self::Aligned),
            (true, true) => Err(file.error(
                "holds both `rf` (channel data) and `x` (aligned data); expected one of them",
            )),
            (false, false) => Err(file.error(
                "holds neither `rf` (channel data) nor `x` (aligned data); expected one of them",
            )),
        }
    }
}

/// The error for a file whose contents are wrong.
fn file_error(path: &Path, message: impl Into<String>) -> Error {
    Error::File {
        path: path.to_path_buf(),
        message: message.into(),
    }
}
