//! The parameters of a simulation: the section and its flags.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use super::{LENGTHS, check_positive, out_of_range};
use crate::simulate::{Phantom, Settings, Tissue};
use crate::{Error, Result};

const SECTION: &str = "simulate";

/// Section `[simulate]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Simulate {
    /// What is imaged.
    pub phantom: Kind,
    /// Point: how far it lies to the right of the middle element, m.
    pub offset: f64,
    /// Vertebra: a closed surface as a PLY file in mm (+x towards the front, +z towards the head)
    /// in place of the built-in one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<PathBuf>,
    /// Vertebra: the height of the slice, m.
    pub slice: f64,
    /// Vertebra: the depth of its shallowest point, m.
    pub depth: f64,
    /// Vertebra: whether soft tissue surrounds it, not water.
    pub tissue: bool,
    /// Whether the record is I/Q: demodulated with the centre frequency, at the lowest rate of at least twice
    /// that.
    pub iq: bool,
    /// Array, pulse, transmits, record and noise. Without this section they are the paper's for
    /// the phantom; with it, a key that it leaves out is the paper's, and the record noise-free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scanner: Option<Settings>,
}

/// The phantoms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// One scatterer at the transmit focus, noise-free (the paper's Fig. 2)
    Point,
    /// A slice of a lumbar vertebra from behind, in a water bath, with noise at -40 dB
    Vertebra,
}

/// The flags that go over the section.
#[derive(Debug, Args)]
pub struct SimulateFlags {
    /// What is imaged
    #[arg(value_enum, required_unless_present = "path")]
    phantom: Option<Kind>,

    /// How far the point lies to the right of the middle element, m [default: 0]
    #[arg(long, value_name = "M", help_heading = "Point")]
    offset: Option<f64>,

    /// A closed surface in mm, +x towards the front and +z towards the head, in place of the
    /// built-in vertebra
    #[arg(long, value_name = "FILE.ply", help_heading = "Vertebra")]
    mesh: Option<PathBuf>,

    /// Height of the slice, m [default: 0]
    #[arg(long, value_name = "M", help_heading = "Vertebra")]
    slice: Option<f64>,

    /// Depth of the bone's shallowest point, m [default: 0.015]
    #[arg(long, value_name = "M", help_heading = "Vertebra")]
    depth: Option<f64>,

    /// Soft tissue around the bone, not water
    #[arg(long, help_heading = "Vertebra")]
    tissue: bool,

    /// Electronic noise, dB relative to the largest sample of the record [default: none for the
    /// point, -40 for the vertebra]
    #[arg(long, value_name = "DB", help_heading = "Scanner")]
    noise: Option<f64>,

    /// Write I/Q in place of RF: demodulated with the centre frequency and decimated
    #[arg(long, help_heading = "Scanner")]
    iq: bool,

    /// No electronic noise
    #[arg(long, conflicts_with = "noise", help_heading = "Scanner")]
    noise_free: bool,

    /// Seed of noise and tissue [default: 1]
    #[arg(long, value_name = "N", help_heading = "Scanner")]
    seed: Option<u64>,

    /// Depth of the transmit focus, m [default: 0.015]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    focus: Option<f64>,

    /// Transmit f-number [default: 2.8]
    #[arg(long, help_heading = "Scanner")]
    f_number: Option<f64>,

    /// How many beams [default: 128]
    #[arg(long, value_name = "N", help_heading = "Scanner")]
    beams: Option<usize>,

    /// Where the first beam lies, in pitches from the first element [default: 0]
    #[arg(long, value_name = "PITCHES", help_heading = "Scanner")]
    first_beam: Option<f64>,

    /// Distance between the beams, in pitches [default: 1]
    #[arg(long, value_name = "PITCHES", help_heading = "Scanner")]
    beam_step: Option<f64>,

    /// Shallowest depth that the record serves, m [default: 0.012 for the point, 0.005 for the
    /// vertebra]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    depth_start: Option<f64>,

    /// Greatest depth that the record serves, m [default: 0.018 for the point, 0.04 for the
    /// vertebra]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    depth_end: Option<f64>,
}

