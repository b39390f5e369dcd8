//! `host-sim check`: what a recording's own echoes say about its keys.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::{ConfigArgument, VariableArguments, load_config, recording_help, tell_assumed};
use crate::config::Config;
use crate::provenance::{COMMIT, VERSION};
use crate::{Error, Result};
use bonebeam_check::{Finding, Severity, check, doubt, sound_speed};
use bonebeam_drive::config::Beamform;
use bonebeam_drive::policy::warnings;
use bonebeam_files::terminal::{one_line, print, remark, warn};
use bonebeam_files::{ChannelData, Recording, file_error};
use bonebeam_formats::RecordingFile;

/// Check a recording by its own echoes.
///
/// Order, signs, single elements, frequency, sound speed, time zero.
///
/// It reads the first frame and changes nothing. Each finding is a line with its value, the interval of 95 %, its
/// effect in mm, and the flag or key that mends it. The exit status is 4 if the picture is wrong, 3 if depths, levels
/// or single elements are, and 0 otherwise. docs/check.md lists what each check can and cannot see, and how often it is
/// right on simulated faults.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[arg(value_name = "FILE", help = recording_help())]
    recording: PathBuf,

    #[command(flatten)]
    variables: VariableArguments,

    /// Print the findings as JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    config: ConfigArgument,
}

const EXAMPLES: &str = "\
Examples:
  host-sim check recording.hdf5
  host-sim check recording.npz --json
  host-sim check recording.mat --variable rf=RcvData --variable c=1540";

#[derive(Serialize)]
struct Report<'a> {
    version: &'static str,
    commit: &'static str,
    input: String,
    findings: &'a [Finding],
}

/// Runs the command, and ends the program with its exit status.
///
/// # Errors
/// A recording that is not valid, or that holds no channel data.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    arguments.variables.apply(&mut config.variables)?;
    config.validate()?;
    let path = &arguments.recording;
    let file = RecordingFile::open(path, &config.variables)?;
    tell_assumed(path, &file);
    let needs = |held| file_error(path, format!("holds {held}; check needs channel data"));
    let data = match file.first() {
        Recording::Channel(data) => data,
        Recording::Aligned(_) => return Err(needs("aligned data")),
        Recording::Lines(_) => return Err(needs("lines")),
    };
    let findings = check(data);
    if arguments.json {
        let report = Report {
            version: VERSION,
            commit: COMMIT,
            input: path.display().to_string(),
            findings: &findings,
        };
        let json = serde_json::to_string_pretty(&report);
        let json = json.map_err(|e| Error::Data(e.to_string()))?;
        print(&format!("{json}\n"))?;
    } else {
        let lines: Vec<String> = findings
            .iter()
            .map(|finding| one_line(&finding.to_string()) + "\n")
            .collect();
        print(&lines.concat())?;
    }
    match findings.iter().map(|finding| finding.severity).max() {
        Some(Severity::Error) => std::process::exit(4),
        Some(Severity::Warning) => std::process::exit(3),
        Some(Severity::Note) | None => Ok(()),
    }
}

/// Warns of parameters that are probably a mistake, and of doubtful elements.
///
/// # Errors
/// Depths that are not recorded.
pub fn warn_of(path: &Path, data: &ChannelData, parameters: &Beamform) -> Result<()> {
    let survey = data.samples.survey();
    let warnings = warnings(data, &survey, parameters)?;
    for warning in warnings.into_iter().chain(doubt(data, &survey)) {
        warn(&format!("{}: {warning}", path.display()));
    }
    Ok(())
}

/// `--estimate-sound-speed`, shared by the commands that beamform.
#[derive(Debug, Args)]
pub struct EstimateArgument {
    /// Beamform with the sound speed that the first frame's echoes have
    ///
    /// It is printed with its interval of 95 % and its effect on depth; LINES.npz and the written configuration have
    /// it. docs/check.md explains the estimate.
    #[arg(long, help_heading = "Recording")]
    estimate_sound_speed: bool,
}

impl EstimateArgument {
    /// Sets the sound speed of the configuration if the flag is given.
    ///
    /// # Errors
    /// A recording that is not valid, or whose echoes do not show their speed.
    pub fn apply(&self, path: &Path, config: &mut Config) -> Result<()> {
        if !self.estimate_sound_speed {
            return Ok(());
        }
        let file = RecordingFile::open(path, &config.variables)?;
        let found = match file.first() {
            Recording::Channel(data) => sound_speed(data),
            Recording::Aligned(_) | Recording::Lines(_) => None,
        };
        let Some(found) = found else {
            let message = "the echoes do not show their sound speed; take --sound-speed";
            return Err(file_error(path, message));
        };
        remark(&format!("{}: {found}", path.display()));
        config.beamform.sound_speed = Some(found.value);
        Ok(())
    }
}
