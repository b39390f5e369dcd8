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
mod lines;
mod mat5;
mod npz;
mod picmus;
mod receivers;
mod recording_file;
mod sonix;
mod uff;
mod values;
mod variables;
mod waves;
mod zea;

pub use blocks::Blocks;
pub use export::Export;
pub use layout::Layout;
pub use recording_file::RecordingFile;
pub use variables::{Given, Variables};

use std::io::Read;
use std::ops::Range;
use std::path::Path;

use bonebeam_files::{
    ChannelData, Error, Recording, Result, Samples, SharedHash, cannot_be_opened, choice,
    file_error, input,
};
use hdf5::Store;
use mat5::Mat5;
use values::NamedArrays;
use variables::{IQ_CONJUGATE, RX_ELEMENT, TRACK};

choice! {
    /// A format of recordings, by its name in messages.
    Format {
        /// NumPy's archive with the keys of docs/file-formats.md.
        Npz = ".npz archive",
        /// zea's HDF5.
        Zea = "zea (HDF5)",
        /// `channel_data` of USTB's Ultrasound File Format.
        Uff = "UFF (HDF5)",
        /// HDF5 of the Plane-Wave Imaging Challenge.
        Picmus = "PICMUS (HDF5)",
        /// MATLAB 7.3, which is HDF5.
        Mat73 = "MATLAB 7.3 (HDF5)",
        /// MATLAB 5 to 7.2.
        Mat5 = "MATLAB 5",
        /// Any other HDF5, by the names of its arrays.
        Hdf5 = "HDF5",
        /// A folder with one file per channel.
        Sonix = "SonixDAQ folder",
    }
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
        "expected one of {names}, with channel data (`rf`, `iq`), aligned data (`x`) or lines (`lines`), see --help"
    )
}

/// Number of bytes at a file's beginning that show its format.
const HEAD: u64 = (1 << 16) + 8;
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Least offset of HDF5 behind a user block, such as MATLAB's; others are doubled.
const USER_BLOCK: usize = 512;

const MATLAB: &[u8] = b"MATLAB";

/// Formats that are not read, by their first bytes.
const FOREIGN: [(&[u8], &str); 7] = [
    (b"\x93NUMPY", "a single .npy array"),
    (b"\x1f\x8b", "compressed with gzip"),
    (
        MATLAB,
        "a MATLAB file that is damaged or of an unknown version",
    ),
    (b"\x89PNG", "a picture"),
    (b"DICM", "a DICOM file"),
    (
        b"ObjectType = Image",
        "a sequence of PLUS or 3D Slicer, for `sweep` and `info`, or `convert` if it has lines of RF",
    ),
    (
        b"NRRD",
        "a sequence of 3D Slicer, for `sweep` and `info`, or `convert` if it has lines of RF",
    ),
];

/// Whether a file begins as HDF5 does.
pub fn is_hdf5(path: &Path) -> bool {
    let mut head = [0; HDF5.len()];
    let read = input::open(path).and_then(|mut file| file.read_exact(&mut head));
    read.is_ok() && head == HDF5
}

/// Tracks with raw data of a file of zea: names, and labels in parentheses.
///
/// Of other files none.
///
/// # Errors
/// An HDF5 file that cannot be opened.
pub fn tracks(path: &Path) -> Result<Vec<[String; 2]>> {
    match is_hdf5(path) {
        true => Ok(zea::tracks(&Store::open(path, false)?)),
        false => Ok(Vec::new()),
    }
}

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
    /// Names of the file's arrays that were not read.
    pub unread: Vec<String>,
}

/// Reads some frames of channel data or aligned data, or lines.
///
/// The format is recognized by content. Frames that do not exist are left out.
///
/// # Errors
/// The file cannot be opened, has a format that is not read, or is not valid.
pub fn read(path: &Path, variables: &Variables, frames: Range<usize>) -> Result<Found> {
    let found = read_as_stored(path, variables, frames, None)?;
    Ok(Found {
        recording: found.recording.into_float(),
        ..found
    })
}

