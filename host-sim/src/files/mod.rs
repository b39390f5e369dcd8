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
mod samples;
mod units;
mod validate;

pub use aligned::AlignedData;
pub use channel_data::{ChannelData, Transmits};
pub use lines::{BeamRays, Lines};
pub use npy::read_array;
pub use samples::{Frame, Samples};

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::{Error, Result};

/// A recording, of a kind that its keys tell.
pub enum Recording {
    /// Channel data as recorded (`rf` or `iq`).
    Channel(ChannelData),
    /// Aligned data (`x`): no delaying is left to do.
    Aligned(AlignedData),
}

/// A file format of recordings: a row here and a reader.
struct Format {
    /// How its files' names end.
    extensions: &'static [&'static str],
    /// How its files begin.
    magic: &'static [u8],
    read: fn(&Path) -> Result<Recording>,
}

/// The formats that recordings are read from.
const FORMATS: [Format; 1] = [Format {
    extensions: &["npz"],
    magic: b"PK",
    read: read_npz,
}];

/// Formats that a recording may come in and that are not read, by how they begin.
const FOREIGN: [(&[u8], &str); 5] = [
    (b"MATLAB 5.0 MAT-file", "a MATLAB file"),
    (b"MATLAB 7.3 MAT-file", "a MATLAB file (version 7.3)"),
    (
        b"\x89HDF\r\n\x1a\n",
        "an HDF5 file, as .h5, .uff and newer .mat files are",
    ),
    (b"\x93NUMPY", "a single .npy array"),
    (b"\x1f\x8b", "compressed with gzip"),
];

/// What is read.
const EXPECTED: &str =
    "expected an .npz archive with channel data (`rf` or `iq`) or aligned data (`x`), see --help";

impl Recording {
    /// Reads channel data or aligned data, whichever the file holds, in the format that it begins
    /// with, else in the one that its name ends in.
    ///
    /// # Errors
    /// The file cannot be opened, is of a format that is not read, holds both `rf` and `x`, or
    /// neither, or what it holds is not valid.
    pub fn read(path: &Path) -> Result<Self> {
        let mut start = Vec::new();
        let head = File::open(path).and_then(|file| file.take(128).read_to_end(&mut start));
        head.map_err(|e| file_error(path, cannot_be_opened(&e)))?;
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        let named = |format: &&Format| {
            let mut known = format.extensions.iter();
            known.any(|known| known.eq_ignore_ascii_case(extension))
        };
        let begins = FORMATS.iter().find(|f| start.starts_with(f.magic));
        if let Some(format) = begins {
            return (format.read)(path);
        }
        let foreign = FOREIGN.iter().find(|(magic, _)| start.starts_with(magic));
        if let Some((_, what)) = foreign {
            return Err(file_error(path, format!("is {what}; {EXPECTED}")));
        }
        // One that is cut short or damaged says so itself.
        match FORMATS.iter().find(named) {
            Some(format) => (format.read)(path),
            None => Err(file_error(
                path,
                format!("is not of a known format; {EXPECTED}"),
            )),
        }
    }
}

/// What a `.npz` file holds, told by its keys.
fn read_npz(path: &Path) -> Result<Recording> {
    let mut file = npz::Reader::open(path)?;
    let channel_data = file.has("rf") || file.has("iq");
    match (channel_data, file.has("x")) {
        (true, false) => ChannelData::from_npz(&mut file).map(Recording::Channel),
        (false, true) => AlignedData::from_npz(&mut file).map(Recording::Aligned),
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
