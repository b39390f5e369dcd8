//! Parameters of the claims; their scenes and beamformers.

use super::condition::{Condition, Medium};
use crate::experiments::common::Common;
use crate::experiments::study::*;

/// Number of bones with figures.
pub const SHOWN: u64 = 2;

parameters! {
    /// Section `[claims]`.
    Claims "claims" {
        /// Closed surface in mm in place of the shapes drawn from the built-in vertebra.
        ///
        /// Every bone is a pose of it.
        #[serde(skip_serializing_if = "Option::is_none")]
        mesh: Option<PathBuf> = None;
        /// Height of the slice through the mesh, m.
        mesh_slice: f64 = 0.0, within([-0.1, 0.1], " (m)");
        /// Heights of the slices through drawn shapes, m.
        slices: [f64; 2] = [-10e-3, 1e-3], within([-0.1, 0.1], " (m)");
        /// Depths of the bones' shallowest points, m.
        depths: [f64; 2] = [10e-3, 30e-3], positive(LENGTHS, " (m)");
        /// Amplitudes of the tissue's scatterers, dB relative to bone.
        tissue_levels: [f64; 2] = [-30.5, -8.0], within([-100.0, 100.0], " (dB)");
        /// Largest tilt in the image plane, in either direction, degrees.
        tilt: f64 = 15.0, within([-90.0, 90.0], " (degrees)");
        /// How the bones' surfaces scatter; each has a relief of its own.
        bone: BoneSurface = BoneSurface::default();
        /// Number of judged bones. The number of the first is the seed of `simulation`.
        bones: u64 = 12, within([1.0, 10_000.0], "");
        /// Number of bones, from the first, that are also imaged in 3-D; not for a mesh.
        volumes: u64 = 4;
        /// Number of other bones that the filter is tuned on.
        tuning_bones: u64 = 3, within([1.0, 10_000.0], "");
        /// The time windows K, samples.
        half_windows: Vec<usize> = vec![0, 10];
        /// Disturbance: noise, dB relative to the largest sample.
        noise: f64 = -40.0, level();
        /// Disturbance: diffuse clutter in the bone's shadow.
        clutter: DiffuseClutter = DiffuseClutter {
            level: 4.6,
            coherence: Some(2e-3),
            ..DiffuseClutter::default()
        };
        /// Attenuation in the scenes that have it, dB/(cm·MHz).
        attenuation: f64 = 0.5, within([0.0, 10.0], " (dB/(cm·MHz))");
        /// Disturbance: level of the bone's image at twice its depth, dB.
        reverberation: f64 = -20.0, level();
        /// Words that a scene's name must have; if empty, all scenes.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        only: Vec<String> = Vec::new();
        /// Array, pulse, transmit, and noise of quiet scenes.
        simulation: Settings = Settings {
            fs: 40e6,
            depth_end: 44.2e-3,
            noise: Some(-60.0),
            noise_spectrum: NoiseSpectrum::Amplifier,
            ..Settings::default()
        } => Settings::validate;
        /// Delay and beamformer.
        receive: Receive = Receive::to(44.2e-3) => Receive::validate;
        /// B-mode parameters in water.
        water: Image = Image { dynamic_range: 70.0, median: true, ..Image::default() } => Image::validate;
        /// B-mode parameters in tissue.
        tissue: Image = Image { median: true, ..Image::default() } => Image::validate;
        /// The paper's filter in water.
        water_phase_symmetry: PhaseSymmetry = Common::default().phase_symmetry => PhaseSymmetry::validate;
        /// The paper's filter in tissue.
        tissue_phase_symmetry: PhaseSymmetry = PhaseSymmetry::default() => PhaseSymmetry::validate;
    }
}

impl Claims {
    /// DAS, and rank-1 ESMV with every time window, forward and forward-backward.
    pub(super) fn variants(&self) -> Vec<Variant> {
        let mut all = vec![Variant::of("das", 0)];
        for &k in &self.half_windows {
            for key in ["esmv-rank1", "esmv-rank1-fb"] {
                let mut variant = Variant::of(key, k);
                variant.key = format!("{}-k{k}", variant.key);
                variant.name = format!("{}, K = {k}", variant.name);
                all.push(variant);
            }
        }
        all
    }

    /// Whether a condition is selected.
    pub(super) fn wants(&self, condition: Condition) -> bool {
        let words = condition.words();
        self.only.iter().all(|word| words.contains(&&word[..]))
    }

    /// The selected conditions.
    pub(super) fn conditions(&self) -> Vec<Condition> {
        let all = Condition::ALL.into_iter();
        all.filter(|condition| self.wants(*condition)).collect()
    }

    /// The paper's time window in a medium: the shortest in water, the longest in tissue.
    pub(super) fn window(&self, medium: Medium) -> usize {
        let windows = self.half_windows.iter().copied();
        let window = match medium {
            Medium::Water => windows.min(),
            Medium::Tissue => windows.max(),
        };
        window.unwrap_or(0)
    }

    /// Key of the paper's beamformer in a medium; its covariance is forward.
    pub(super) fn papers(&self, medium: Medium) -> String {
        format!("esmv-rank1-k{}", self.window(medium))
    }
}
