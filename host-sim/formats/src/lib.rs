//! Formats of recordings, one file each.
//!
//! [`read`] recognizes them by content. A file too large for memory is read a few frames at a time:
//! [`RecordingFile`].

mod aliases;
mod blocks;
mod export;
mod guard;
mod hdf5;
mod keyed;
mod layout;
mod layouts;
mod mat5;
mod picmus;
mod recording_file;
mod sonix;
mod uff;
mod values;
mod variables;
mod waves;
mod zea;

pub use blocks::Blocks;
pub use export::{Export, add_lines};
pub use layout::Layout;
pub use recording_file::RecordingFile;
pub use variables::{Given, Variables};

use std::io::Read;
use std::ops::Range;
use std::path::Path;

use bonebeam_files::{
    ChannelData, Error, Recording, Result, Samples, cannot_be_opened, file_error, input,
};
use hdf5::Store;
use mat5::Mat5;
use values::NamedArrays;
use variables::{IQ_CONJUGATE, TRACK};

/// Defines the formats, one per row, with the name in messages.
///
/// Help texts, messages and the documents' table use these names.
macro_rules! formats {
    ($($(#[doc = $doc:literal])* $format:ident, $name:literal;)*) => {
        /// A format of recordings.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Format {
            $($(#[doc = $doc])* $format,)*
        }

        impl Format {
            /// All formats.
            pub const ALL: [Self; [$($name),*].len()] = [$(Format::$format),*];

            /// Its name in messages.
            pub fn name(self) -> &'static str {
                match self {
                    $(Format::$format => $name,)*
                }
            }
        }
    };
}

formats! {
    /// NumPy's archive with the keys of docs/file-formats.md.
    Npz, ".npz archive";
    /// zea's HDF5.
    Zea, "zea (HDF5)";
    /// `channel_data` of USTB's Ultrasound File Format.
    Uff, "UFF (HDF5)";
    /// HDF5 of the Plane-Wave Imaging Challenge.
    Picmus, "PICMUS (HDF5)";
    /// MATLAB 7.3, which is HDF5.
    Mat73, "MATLAB 7.3 (HDF5)";
    /// MATLAB 5 to 7.2.
    Mat5, "MATLAB 5";
    /// Any other HDF5, by the names of its arrays.
    Hdf5, "HDF5";
    /// A folder with one file per channel.
    Sonix, "SonixDAQ folder";
}

impl Format {
    /// The names of all formats, for help texts and messages.
    pub fn names() -> String {
        Format::ALL.map(Format::name).join(", ")
    }
}

/// The accepted formats, for a file of none of them.
fn expected() -> String {
    let names = Format::names();
    format!(
        "expected one of {names}, with channel data (`rf`, `iq`) or aligned data (`x`), see --help"
    )
}

/// Number of bytes at a file's beginning that show its format.
const HEAD: u64 = 520;
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Offset of MATLAB's HDF5, behind a header of its own.
const USER_BLOCK: usize = 512;

/// Formats that are not read, by their first bytes.
const FOREIGN: [(&[u8], &str); 5] = [
    (b"\x93NUMPY", "a single .npy array"),
    (b"\x1f\x8b", "compressed with gzip"),
    (
        b"MATLAB",
        "a MATLAB file that is damaged or of an unknown version",
    ),
    (b"\x89PNG", "a picture"),
    (b"DICM", "a DICOM file"),
];

/// Result of reading a file.
pub struct Found {
    /// The requested frames, or all if the samples are read whole.
    pub recording: Recording,
    /// Format of the file.
    pub format: Format,
    /// Number of frames in the file.
    pub frames: usize,
    /// Assumed values that the file does not give, one sentence each without full stop.
    pub assumed: Vec<String>,
}

/// Reads some frames of channel data or aligned data.
///
/// The format is recognized by content. Frames that do not exist are left out.
///
/// # Errors
/// The file cannot be opened, has a format that is not read, or is not valid.
pub fn read(path: &Path, variables: &Variables, frames: Range<usize>) -> Result<Found> {
    let found = read_as_stored(path, variables, frames)?;
    Ok(Found {
        recording: found.recording.into_float(),
        ..found
    })
}

/// As [`read`]; samples that an archive stores as i16 stay i16.
fn read_as_stored(path: &Path, variables: &Variables, frames: Range<usize>) -> Result<Found> {
    variables.check().map_err(Error::Usage)?;
    let mut found = read_as_written(path, variables, frames)?;
    if let Recording::Channel(data) = &mut found.recording
        && let Some(zero) = data.samples.centre()
    {
        found.assumed.push(format!(
            "the samples are offset binary, by their mean: {zero} is 0"
        ));
    }
    if variables.number(IQ_CONJUGATE) == Some(1.0) {
        match &mut found.recording {
            Recording::Channel(data) if matches!(data.samples, Samples::Iq { .. }) => {
                let none = Samples::Rf(Default::default());
                data.samples = std::mem::replace(&mut data.samples, none).conjugate();
            }
            _ => {
                let without = "`iq_conjugate` (--iq-conjugate) has no effect on a file without I/Q";
                return Err(file_error(path, without));
            }
        }
    }
    Ok(found)
}

fn read_as_written(path: &Path, variables: &Variables, frames: Range<usize>) -> Result<Found> {
    if path.is_dir() {
        return match sonix::is(path) {
            true => {
                let (data, held, assumed) = sonix::read(path, variables, frames)?;
                let found = channel(Ok((data, held)), Format::Sonix)?;
                Ok(Found { assumed, ..found })
            }
            false => Err(file_error(
                path,
                "is a folder without CH000.daq, as a SonixDAQ writes; expected a file",
            )),
        };
    }
    let mut head = Vec::new();
    let begin = input::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    begin.map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    let matlab = head.get(USER_BLOCK..).is_some_and(|b| b.starts_with(HDF5));
    if head.starts_with(HDF5) || matlab {
        return read_hdf5(path, matlab, variables, frames);
    }
    let version = head.get(124..128);
    if version == Some(&[0, 1, b'I', b'M']) || version == Some(&[1, 0, b'M', b'I']) {
        let source = Mat5::open(path)?;
        return keyed(&source, variables, frames, Format::Mat5);
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    if head.starts_with(b"PK") {
        refuse_without_effect(variables, path)?;
        return npz_archive(path, frames);
    }
    if let Some((_, what)) = FOREIGN.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Err(file_error(path, format!("is {what}; {}", expected())));
    }
    // One that is cut short or damaged says so itself.
    if extension.eq_ignore_ascii_case("npz") {
        return npz_archive(path, frames);
    }
    let named = |extensions: &[&str]| extensions.iter().any(|e| extension.eq_ignore_ascii_case(e));
    let what = if named(&["h5", "hdf5", "uff"]) {
        "is truncated or not the HDF5 file that its name indicates"
    } else if named(&["mat"]) {
        "is truncated or not the MATLAB file that its name indicates"
    } else if head.is_empty() {
        "is empty"
    } else {
        "is not of a known format"
    };
    Err(file_error(path, format!("{what}; {}", expected())))
}

fn npz_archive(path: &Path, frames: Range<usize>) -> Result<Found> {
    let (recording, frames) = Recording::read_npz(path, frames, None, None)?;
    Ok(Found {
        recording,
        format: Format::Npz,
        frames,
        assumed: Vec::new(),
    })
}

fn read_hdf5(
    path: &Path,
    matlab: bool,
    variables: &Variables,
    frames: Range<usize>,
) -> Result<Found> {
    let store = Store::open(path, matlab)?;
    let only = |keys: &[&str]| {
        let only = variables.only_numbers(keys);
        only.map_err(|e| file_error(path, e))
    };
    if !matlab && picmus::is(&store) {
        only(&["fs", "c", "f0", "lens_delay"])?;
        let data = picmus::read(&store, variables);
        return channel(data.map(|data| (data, 1)), Format::Picmus);
    }
    if !matlab && uff::is(&store) {
        only(&["fs", "c", "f0", "f_demod", "lens_delay"])?;
        return channel(uff::read(&store, variables, frames), Format::Uff);
    }
    if !matlab && zea::is(&store) {
        only(&[TRACK, "fs", "c", "f0", "lens_delay"])?;
        let (data, held, assumed) = zea::read(&store, variables, frames)?;
        let found = channel(Ok((data, held)), Format::Zea)?;
        return Ok(Found { assumed, ..found });
    }
    let format = if matlab { Format::Mat73 } else { Format::Hdf5 };
    keyed(&store, variables, frames, format)
}

/// Arrays with names that users choose.
fn keyed(
    source: &dyn NamedArrays,
    variables: &Variables,
    frames: Range<usize>,
    format: Format,
) -> Result<Found> {
    let (data, held, assumed) = layouts::channel_data(source, variables, frames)?;
    let found = channel(Ok((data, held)), format)?;
    Ok(Found { assumed, ..found })
}

fn channel(data: Result<(ChannelData, usize)>, format: Format) -> Result<Found> {
    let (data, frames) = data?;
    Ok(Found {
        recording: Recording::Channel(data),
        format,
        frames,
        assumed: Vec::new(),
    })
}

fn refuse_without_effect(variables: &Variables, path: &Path) -> Result<()> {
    let none = variables.only_numbers(&[]);
    none.map_err(|e| file_error(path, e))
}
