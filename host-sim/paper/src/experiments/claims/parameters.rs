//! The parameters of the claims, and the scenes and beamformers that they ask for.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::medium::{Medium, disturbance};
use crate::experiments::common::Receive;
use crate::experiments::common::variants::Variant;
use bonebeam_drive::config::{Image, PhaseSymmetry};
use bonebeam_simulate::{DiffuseClutter, NoiseSpectrum, Settings};

/// The geometries by name.
pub const GEOMETRIES: [&str; 2] = ["built-in", "mesh"];

/// Section `[claims]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Claims {
    /// A closed surface in mm as the second geometry, in place of one that is made of the built-in vertebra.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh: Option<PathBuf>,
    /// Height of the slice through the built-in vertebra, m.
    pub(super) slice: f64,
    /// Height of the slice through the mesh, m.
    pub(super) mesh_slice: f64,
    /// Mean depth of the bone's shallowest point, m.
    pub(super) depth: f64,
    /// How many seeds are judged. The first is that of `simulation`.
    pub(super) seeds: u64,
    /// How many other seeds the parameters of phase symmetry are tuned on.
    pub(super) tuning_seeds: u64,
    /// The time windows K, samples.
    pub(super) half_windows: Vec<usize>,
    /// The disturbance: noise, dB of the largest sample.
    pub(super) noise: f64,
    /// The disturbance: diffuse clutter in the bone's shadow.
    pub(super) clutter: DiffuseClutter,
    /// The bone's image at twice its depth, dB.
    pub(super) reverberation: f64,
    /// Words that a scene's name must have; all scenes without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) only: Vec<String>,
    /// Array, pulse, transmit, and the noise of quiet scenes.
    pub(super) simulation: Settings,
    /// Delay and beamformer.
    pub(super) receive: Receive,
    /// B-mode in water.
    pub(super) water: Image,
    /// B-mode in tissue.
    pub(super) tissue: Image,
    /// The paper's ridge filter in water.
    pub(super) water_phase_symmetry: PhaseSymmetry,
    /// And in tissue.
    pub(super) tissue_phase_symmetry: PhaseSymmetry,
}

impl Default for Claims {
    fn default() -> Self {
        let mut receive = Receive::default();
        receive.0.depth_end = Some(44.2e-3);
        Claims {
            mesh: None,
            slice: -4e-3,
            mesh_slice: 0.0,
            depth: 15e-3,
            seeds: 8,
            tuning_seeds: 2,
            half_windows: vec![0, 2, 10],
            noise: -40.0,
            clutter: DiffuseClutter {
                level: 4.4,
                coherence: Some(1e-3),
                ..DiffuseClutter::default()
            },
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

    /// Whether the scene is wanted.
    pub(super) fn wants(&self, geometry: &str, medium: Medium, disturbed: bool) -> bool {
        let name = [geometry, medium.name(), disturbance(disturbed)];
        self.only.iter().all(|word| name.contains(&&word[..]))
    }

    /// The geometries of which a scene is wanted.
    pub(super) fn poses(&self) -> Vec<&'static str> {
        let wanted = |geometry: &&&str| {
            let media = [Medium::Water, Medium::Tissue].into_iter();
            media
                .flat_map(|medium| [(medium, false), (medium, true)])
                .any(|(medium, disturbed)| self.wants(geometry, medium, disturbed))
        };
        GEOMETRIES.iter().filter(wanted).copied().collect()
    }
}
