//! `host-sim convert`: a recording or lines → `.npz`, UFF or zea's HDF5.

use std::path::PathBuf;

use clap::Args;

use super::{ConfigArgument, VariableArguments, load_config, recording_help, tell_assumed};
use crate::Result;
use crate::provenance::Snapshot;
use bonebeam_files::Recording;
use bonebeam_files::atomic::{Outputs, check_outputs};
use bonebeam_files::terminal::{print, warn};
use bonebeam_files::{file_error, npz};
use bonebeam_formats::{Export, RecordingFile, Variables};
use bonebeam_tracked::{Content, PoseTable, Sequence};
use ndarray::{Axis, arr0, stack};

/// Write a recording of any format, or lines, as .npz, UFF or zea's HDF5.
///
/// The ending of OUT sets the format: .npz, .uff, or for zea .hdf5 or .h5. The numbers do not change: float32 RF or
/// complex64 I/Q. docs/file-formats.md lists the keys of .npz archives. Lines of RF of PLUS (.mha, .nrrd) become an .npz,
/// with fs, pitch, f0, c and t0 by --variable.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[arg(value_name = "FILE", help = recording_help())]
    recording: PathBuf,

    /// Output file: .npz, .uff, or for zea .hdf5 or .h5
    #[arg(short, long, value_name = "OUT.npz")]
    output: PathBuf,

    #[command(flatten)]
    variables: VariableArguments,

    #[command(flatten)]
    config: ConfigArgument,
}

const EXAMPLES: &str = "\
Examples:
  host-sim convert recording.uff -o recording.npz
  host-sim convert recording.npz -o recording.hdf5
  host-sim convert lines.npz -o lines.uff
  host-sim convert lines.igs.mha --variable fs=40e6 --variable pitch=0.3e-3 -o lines.npz
  host-sim convert recording.mat --variable rf=RcvData --variable axes=sample,element,transmit \\
      --variable c=1540 -o recording.npz
  host-sim convert daq/ --variable channels=board --variable fs=40e6 --variable f0=6.6e6 \\
      --variable c=1540 --variable t0=0 --variable pitch=0.3e-3 --variable tx_angle=0 -o recording.npz";

/// Runs the command.
///
/// # Errors
/// A recording that is not valid, or an output that cannot be written.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    arguments.variables.apply(&mut config.variables)?;
    config.validate()?;
    check_outputs(&[&arguments.recording], &[&arguments.output])?;
    let export = Export::of(&arguments.output)?;
    let snapshot = Snapshot::of(&arguments.recording)?;
    let mut outputs = Outputs::new();
    if arguments.recording.is_file() && Sequence::recognizes(&arguments.recording) {
        add_lines(&arguments, &config.variables, &mut outputs)?;
        snapshot.check()?;
        outputs.commit()?;
        return print("lines of RF read, .npz written\n");
    }
    let file = RecordingFile::open(&arguments.recording, &config.variables)?;
    tell_assumed(&arguments.recording, &file);
    if let Recording::Channel(data) = file.first() {
        for warning in data.warnings(&data.samples.survey()) {
            warn(&format!("{}: {warning}", arguments.recording.display()));
        }
    }
    file.add_to(export, &arguments.output, &mut outputs)?;
    snapshot.check()?;
    outputs.commit()?;
    let format = match file.first() {
        Recording::Lines(_) => "lines",
        _ => file.format().name(),
    };
    print(&format!("{format} read, {} written\n", export.name()))
}

/// Adds the lines of a sequence as an archive with the given numbers.
fn add_lines(arguments: &Arguments, variables: &Variables, outputs: &mut Outputs) -> Result<()> {
    let path = &arguments.recording;
    let keys = ["fs", "pitch", "f0", "c", "t0"];
    let only = variables.only_numbers(&keys);
    only.map_err(|message| file_error(path, message))?;
    if Export::of(&arguments.output)? != Export::Npz {
        let message = "holds lines of RF or pictures; expected an output .npz";
        return Err(file_error(path, message));
    }
    let sequence = Sequence::open(path, &PoseTable::default())?;
    let mut reader = sequence.reader()?;
    let frames = 0..sequence.frames.len();
    let frames = frames.map(|frame| sequence.lines(reader.frame(frame)?));
    let frames = frames.collect::<Result<Vec<_>>>()?;
    let views: Vec<_> = frames.iter().map(|frame| frame.view()).collect();
    let lines = stack(Axis(0), &views).map_err(|e| file_error(path, e.to_string()))?;
    outputs.add(&arguments.output, |sink| {
        let mut npz = npz::Writer::new(sink, 8 * lines.len());
        match sequence.content == Content::RfReal {
            true => npz.add("lines", &lines.mapv(|value| value.re))?,
            false => npz.add("lines", &lines)?,
        }
        for key in keys {
            if let Some(number) = variables.number(key) {
                npz.add(key, &arr0(number))?;
            }
        }
        Ok(npz.finish()?)
    })
}
