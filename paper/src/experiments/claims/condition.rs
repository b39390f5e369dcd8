//! Conditions of a bone's scenes: the medium, and the disturbances.

use bonebeam_files::choice;
use bonebeam_files::section::Value;

choice! {
    /// The medium around the bone; its name is a word of `--only`.
    Medium {
        /// Water, without echoes
        Water = "water",
        /// Scatterers of one amplitude
        Tissue = "tissue",
    }
}

choice! {
    /// A condition of a scene; its name is the medium's, then the disturbance.
    ///
    /// All but the quiet ones have noise, clutter in the bone's shadow and its reverberation. In 3-D, the bone is a volume
    /// below an array with a lens. Layers are skin, fat, fasciae and muscle. Attenuation grows with frequency. Aberration
    /// is on receive, RMS. A wrong speed is the beamformer's.
    #[derive(PartialOrd, Ord)]
    Condition {
        /// water, quiet
        WaterQuiet = "water-quiet",
        /// water, disturbed
        WaterDisturbed = "water-disturbed",
        /// water, disturbed, in 3-D
        WaterVolume = "water-volume",
        /// tissue, quiet
        TissueQuiet = "tissue-quiet",
        /// tissue, disturbed
        TissueDisturbed = "tissue-disturbed",
        /// tissue, layers with fasciae
        Layers = "tissue-layers",
        /// tissue, attenuation
        Attenuation = "tissue-attenuation",
        /// tissue, aberration 20 ns
        Aberration20 = "tissue-aberration-20-ns",
        /// tissue, aberration 35 ns
        Aberration35 = "tissue-aberration-35-ns",
        /// tissue, sound speed −2 %
        SpeedLow = "tissue-speed-low",
        /// tissue, sound speed +2 %
        SpeedHigh = "tissue-speed-high",
    }
}

impl Condition {
    /// The words of `--only` that select it: the medium and the disturbance.
    pub fn words(self) -> [&'static str; 2] {
        self.name()
            .split_once('-')
            .map_or(["", ""], <[&str; 2]>::from)
    }

    pub fn medium(self) -> Medium {
        match self.words()[0] {
            "water" => Medium::Water,
            _ => Medium::Tissue,
        }
    }

    /// Whether it has noise, clutter and reverberation.
    pub fn is_disturbed(self) -> bool {
        self.words()[1] != "quiet"
    }

    /// The name in tables.
    pub fn title(self) -> &'static str {
        Condition::choices()[self as usize][1]
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