impl Default for Simulate {
    fn default() -> Self {
        Self {
            phantom: Kind::Vertebra,
            offset: 0.0,
            mesh: None,
            slice: 0.0,
            depth: 15e-3,
            tissue: false,
            iq: false,
            scanner: None,
        }
    }
}

impl Simulate {
    /// What the flags say in place of the section's values.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] for a flag of the other phantom.
    pub fn apply(&mut self, flags: &SimulateFlags) -> Result<()> {
        self.phantom = flags.phantom.unwrap_or(self.phantom);
        self.offset = flags.offset.unwrap_or(self.offset);
        self.mesh = flags.mesh.clone().or(self.mesh.take());
        self.slice = flags.slice.unwrap_or(self.slice);
        self.depth = flags.depth.unwrap_or(self.depth);
        self.tissue |= flags.tissue;
        self.iq |= flags.iq;
        let scanner = self.scanner();
        scanner.noise = match flags.noise_free {
            true => None,
            false => flags.noise.or(scanner.noise),
        };
        scanner.seed = flags.seed.unwrap_or(scanner.seed);
        scanner.focus = flags.focus.unwrap_or(scanner.focus);
        scanner.f_number = flags.f_number.unwrap_or(scanner.f_number);
        scanner.beams = flags.beams.unwrap_or(scanner.beams);
        scanner.first_beam = flags.first_beam.unwrap_or(scanner.first_beam);
        scanner.beam_step = flags.beam_step.unwrap_or(scanner.beam_step);
        scanner.depth_start = flags.depth_start.unwrap_or(scanner.depth_start);
        scanner.depth_end = flags.depth_end.unwrap_or(scanner.depth_end);
        flags.refuse_those_of_the_other(self.phantom)
    }

    /// The scanner's settings, those of the paper for the phantom unless told otherwise; from
    /// here on the configuration tells them.
    pub fn scanner(&mut self) -> &mut Settings {
        let phantom = self.phantom;
        self.scanner.get_or_insert_with(|| match phantom {
            Kind::Point => Settings::point(),
            Kind::Vertebra => Settings::vertebra(),
        })
    }

    /// The phantom, as `scanner` images it.
    ///
    /// # Errors
    /// A mesh that cannot be read, a slice that does not cut the bone, or a phantom outside the
    /// record.
    pub fn build(&self, scanner: &Settings) -> Result<Phantom> {
        let phantom = match self.phantom {
            Kind::Point => Phantom::point(scanner, self.offset),
            Kind::Vertebra => Phantom::slice(self.mesh.as_deref(), self.slice, self.depth)?,
        };
        phantom.check_within(scanner)?;
        if self.phantom == Kind::Point || !self.tissue {
            return Ok(phantom);
        }
        let tissue = Tissue {
            seed: scanner.seed,
            ..Tissue::default()
        };
        Ok(phantom.with_tissue(&tissue))
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        for (key, value) in [("offset", self.offset), ("slice", self.slice)] {
            let most = LENGTHS[1];
            if !(-most..=most).contains(&value) {
                let expected = format!("-{most} to {most} (m)");
                return Err(out_of_range(SECTION, key, value, &expected));
            }
        }
        check_positive(SECTION, "depth", self.depth, LENGTHS, " (m)")?;
        self.scanner.as_ref().map_or(Ok(()), Settings::validate)
    }
}

impl SimulateFlags {
    /// A flag that would have no effect is a mistake.
    fn refuse_those_of_the_other(&self, phantom: Kind) -> Result<()> {
        let flags = [
            ("--offset", self.offset.is_some(), Kind::Point),
            ("--mesh", self.mesh.is_some(), Kind::Vertebra),
            ("--slice", self.slice.is_some(), Kind::Vertebra),
            ("--depth", self.depth.is_some(), Kind::Vertebra),
            ("--tissue", self.tissue, Kind::Vertebra),
        ];
        match flags.iter().find(|(_, given, of)| *given && *of != phantom) {
            None => Ok(()),
            Some((flag, ..)) => Err(Error::Usage(format!(
                "{flag} has no effect on the phantom {}",
                match phantom {
                    Kind::Point => "point",
                    Kind::Vertebra => "vertebra",
                }
            ))),
        }
    }
}
