//! Parameters of the claims; their scenes and beamformers.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::condition::{Condition, Medium};
use crate::experiments::common::Receive;
use crate::experiments::common::variants::Variant;
use bonebeam_drive::config::{Image, PhaseSymmetry};
use bonebeam_simulate::{BoneSurface, DiffuseClutter, NoiseSpectrum, Settings};

/// Section `[claims]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Claims {
    /// Closed surface in mm in place of the shapes drawn from the built-in vertebra.
    ///
    /// Every bone is a pose of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh: Option<PathBuf>,
    /// Height of the slice through the mesh, m.
    pub(super) mesh_slice: f64,
    /// Heights of the slices through drawn shapes, m.
    pub(super) slices: [f64; 2],
    /// Depths of the bones' shallowest points, m.
    pub(super) depths: [f64; 2],
    /// Amplitudes of the tissue's scatterers, dB relative to bone.
    pub(super) tissue_levels: [f64; 2],
    /// Largest tilt in the image plane, in either direction, degrees.
    pub(super) tilt: f64,
    /// How the bones' surfaces scatter; each has a relief of its own.
    pub(super) bone: BoneSurface,
    /// Number of judged bones. The number of the first is the seed of `simulation`.
    pub(super) bones: u64,
    /// Number of bones, from the first, that are also imaged in 3-D; not for a mesh.
    pub(super) volumes: u64,
    /// Number of other bones that the filter is tuned on.
    pub(super) tuning_bones: u64,
    /// The time windows K, samples.
    pub(super) half_windows: Vec<usize>,
    /// Disturbance: noise, dB relative to the largest sample.
    pub(super) noise: f64,
    /// Disturbance: diffuse clutter in the bone's shadow.
    pub(super) clutter: DiffuseClutter,
    /// Attenuation in the scenes that have it, dB/(cm·MHz).
    pub(super) attenuation: f64,
    /// Disturbance: level of the bone's image at twice its depth, dB.
    pub(super) reverberation: f64,
    /// Words that a scene's name must have; if empty, all scenes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) only: Vec<String>,
    /// Array, pulse, transmit, and noise of quiet scenes.
    pub(super) simulation: Settings,
    /// Delay and beamformer.
    pub(super) receive: Receive,
    /// B-mode parameters in water.
    pub(super) water: Image,
    /// B-mode parameters in tissue.
    pub(super) tissue: Image,
    /// The paper's filter in water.
    pub(super) water_phase_symmetry: PhaseSymmetry,
    /// The paper's filter in tissue.
    pub(super) tissue_phase_symmetry: PhaseSymmetry,
}

impl Default for Claims {
    fn default() -> Self {
        let mut receive = Receive::default();
        receive.0.depth_end = Some(44.2e-3);
        Claims {
            mesh: None,
            mesh_slice: 0.0,
            slices: [-10e-3, 1e-3],
            depths: [10e-3, 30e-3],
            tissue_levels: [-30.5, -8.0],
            tilt: 15.0,
            bone: BoneSurface::default(),
            bones: 12,
            volumes: 4,
            tuning_bones: 3,
            half_windows: vec![0, 10],
            noise: -40.0,
            clutter: DiffuseClutter {
                level: 4.6,
                coherence: Some(2e-3),
                ..DiffuseClutter::default()
            },
            attenuation: 0.5,
            reverberation: -20.0,
            only: Vec::new(),
            simulation: Settings {
                fs: 40e6,
                depth_end: 44.2e-3,
                noise: Some(-60.0),
                noise_spectrum: NoiseSpectrum::Amplifier,
                ..Settings::default()
            },
            receive,
            water: Image {
                dynamic_range: 70.0,
                median: true,
                ..Image::default()
            },
            tissue: Image {
                median: true,
                ..Image::default()
            },
            water_phase_symmetry: PhaseSymmetry {
                scales: (5..=9).map(|k| f64::from(-k).exp2()).collect(),
                threshold: 10.0,
                ..PhaseSymmetry::default()
            },
            tissue_phase_symmetry: PhaseSymmetry::default(),
        }
    }
}

impl Claims {
    /// DAS, and rank-1 ESMV with every time window, forward and forward-backward.
    pub(super) fn variants(&self) -> Vec<Variant> {
        let mut all = vec![Variant::forward("das", 0)];
        for &k in &self.half_windows {
            for mut variant in [
                Variant::forward("esmv-rank1", k),
                Variant::forward_backward("esmv-rank1", k),
            ] {
                variant.key = format!("{}-k{k}", variant.key);
                variant.name = format!("{}, K = {k}", variant.name);
                all.push(variant);
            }
        }
        all
    }

    /// Whether a condition is selected.
    pub(super) fn wants(&self, condition: Condition) -> bool {
        let name = [condition.medium().name(), condition.disturbance()];
        self.only.iter().all(|word| name.contains(&&word[..]))
    }

    /// The selected conditions.
    pub(super) fn conditions(&self) -> Vec<Condition> {
        let all = Condition::ALL.into_iter();
        all.filter(|condition| self.wants(*condition)).collect()
    }

    /// Key of the paper's beamformer in a medium.
    ///
    /// Its covariance is forward, its time window the shortest in water and the longest in tissue.
    pub(super) fn papers(&self, medium: Medium) -> String {
        let windows = self.half_windows.iter().copied();
        let window = match medium {
            Medium::Water => windows.min(),
            Medium::Tissue => windows.max(),
        };
        format!("esmv-rank1-k{}", window.unwrap_or(0))
    }
}
