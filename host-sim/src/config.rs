//! Every parameter, from TOML and from the command line.
//!
//! A value comes from the command line, else from the file of `--config`, else from the defaults,
//! which are the paper's and the contract's. Every run writes the configuration that it used next
//! to its outputs; that file can be given to `--config` again.

use std::io::Write;
use std::path::{Path, PathBuf};

use bonebeam_drive::config::{Beamform, Image, PhaseSymmetry, Surface};
use bonebeam_files::atomic::Outputs;
use bonebeam_files::settings::read_toml_with;
use bonebeam_formats::Variables;
use bonebeam_simulate::Simulate;
use serde::{Deserialize, Serialize};

use crate::provenance::{Input, PROGRAM};
use crate::{Error, Result};

/// All parameters, one section per stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Phantom and scanner.
    pub simulate: Simulate,
    /// Delay and beamformer.
    pub beamform: Beamform,
    /// Image: from lines to pixels.
    pub image: Image,
    /// The ridge filter.
    pub phase_symmetry: PhaseSymmetry,
    /// The bone surface.
    pub surface: Surface,
    /// Names of the arrays in a recording.
    #[serde(skip_serializing_if = "Variables::is_empty")]
    pub variables: Variables,
}

impl Config {
    /// Reads a TOML file; keys that it lacks keep their defaults.
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
        self.surface.validate()?;
        self.variables.check().map_err(Error::Usage)
    }

    /// Path of the configuration of `output`: `.config.toml` is added to its name.
    pub fn path_beside(output: &Path) -> PathBuf {
        let mut name = output.as_os_str().to_owned();
        name.push(".config.toml");
        PathBuf::from(name)
    }

    /// Stages the configuration as TOML, with comments at its head.
    ///
    /// The comments give the program's version and commit, the command, and the hash of each input.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_to(
        &self,
        command: &str,
        inputs: &[Input],
        path: &Path,
        outputs: &mut Outputs,
    ) -> Result<()> {
        outputs.add(path, |sink| {
            let command = command.escape_debug();
            writeln!(sink, "# host-sim {PROGRAM}: {command}")?;
            for input in inputs {
                let name = input.path.to_string_lossy();
                let hash = input.xxh128.as_deref().unwrap_or("not computed");
                writeln!(sink, "# input {}, xxh128 {hash}", name.escape_debug())?;
            }
            write!(sink, "\n{}", toml::to_string(self)?)?;
            Ok(())
        })
    }
}
