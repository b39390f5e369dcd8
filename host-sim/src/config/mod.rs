//! Every parameter, from TOML and from the command line.
//!
//! A value comes from the command line, else from the file of `--config`, else from the defaults,
//! which are the paper's and the contract's. Every run writes the configuration that it used next
//! to its outputs; that file can be given to `--config` again.

mod beamform;
mod image;
mod phase_symmetry;
mod simulate;

pub use beamform::{Beamform, BeamformFlags, LineKind, Reading, RfReading};
pub use image::{Image, ImageFlags, LONGER_SIDE};
pub use phase_symmetry::{PhaseSymmetry, PhaseSymmetryFlags, Size, parse_scale};
pub use simulate::{Kind, Simulate, SimulateFlags};

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::files::atomic::Outputs;
use crate::files::{Variables, cannot_be_opened};
use crate::terminal::short;
use crate::{Error, Result};

/// All parameters, one section a stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Phantom and scanner.
    pub simulate: Simulate,
    /// Delay and beamformer.
    pub beamform: Beamform,
    /// From lines to pixels.
    pub image: Image,
    /// The ridge filter.
    pub phase_symmetry: PhaseSymmetry,
    /// What a recording calls its arrays.
    #[serde(skip_serializing_if = "Variables::is_empty")]
    pub variables: Variables,
}

impl Config {
    /// Reads a TOML file; what it does not mention keeps its default.
    ///
    /// # Errors
    /// The file cannot be opened, or a line of it is not TOML, names an unknown key or has a
    /// value of the wrong type. Ranges are checked by [`Config::validate`].
    pub fn read(path: &Path) -> Result<Self> {
        read_toml_with(path, |text| toml::from_str(text))
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        self.simulate.validate()?;
        self.beamform.validate()?;
        self.image.validate()?;
        self.phase_symmetry.validate()?;
        self.variables.check().map_err(Error::Usage)
    }

    /// Where the configuration of the run that makes `output` is written: beside it, with
    /// `.config.toml` added to its name.
    pub fn path_beside(output: &Path) -> PathBuf {
        let mut name = output.as_os_str().to_owned();
        name.push(".config.toml");
        PathBuf::from(name)
    }

    /// Stages the configuration as TOML, headed by a comment that tells the program's version
    /// and the command.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn stage(&self, command: &str, path: &Path, outputs: &mut Outputs) -> Result<()> {
        let version = env!("CARGO_PKG_VERSION");
        outputs.stage(path, |sink| {
            let command = command.escape_debug();
            write!(
                sink,
                "# host-sim {version}: {command}\n\n{}",
                toml::to_string(self)?
            )?;
            Ok(())
        })
    }
}

/// Reads a TOML file with `parse`.
///
/// # Errors
/// As [`Config::read`].
pub(crate) fn read_toml_with<T>(
    path: &Path,
    parse: impl FnOnce(&str) -> std::result::Result<T, toml::de::Error>,
) -> Result<T> {
    let error = |message: String| Error::Usage(format!("{}: {message}", path.display()));
    let text = fs::read_to_string(path).map_err(|e| {
        let reason = cannot_be_opened(&e);
        error(format!("the configuration {reason}"))
    })?;
    parse(&text).map_err(|e| {
        // The parser may explain itself over several lines; the first says what is wrong.
        let message = e.message().lines().next().unwrap_or("not valid TOML");
        error(match e.span() {
            Some(span) => {
                let before = text.bytes().take(span.start);
                let line = 1 + before.filter(|&b| b == b'\n').count();
                format!("line {line}: {message}")
            }
            None => message.to_owned(),
        })
    })
}

/// The usage error for a parameter outside its range: its flag and its key, its value, and what
/// would be right.
pub(crate) fn out_of_range(
    section: &str,
    key: &str,
    value: impl std::fmt::Display,
    expected: &str,
) -> Error {
    let flag = key.replace('_', "-");
    let value = short(value);
    Error::Usage(format!(
        "--{flag} (`{key}` in [{section}]) is {value}; expected {expected}"
    ))
}

/// Lengths that an image, a bone or a record can have, m.
pub(crate) const LENGTHS: [f64; 2] = [1e-6, 10.0];
/// The most elements, eigenvectors or rows that are asked for: beyond it a number is a mistake.
pub(crate) const MAX_COUNT: usize = 65_536;

/// A number above zero, between the two: beyond them it is in another unit.
pub(crate) fn check_positive(
    section: &str,
    key: &str,
    value: f64,
    [least, most]: [f64; 2],
    unit: &str,
) -> Result<()> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    let expected = format!("a number above 0, from {least} to {most}{unit}");
    Err(out_of_range(section, key, value, &expected))
}

/// A level in decibels, where there is one.
pub(crate) fn check_level(section: &str, key: &str, level: Option<f64>) -> Result<()> {
    match level {
        Some(level) if !(-200.0..=40.0).contains(&level) => {
            Err(out_of_range(section, key, level, "-200 to 40 (dB)"))
        }
        _ => Ok(()),
    }
}

/// A count from 1 to [`MAX_COUNT`].
pub(crate) fn check_count(section: &str, key: &str, value: usize) -> Result<()> {
    if (1..=MAX_COUNT).contains(&value) {
        return Ok(());
    }
    let expected = format!("at least 1 and at most {MAX_COUNT}");
    Err(out_of_range(section, key, value, &expected))
}
