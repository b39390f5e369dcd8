//! Folders of a SonixDAQ: one file `CH000.daq` per channel.
//!
//! Each has three 32-bit numbers and then 16-bit samples. The files do not describe the scan: `[variables]` does, and
//! usual values of the machine are assumed for missing ones.

use std::fs;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use ndarray::{Array4, ArrayD};

use crate::aliases::is_given;
use crate::keyed::Keyed;
use crate::values::{AxisRange, NamedArrays, Values};
use crate::variables::{AXES, BUFFER, CHANNELS, Given, LAWS, LAYOUT, RX_ELEMENT, TRACK, Variables};
use bonebeam_files::memory::{self, product};
use bonebeam_files::{ChannelData, Error, Result, Samples, cannot_be_opened, file_error, input};

/// The header of a file: a number, number of records, samples per record.
const HEADER: usize = 12;
/// Largest number of channels.
const MAX_CHANNELS: usize = 1000;
/// Channels of the vendor's board, in eight groups of sixteen.
const BOARD: usize = 128;
const GROUPS: usize = 8;
/// The rate at which the machine samples 128 channels, Hz.
const RATE: f64 = 40e6;

/// A folder without named arrays.
struct Folder {
    path: PathBuf,
}

impl NamedArrays for Folder {
    fn error(&self, message: String) -> Error {
        file_error(&self.path, message)
    }

    fn names(&self) -> Vec<String> {
        Vec::new()
    }

    fn numbers(&self, name: &str) -> Result<ArrayD<f64>> {
        Err(self.error(format!("has no array `{name}`; a folder has none")))
    }

    fn sides(&self, _: &str) -> Option<Vec<usize>> {
        None
    }

    fn shape_for_parts(&self, _: &str) -> Result<Option<Vec<usize>>> {
        Ok(None)
    }

    fn samples(&self, name: &str, _: Option<AxisRange>) -> Result<Values> {
        Err(self.error(format!("has no array `{name}`; a folder has none")))
    }
}

/// Whether a folder is a SonixDAQ's.
pub fn is(path: &Path) -> bool {
    path.join(name(0)).is_file()
}

fn name(channel: usize) -> String {
    format!("CH{channel:03}.daq")
}

/// Adds usual values of the machine for missing ones; returns assumptions.
fn complete(folder: &Folder, variables: &Variables, channels: usize) -> (Variables, Vec<String>) {
    let mut all = variables.clone();
    let mut assumed = Vec::new();
    let mut assume = |keys: &[&str], given: Given, why: &str| {
        if !keys.iter().any(|key| is_given(folder, variables, key)) {
            all.insert(keys[0], given);
            assumed.push(why.to_owned());
        }
    };
    let number = Given::Number;
    assume(
        &["fs"],
        number(RATE),
        "fs is 40 MHz, as the machine samples 128 channels",
    );
    assume(&["c"], number(1540.0), "c is 1540 m/s");
    assume(
        &["t0"],
        number(0.0),
        "t0 is 0: sample 0 is when the wave passes the array's middle",
    );
    let laws = ["tx_angle"]
        .iter()
        .chain(&LAWS)
        .copied()
        .collect::<Vec<_>>();
    let why = "each record is a frame of one plane wave straight down, since no delay law is given";
    assume(&laws, number(0.0), why);
    if channels == BOARD {
        let board = Given::Name("board".into());
        let why =
            "channels are in the order of the vendor's board (channels=element if they are not)";
        assume(&[CHANNELS], board, why);
    }
    (all, assumed)
}

