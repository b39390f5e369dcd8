//! The parameters of a simulation.

use std::path::PathBuf;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::{check_positive, out_of_range};
use crate::Result;
use crate::simulate::{Phantom, Settings, Tissue};

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

impl Default for Simulate {
    fn default() -> Self {
        Self {
            phantom: Kind::Vertebra,
            offset: 0.0,
            mesh: None,
            slice: 0.0,
            depth: 15e-3,
            tissue: false,
            scanner: None,
        }
    }
}

impl Simulate {
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
            if !value.is_finite() {
                return Err(out_of_range(SECTION, key, value, "a finite number (m)"));
            }
        }
        check_positive(SECTION, "depth", self.depth, " (m)")?;
        self.scanner.as_ref().map_or(Ok(()), Settings::validate)
    }
}
