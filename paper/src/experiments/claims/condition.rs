//! Conditions of a bone's scenes: the medium, and the disturbances.

use serde::{Deserialize, Serialize};

/// The medium around the bone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Medium {
    /// Water, without echoes.
    Water,
    /// Scatterers of one amplitude.
    Tissue,
}

/// A condition of a scene.
///
/// All but the quiet ones have noise, clutter in the bone's shadow and its reverberation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Condition {
    WaterQuiet,
    WaterDisturbed,
    /// A bone in three dimensions, by an array with a lens.
    WaterVolume,
    TissueQuiet,
    TissueDisturbed,
    /// Skin, fat, fasciae and muscle.
    #[serde(rename = "tissue-layers")]
    Layers,
    /// Attenuation that grows with frequency.
    #[serde(rename = "tissue-attenuation")]
    Attenuation,
    /// Aberration on receive, 20 ns RMS.
    #[serde(rename = "tissue-aberration-20-ns")]
    Aberration20,
    /// Aberration on receive, 35 ns RMS.
    #[serde(rename = "tissue-aberration-35-ns")]
    Aberration35,
    /// Beamformed with a speed of sound that is 2 % too low.
    #[serde(rename = "tissue-speed-low")]
    SpeedLow,
    /// Beamformed with a speed of sound that is 2 % too high.
    #[serde(rename = "tissue-speed-high")]
    SpeedHigh,
}

impl Medium {
    /// The word that `--only` accepts.
    pub fn name(self) -> &'static str {
        match self {
            Medium::Water => "water",
            Medium::Tissue => "tissue",
        }
    }
}

impl Condition {
    pub const ALL: [Condition; 11] = [
        Condition::WaterQuiet,
        Condition::WaterDisturbed,
        Condition::WaterVolume,
        Condition::TissueQuiet,
        Condition::TissueDisturbed,
        Condition::Layers,
        Condition::Attenuation,
        Condition::Aberration20,
        Condition::Aberration35,
        Condition::SpeedLow,
        Condition::SpeedHigh,
    ];

    pub fn medium(self) -> Medium {
        match self {
            Condition::WaterQuiet | Condition::WaterDisturbed | Condition::WaterVolume => {
                Medium::Water
            }
            _ => Medium::Tissue,
        }
    }

    /// Whether it has noise, clutter and reverberation.
    pub fn is_disturbed(self) -> bool {
        !matches!(self, Condition::WaterQuiet | Condition::TissueQuiet)
    }

    /// The word that `--only` accepts.
    pub fn disturbance(self) -> &'static str {
        match self {
            Condition::WaterQuiet | Condition::TissueQuiet => "quiet",
            Condition::WaterDisturbed | Condition::TissueDisturbed => "disturbed",
            Condition::WaterVolume => "volume",
            Condition::Layers => "layers",
            Condition::Attenuation => "attenuation",
            Condition::Aberration20 => "aberration-20-ns",
            Condition::Aberration35 => "aberration-35-ns",
            Condition::SpeedLow => "speed-low",
            Condition::SpeedHigh => "speed-high",
        }
    }

    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Condition::WaterQuiet => "water, quiet",
            Condition::WaterDisturbed => "water, disturbed",
            Condition::WaterVolume => "water, disturbed, in 3-D",
            Condition::TissueQuiet => "tissue, quiet",
            Condition::TissueDisturbed => "tissue, disturbed",
            Condition::Layers => "tissue, layers with fasciae",
            Condition::Attenuation => "tissue, attenuation",
            Condition::Aberration20 => "tissue, aberration 20 ns",
            Condition::Aberration35 => "tissue, aberration 35 ns",
            Condition::SpeedLow => "tissue, sound speed −2 %",
            Condition::SpeedHigh => "tissue, sound speed +2 %",
        }
    }

    /// RMS of the elements' delays on receive, s; `None` without aberration.
    pub fn aberration(self) -> Option<f64> {
        match self {
            Condition::Aberration20 => Some(20e-9),
            Condition::Aberration35 => Some(35e-9),
            _ => None,
        }
    }

    /// The beamformer's speed of sound, as a factor of the true one.
    pub fn speed(self) -> f64 {
        match self {
            Condition::SpeedLow => 0.98,
            Condition::SpeedHigh => 1.02,
            _ => 1.0,
        }
    }
}
