//! One file a subcommand: its arguments, and the order in which it calls on the rest.

pub mod beamform;
#[cfg(feature = "bench")]
pub mod bench;
#[cfg(not(feature = "bench"))]
pub mod bench_left_out;
pub mod completions;
pub mod convert;
mod frames;
pub mod golden;
pub mod info;
pub mod main_job;
mod measures;
pub mod paper;
pub mod phase_symmetry;
pub mod simulate;
pub mod surface;
mod surface_files;
mod surface_inputs;
pub mod tune;
pub mod verify;

use std::env;
use std::path::{Path, PathBuf};

use crate::config::Config;
use crate::{Error, Result};
use bonebeam_files::terminal::remark;
use bonebeam_files::{cannot_be_opened, file_error, input};
use bonebeam_formats::{Format, Layout, RecordingFile, Variables};
use clap::builder::PossibleValuesParser;

/// The file of `--config`, or the defaults.
fn load_config(path: Option<&Path>) -> Result<Config> {
    path.map_or_else(|| Ok(Config::default()), Config::read)
}

/// The command line as it was typed, for the head of the written configuration.
fn command_line() -> String {
    let words = env::args_os()
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned());
    words.collect::<Vec<_>>().join(" ")
}

/// An error about data that came from a file, with the file's name.
fn about(path: &Path, error: Error) -> Error {
    match error {
        Error::Data(_) | Error::Core(_) => Error::File {
            path: path.to_path_buf(),
            message: error.to_string(),
        },
        Error::Usage(_) | Error::File { .. } => error,
    }
}

/// The longest document that is read, bytes.
const LONGEST_DOCUMENT: u64 = 1 << 20;

/// A document whose tables are written anew.
fn read_document(path: &Path) -> Result<String> {
    let bytes = input::read(path, LONGEST_DOCUMENT);
    let bytes = bytes.map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    String::from_utf8(bytes).map_err(|_| file_error(path, "is not UTF-8"))
}

/// Tells on the standard error what a recording's file does not tell and was assumed; the run goes on.
fn tell_assumed(path: &Path, file: &RecordingFile) {
    if !file.assumed().is_empty() {
        let assumed = file.assumed().join("; ");
        remark(&format!("{}: assumed: {assumed}", path.display()));
    }
}

/// The help of the argument that every command takes that reads a recording.
fn recording_help() -> String {
    let formats = Format::names();
    format!("The recording; its content tells its format: {formats}")
}

/// `--variable`, which every command takes that reads a recording.
#[derive(Debug, clap::Args)]
struct VariableArguments {
    /// If the format does not fix them: the name that the file has for a key of channel data, or the key's
    /// value, such as rf=RcvData, c=1540, tx_angle=-0.1,0,0.1 or axes=sample,element,transmit
    #[arg(long = "variable", value_name = "KEY=NAME", help_heading = "Recording")]
    variables: Vec<String>,

    /// Which program's layout the arrays have, where their names do not tell
    #[arg(long, value_name = "PROGRAM", value_parser = layouts(), help_heading = "Recording")]
    layout: Option<String>,

    /// I/Q was written with the carrier's other sign
    #[arg(long, help_heading = "Recording")]
    iq_conjugate: bool,
}

/// The names of the layouts.
fn layouts() -> PossibleValuesParser {
    PossibleValuesParser::new(Layout::ALL.map(Layout::name))
}

impl VariableArguments {
    /// What the flags say in place of the section's values.
    fn apply(&self, variables: &mut Variables) -> Result<()> {
        let layout = self.layout.iter().map(|name| format!("layout={name}"));
        let conjugate = self.iq_conjugate.then(|| "iq_conjugate=1".to_owned());
        let all = self
            .variables
            .iter()
            .cloned()
            .chain(layout)
            .chain(conjugate);
        all.into_iter().try_for_each(|text| {
            let taken = variables.take(&text);
            taken.map_err(|message| Error::Usage(format!("--variable {message}")))
        })
    }
}

/// `--config`, which every command takes.
#[derive(Debug, clap::Args)]
struct ConfigArgument {
    /// TOML file with parameters, such as the one that an earlier run wrote; flags override it
    #[arg(long = "config", value_name = "FILE.toml")]
    path: Option<PathBuf>,
}
