//! The flags of a simulation.

use bonebeam_simulate::{Kind, Simulate};
use clap::Args;

use super::{Flags, choice};
use crate::{Error, Result};

/// Flags that override the section of the simulation.
#[derive(Debug, Args)]
pub struct SimulateFlags {
    /// The phantom
    #[arg(value_parser = choice::<Kind>(), required_unless_present = "path")]
    phantom: Option<Kind>,

    #[command(flatten)]
    flags: Flags<Simulate>,

    /// No electronic noise
    #[arg(long, conflicts_with = "noise", help_heading = "Scanner")]
    noise_free: bool,
}

impl SimulateFlags {
    /// Replaces the section's values by those of the flags.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] for a flag that has no effect.
    pub fn apply(&self, section: &mut Simulate) -> Result<()> {
        let phantom = self.phantom.unwrap_or(section.phantom);
        let mut given = self.flags.given();
        if let Some((flag, _)) = given.find(|(_, heading)| !phantom.has(heading)) {
            return Err(Error::Usage(format!(
                "--{flag} has no effect on the phantom {phantom}"
            )));
        }
        section.phantom = phantom;
        let clutter = section.clutter.is_some() || self.flags.has("clutter");
        self.flags.apply(section);
        let scanner = section.scanner();
        scanner.noise = scanner.noise.filter(|_| !self.noise_free);
        let noise = scanner.noise.is_some();
        let needs = [
            ("clutter-coherence", "clutter", clutter),
            ("clutter-fall", "clutter", clutter),
            ("sweep-step", "sweep", section.sweep > 1),
            ("noise-rise", "noise", noise),
        ];
        match needs
            .iter()
            .find(|(flag, _, has)| self.flags.has(flag) && !has)
        {
            None => Ok(()),
            Some((flag, needed, _)) => Err(Error::Usage(format!(
                "--{flag} has no effect without --{needed}"
            ))),
        }
    }
}
