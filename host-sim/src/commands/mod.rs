//! Subcommands, one file each: their arguments and their steps.

pub mod beamform;
#[cfg(feature = "bench")]
pub mod bench;
#[cfg(not(feature = "bench"))]
pub mod bench_left_out;
pub mod check;
pub mod completions;
pub mod convert;
pub mod elsewhere;
mod frames;
pub mod info;
pub mod main_job;
mod measures;
pub mod phase_symmetry;
pub mod register;
mod sequence;
pub mod serve;
pub mod simulate;
pub mod surface;
mod surface_files;
mod surface_inputs;
pub mod sweep;
pub mod view;

use std::path::{Path, PathBuf};

use crate::arguments;
use crate::config::Config;
use crate::{Error, Result};
use bonebeam_files::terminal::remark;
use bonebeam_files::{cannot_be_opened, file_error, input};
use bonebeam_formats::{Format, Layout, RecordingFile, Variables};
use clap::builder::PossibleValuesParser;

/// Reads the file of `--config`; without it, returns the defaults.
///
/// # Errors
/// As [`Config::read`].
pub fn load_config(path: Option<&Path>) -> Result<Config> {
    path.map_or_else(|| Ok(Config::default()), Config::read)
}

/// The command line as it was typed, for the head of the written configuration.
fn command_line() -> String {
    let words = arguments::all()
        .into_iter()
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned());
    words.collect::<Vec<_>>().join(" ")
}

/// Adds the name of a file to an error about its data.
pub fn about(path: &Path, error: Error) -> Error {
    match error {
        Error::Data(_) | Error::Core(_) => Error::File {
            path: path.to_path_buf(),
            message: error.to_string(),
        },
        Error::Usage(_) | Error::File { .. } => error,
    }
}

/// Longest document to read, bytes.
const LONGEST_DOCUMENT: u64 = 1 << 20;

/// Reads a document whose tables will be rewritten.
///
/// # Errors
/// A file that cannot be read, is too long, or is not UTF-8.
pub fn read_document(path: &Path) -> Result<String> {
    let bytes = input::read(path, LONGEST_DOCUMENT);
    let bytes = bytes.map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    String::from_utf8(bytes).map_err(|_| file_error(path, "is not UTF-8"))
}

/// Prints on standard error the values that the file lacks and that were assumed.
fn tell_assumed(path: &Path, file: &RecordingFile) {
    if !file.assumed().is_empty() {
        let assumed = file.assumed().join("; ");
        remark(&format!("{}: assumed: {assumed}", path.display()));
    }
}

/// Help of the recording argument, shared by the commands that read one.
fn recording_help() -> String {
    let formats = Format::names();
    format!("The recording; its format is recognized from its content: {formats}")
}

/// Flags on a recording's arrays, shared by the commands that read one.
#[derive(Debug, clap::Args)]
struct VariableArguments {
    /// Name or value of a key of channel data, if the format gives none; repeatable
    ///
    /// Such as rf=RcvData for the file's name of rf, c=1540, tx_angle=-0.1,0,0.1 or axes=sample,element,transmit.
    #[arg(long = "variable", value_name = "KEY=NAME", help_heading = "Recording")]
    variables: Vec<String>,

    /// Program whose layout the arrays have, if their names do not show it
    #[arg(long, value_name = "PROGRAM", value_parser = layouts(), help_heading = "Recording")]
    layout: Option<String>,

    /// Track of a zea file with several
    #[arg(long, value_name = "NAME", help_heading = "Recording")]
    track: Option<String>,

    /// Conjugate I/Q that has the opposite sign of the carrier
    #[arg(long, help_heading = "Recording")]
    iq_conjugate: bool,
}

/// The names of the layouts.
fn layouts() -> PossibleValuesParser {
    PossibleValuesParser::new(Layout::ALL.map(Layout::name))
}

impl VariableArguments {
    /// Replaces the section's values by those of the flags.
    fn apply(&self, variables: &mut Variables) -> Result<()> {
        let layout = self.layout.iter().map(|name| format!("layout={name}"));
        let track = self.track.iter().map(|name| format!("track={name}"));
        let conjugate = self.iq_conjugate.then(|| "iq_conjugate=1".to_owned());
        let all = self
            .variables
            .iter()
            .cloned()
            .chain(layout)
            .chain(track)
            .chain(conjugate);
        all.into_iter().try_for_each(|text| {
            let taken = variables.take(&text);
            taken.map_err(|message| Error::Usage(format!("--variable {message}")))
        })
    }
}

/// `--config`, shared by the commands with parameters.
#[derive(Debug, clap::Args)]
pub struct ConfigArgument {
    /// TOML file with parameters, such as that of an earlier run; flags override it
    #[arg(long = "config", value_name = "FILE.toml")]
    pub path: Option<PathBuf>,
}