/// Channel data of some frames, number of all frames, and assumptions.
///
/// The records of the files are transmits; after the last of them comes the next frame.
///
/// # Errors
/// A file that is missing or damaged, records of different lengths, or variables that do not describe the scan.
pub fn read(
    path: &Path,
    variables: &Variables,
    frames: Range<usize>,
) -> Result<(ChannelData, usize, Vec<String>)> {
    let folder = Folder {
        path: path.to_path_buf(),
    };
    let channels = channels(path)?;
    let [records, samples] = header(&path.join(name(0)))?;
    let (all, assumed) = complete(&folder, variables, channels);
    let all = all.spread(records, channels);
    let keyed = Keyed {
        source: &folder,
        variables: &all,
        law: None,
    };
    keyed.check_that_all_has_effect(
        variables,
        &["rf", "iq", AXES, BUFFER, LAYOUT, RX_ELEMENT, TRACK],
    )?;
    let transmits = keyed.transmits_given()?;
    let element = order(&folder, channels, &all)?;
    if transmits == 0 || records % transmits != 0 {
        return Err(folder.error(format!(
            "has {records} records per channel; expected a multiple of the {transmits} transmits of the \
             delay law"
        )));
    }
    let held = records / transmits;
    let end = frames.end.min(held);
    let frames = frames.start.min(end)..end;
    let shape = (frames.len(), transmits, channels, samples);
    let record = product(&[frames.len(), transmits, samples]);
    // Of one channel at a time the raw bytes as well.
    let raw = product(&[record, size_of::<i16>()]);
    let size = product(&[record, channels, size_of::<f32>()]);
    memory::check(size.saturating_add(raw), "the recording")
        .map_err(|e| folder.error(e.to_string()))?;
    let mut rf = Array4::zeros(shape);
    for (channel, &element) in element.iter().enumerate() {
        let path = path.join(name(channel));
        if header(&path)? != [records, samples] {
            return Err(file_error(
                &path,
                format!(
                    "differs from {} in its records: expected {records} of {samples} samples",
                    name(0)
                ),
            ));
        }
        let record = 2 * samples;
        let from = HEADER + frames.start * transmits * record;
        let bytes = bytes_at(&path, from, frames.len() * transmits * record)
            .map_err(|e| file_error(&path, cannot_be_opened(&e)))?;
        let (pairs, _) = bytes.as_chunks::<2>();
        for (record, pairs) in pairs.chunks_exact(samples).enumerate() {
            let index = (record / transmits, record % transmits, element);
            for (n, pair) in pairs.iter().enumerate() {
                rf[(index.0, index.1, index.2, n)] = f32::from(i16::from_le_bytes(*pair));
            }
        }
    }
    let data = keyed.with_samples(Samples::Rf(rf), transmits, channels)?;
    Ok((data, held, assumed))
}

/// Reads `count` bytes of a file from an offset.
fn bytes_at(path: &Path, from: usize, count: usize) -> std::io::Result<Vec<u8>> {
    let mut file = input::open(path)?;
    file.seek(SeekFrom::Start(from as u64))?;
    let mut bytes = vec![0; count];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Number of channels, one file each.
fn channels(path: &Path) -> Result<usize> {
    let missing = |channel: &usize| !path.join(name(*channel)).is_file();
    let channels = (0..MAX_CHANNELS).find(missing).unwrap_or(MAX_CHANNELS);
    let entries = fs::read_dir(path).map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    let named = |entry: std::io::Result<fs::DirEntry>| {
        let name = entry.ok()?.file_name().into_string().ok()?;
        (name.starts_with("CH") && name.ends_with(".daq")).then_some(())
    };
    let all = entries.filter_map(named).count();
    if all > channels {
        let message = format!("has {all} channels, and {} is missing", name(channels));
        return Err(file_error(path, message));
    }
    Ok(channels)
}

/// The element of each channel.
fn order(folder: &Folder, channels: usize, variables: &Variables) -> Result<Vec<usize>> {
    match variables.get(CHANNELS) {
        Some(Given::Name(order)) if order == "element" => Ok((0..channels).collect()),
        Some(Given::Name(order)) if order == "board" && channels == BOARD => {
            // The board's order, as in the vendor's `readDAQ.m`: 0, 16, 32 … 112, 1, 17 …
            Ok((0..channels)
                .map(|channel| (channel % GROUPS) * (BOARD / GROUPS) + channel / GROUPS)
                .collect())
        }
        None if channels != BOARD => Ok((0..channels).collect()),
        _ => Err(folder.error(format!(
            "has {channels} channels; expected --variable {CHANNELS}=element if each file is the \
             element of its number, or, of {BOARD} files, {CHANNELS}=board for the board's own order"
        ))),
    }
}

/// Numbers of records and of samples per record, checked against the file's length.
fn header(path: &Path) -> Result<[usize; 2]> {
    let open = |e: std::io::Error| file_error(path, cannot_be_opened(&e));
    let mut file = input::open(path).map_err(open)?;
    let length = file.metadata().map_err(open)?.len();
    let mut head = [0; HEADER];
    file.read_exact(&mut head)
        .map_err(|_| file_error(path, "is truncated: it has no header"))?;
    let number = |at: usize| {
        let bytes = [head[at], head[at + 1], head[at + 2], head[at + 3]];
        usize::try_from(i32::from_le_bytes(bytes))
            .ok()
            .filter(|&n| n > 0)
    };
    let (Some(records), Some(samples)) = (number(4), number(8)) else {
        return Err(file_error(path, "is damaged: its header counts no samples"));
    };
    let expected = HEADER as u64 + 2 * records as u64 * samples as u64;
    if length != expected {
        return Err(file_error(
            path,
            format!(
                "has {length} bytes; expected {expected}, {records} records of {samples} samples"
            ),
        ));
    }
    Ok([records, samples])
}
