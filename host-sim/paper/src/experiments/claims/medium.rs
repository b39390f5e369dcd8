//! The media and the disturbance of scenes.

use serde::{Deserialize, Serialize};

/// What surrounds the bone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Medium {
    /// Nothing that echoes.
    Water,
    /// Scatterers as bright as those of bone.
    Tissue,
}

impl Medium {
    /// As `--only` has it.
    pub fn name(self) -> &'static str {
        match self {
            Medium::Water => "water",
            Medium::Tissue => "tissue",
        }
    }
}

/// As `--only` has it.
pub fn disturbance(disturbed: bool) -> &'static str {
    if disturbed { "disturbed" } else { "quiet" }
}
