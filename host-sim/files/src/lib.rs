//! Files of the program: recordings and lines as `.npz`, images as `.npy` and PNG.
//!
//! The crate `bonebeam-formats` reads recordings in other formats.
//!
//! Everything read is validated before it is returned. Every error names the file, the key, the index and the
//! expected value. Everything written is written whole or not at all.

mod aligned;
pub mod atomic;
mod channel_data;
pub mod document;
mod error;
mod first_frame;
mod hash;
#[cfg(feature = "png")]
pub mod image;
pub mod input;
mod lines;
pub mod memory;
pub mod npy;
mod npy_header;
pub mod npz;
mod npz_writer;
mod partial;
mod partial_frames;
mod recording;
mod samples;
pub mod section;
pub mod settings;
#[cfg(all(feature = "signals", unix))]
pub mod signals;
mod stored;
mod survey;
pub mod temporary_files;
pub mod terminal;
mod transmits;
mod truth;
mod units;
mod validate;
mod volume;
mod warnings;

pub use aligned::AlignedData;
pub use channel_data::{ChannelData, OUT_OF_PLANE, check_plane};
pub use error::{Error, Result};
pub use hash::{FileHash, SharedHash, of_array as hash_of_array};
pub use input::cannot_be_opened;
pub use lines::{BeamRays, BeamformedLines, LineFrames};
pub use npy::read_array;
pub use partial::Partial;
pub use partial_frames::PartialFrames;
pub use recording::Recording;
pub use samples::{FrameSamples, Samples};
pub use stored::StoredFrame;
pub use survey::{Moments, Survey};
pub use transmits::Transmits;
pub use truth::{Truth, add_surface_to, ply};
pub use volume::nifti;

use std::path::Path;

/// An error about a file's contents.
pub fn file_error(path: &Path, message: impl Into<String>) -> Error {
    Error::File {
        path: path.to_path_buf(),
        message: message.into(),
    }
}