/// As [`read`]; samples that an archive stores as i16 stay i16, and with a hash a large frame may stay in its file.
fn read_as_stored(
    path: &Path,
    variables: &Variables,
    frames: Range<usize>,
    hash: Option<SharedHash>,
) -> Result<Found> {
    variables.check().map_err(Error::Usage)?;
    let mut found = read_as_written(path, variables, frames, hash)?;
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

fn read_as_written(
    path: &Path,
    variables: &Variables,
    frames: Range<usize>,
    hash: Option<SharedHash>,
) -> Result<Found> {
    if path.is_dir() {
        return match sonix::is(path) {
            true => {
                let (data, held, assumed) = sonix::read(path, variables, frames)?;
                Ok(channel((data, held), Format::Sonix, assumed, Vec::new()))
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
    let begins = |at: usize| head.get(at..).is_some_and(|bytes| bytes.starts_with(HDF5));
    if begins(0) || (0..8).any(|k| begins(USER_BLOCK << k)) {
        return read_hdf5(path, head.starts_with(MATLAB), variables, frames);
    }
    let version = head.get(124..128);
    if version == Some(&[0, 1, b'I', b'M']) || version == Some(&[1, 0, b'M', b'I']) {
        let source = Mat5::open(path)?;
        return keyed(&source, variables, frames, Format::Mat5);
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    if head.starts_with(b"PK") {
        return npz_archive(path, variables, frames, hash);
    }
    if let Some((_, what)) = FOREIGN.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Err(file_error(path, format!("is {what}; {}", expected())));
    }
    // One that is cut short or damaged says so itself.
    if extension.eq_ignore_ascii_case("npz") {
        return npz_archive(path, variables, frames, hash);
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

fn npz_archive(
    path: &Path,
    variables: &Variables,
    frames: Range<usize>,
    hash: Option<SharedHash>,
) -> Result<Found> {
    let source = npz::Archive::open(path)?;
    let own = ["rf", "iq", "x", "z"].iter().any(|key| source.has(key))
        && !source.has(RX_ELEMENT)
        && !lines::is(&source, variables);
    if !own {
        let (completed, _) = aliases::complete(&source, variables);
        let named = |key: &&str| aliases::is_given(&source, &completed, key);
        if ["rf", "iq", "lines"].iter().any(named) {
            return keyed(&source, variables, frames, Format::Npz);
        }
        return Err(source.error(format!(
            "holds neither `rf` or `iq` (channel data) nor `x` (aligned data), and no lines (`z` and `beam_x`, or \
             `lines`); --variable rf=NAME names the samples; its arrays: {}",
            aliases::listed(&source)
        )));
    }
    refuse_without_effect(variables, path)?;
    let (recording, frames) = Recording::read_npz(path, frames, None, hash)?;
    Ok(Found {
        recording,
        format: Format::Npz,
        frames,
        assumed: Vec::new(),
        unread: other_keys(source.names()),
    })
}

/// The names of an archive that are no keys.
fn other_keys(mut names: Vec<String>) -> Vec<String> {
    let known = [
        &variables::KEYS[..],
        &variables::LINE_KEYS,
        &["x", "z", "sub_lines"],
    ];
    names.retain(|name| !known.iter().any(|keys| keys.contains(&name.as_str())));
    names
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
    let (data, format, assumed) = if matlab || store.is_octave() {
        let format = if matlab { Format::Mat73 } else { Format::Hdf5 };
        return keyed(&store, variables, frames, format);
    } else if picmus::is(&store) {
        only(&["fs", "c", "f0", "lens_delay"])?;
        let (data, assumed) = picmus::read(&store, variables)?;
        ((data, 1), Format::Picmus, assumed)
    } else if uff::is(&store) {
        only(&["fs", "c", "f0", "f_demod", "lens_delay"])?;
        let (data, held, assumed) = uff::read(&store, variables, frames)?;
        ((data, held), Format::Uff, assumed)
    } else if zea::is(&store, variables)? {
        only(&[TRACK, "fs", "c", "f0", "lens_delay"])?;
        let (data, held, assumed) = zea::read(&store, variables, frames)?;
        ((data, held), Format::Zea, assumed)
    } else {
        uff::refuse_other_version(&store, variables)?;
        return keyed(&store, variables, frames, Format::Hdf5);
    };
    let unread = store.unread();
    Ok(channel(data, format, assumed, unread))
}

/// Arrays with names that users choose.
fn keyed(
    source: &dyn NamedArrays,
    variables: &Variables,
    frames: Range<usize>,
    format: Format,
) -> Result<Found> {
    if lines::is(source, variables) {
        let (lines, assumed) = lines::read(source, variables)?;
        return Ok(Found {
            frames: lines.z.dim().0,
            recording: Recording::Lines(lines),
            format,
            assumed,
            unread: source.unread(),
        });
    }
    let (data, held, assumed) = layouts::channel_data(source, variables, frames)?;
    Ok(channel((data, held), format, assumed, source.unread()))
}

fn channel(
    (data, frames): (ChannelData, usize),
    format: Format,
    assumed: Vec<String>,
    unread: Vec<String>,
) -> Found {
    Found {
        recording: Recording::Channel(data),
        format,
        frames,
        assumed,
        unread,
    }
}

fn refuse_without_effect(variables: &Variables, path: &Path) -> Result<()> {
    let none = variables.only_numbers(&[]);
    none.map_err(|e| file_error(path, e))
}
