//! Shared by the experiments: parameters, lines by every beamformer, pictures.

pub mod beamformers;
pub mod lines;
pub mod pictures;
mod receive;

pub use receive::Receive;

use serde::{Deserialize, Serialize};
use toml::de::ValueDeserializer;

use crate::{Error, Result};
use bonebeam_drive::check::References;
use bonebeam_drive::config::PhaseSymmetry;
use bonebeam_simulate::Settings;

/// Fewer beams, for a first look.
pub fn quick(simulation: Settings) -> Settings {
    Settings {
        beams: 64,
        beam_step: 2.0,
        ..simulation
    }
}

/// Scales 2⁻ᵏ from an exponent k to another, the finest first, cycles per pixel.
pub fn octaves([from, to]: [i32; 2]) -> Vec<f64> {
    (from..=to).map(|k| f64::from(-k).exp2()).collect()
}

/// Parameters shared by all experiments.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Common {
    /// Section `[phase_symmetry]`: filters and threshold, also of the water bath.
    pub phase_symmetry: PhaseSymmetry,
    /// Section `[checks]`: share of beams that the references compute again.
    pub checks: Checks,
}

/// Section `[checks]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Checks {
    /// One beam in this many goes through the f32 reference.
    pub every_f32: usize,
    /// One beam in this many goes through the f64 reference.
    pub every_f64: usize,
}

/// What results are compared with, and how many.
#[derive(Clone, Copy)]
pub struct Checking<'a> {
    /// The references.
    pub references: &'a References,
    /// The section `[checks]`.
    pub extent: &'a Checks,
}

impl Default for Common {
    fn default() -> Self {
        Common {
            phase_symmetry: PhaseSymmetry {
                scales: octaves([5, 9]),
                threshold: 10.0,
                ..PhaseSymmetry::default()
            },
            checks: Checks::default(),
        }
    }
}

impl Default for Checks {
    fn default() -> Self {
        Checks {
            every_f32: 8,
            every_f64: 32,
        }
    }
}

impl Common {
    /// The sections' names.
    pub const SECTIONS: [&'static str; 2] = ["phase_symmetry", "checks"];

    /// Fewer checks, for a first look.
    pub fn quick() -> Self {
        Common {
            checks: Checks {
                every_f32: 16,
                every_f64: 64,
            },
            ..Common::default()
        }
    }

    /// Reads the section of this name; returns false if there is none.
    pub(super) fn read(
        &mut self,
        name: &str,
        section: ValueDeserializer<'_>,
    ) -> std::result::Result<bool, toml::de::Error> {
        match name {
            "phase_symmetry" => self.phase_symmetry = PhaseSymmetry::deserialize(section)?,
            "checks" => self.checks = Checks::deserialize(section)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    pub(super) fn validate(&self) -> Result<()> {
        self.phase_symmetry.validate()?;
        if self.checks.every_f32 == 0 || self.checks.every_f64 == 0 {
            let message = "`every_f32` and `every_f64` in [checks] must be at least 1";
            return Err(Error::Usage(message.into()));
        }
        Ok(())
    }
}
