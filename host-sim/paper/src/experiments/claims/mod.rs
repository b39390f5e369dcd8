//! Do the paper's claims hold? DAS and rank-1 ESMV over seeds, geometries, media and disturbances.
//!
//! A scene is one pose of one bone in water or in tissue, quiet or disturbed. Echoes add up, so that bone,
//! tissue and clutter are simulated once a pose and summed for its four scenes.

mod bones;
mod geometry;
mod judge;
mod kept;
mod mechanism;
mod pose;
mod scene;
mod show;
mod tuning;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::{Error, Result};
use bonebeam_drive::config::{Image, PhaseSymmetry};
use bonebeam_files::settings::{LENGTHS, check_level, check_positive, out_of_range};
use bonebeam_simulate::{NoiseSpectrum, Settings};

use super::common::Receive;
use super::common::variants::Variant;
use super::{Context, Experiment, Outcome, Overrides, Shows};
use geometry::{GEOMETRIES, Geometries};
use judge::{ClaimsResult, judge};
use pose::{Medium, Pose};
use scene::SceneResult;
use tuning::Tuned;

/// Section `[claims]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Claims {
    /// A closed surface in mm as the second geometry, in place of one that is made of the built-in vertebra.
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<PathBuf>,
    /// Height of the slice through the built-in vertebra, m.
    slice: f64,
    /// Height of the slice through the mesh, m.
    mesh_slice: f64,
    /// Mean depth of the bone's shallowest point, m.
    depth: f64,
    /// How many seeds are judged. The first is that of `simulation`.
    seeds: u64,
    /// How many other seeds the parameters of phase symmetry are tuned on.
    tuning_seeds: u64,
    /// The time windows K, samples.
    half_windows: Vec<usize>,
    /// The disturbance: noise, dB of the largest sample.
    noise: f64,
    /// Diffuse clutter in the bone's shadow, dB of a scatterer of bone.
    clutter: f64,
    /// The bone's image at twice its depth, dB.
    reverberation: f64,
    /// Words that a scene's name must have; all scenes without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    only: Vec<String>,
    /// Array, pulse, transmit, and the noise of quiet scenes.
    simulation: Settings,
    /// Delay and beamformer.
    receive: Receive,
    /// B-mode in water.
    water: Image,
    /// B-mode in tissue.
    tissue: Image,
    /// The paper's ridge filter in water.
    water_phase_symmetry: PhaseSymmetry,
    /// And in tissue.
    tissue_phase_symmetry: PhaseSymmetry,
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
            clutter: -2.0,
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

impl Experiment for Claims {
    const NAME: &'static str = "claims";

    const SHOWS: Shows = Shows {
        figures: &[],
        tables: &[],
        claims: true,
    };

    const FLAGS: &'static [&'static str] = &["--mesh", "--only", "--keep", "--merge"];

    /// Two seeds, one to tune on, half the beams, one time window.
    fn quick() -> Self {
        let full = Claims::default();
        Claims {
            seeds: 2,
            tuning_seeds: 1,
            half_windows: vec![2],
            simulation: Settings {
                beams: 64,
                beam_step: 2.0,
                ..full.simulation
            },
            ..full
        }
    }

    fn resolve(&mut self) {
        self.receive.resolve(&self.simulation);
        self.water.resolve_square();
        self.tissue.resolve_square();
    }

    fn apply(&mut self, overrides: &Overrides) {
        overrides.replace(&mut self.simulation.seed, Some(&mut self.mesh));
        if !overrides.only.is_empty() {
            self.only = overrides.only.clone();
        }
    }

    fn validate(&self) -> Result<()> {
        self.simulation.validate()?;
        self.receive.0.validate()?;
        self.water.validate()?;
        self.tissue.validate()?;
        self.water_phase_symmetry.validate()?;
        self.tissue_phase_symmetry.validate()?;
        check_positive(Self::NAME, "depth", self.depth, LENGTHS, " (m)")?;
        for (key, count) in [("seeds", self.seeds), ("tuning_seeds", self.tuning_seeds)] {
            if !(1..=10_000).contains(&count) {
                return Err(out_of_range(Self::NAME, key, count, "1 to 10000"));
            }
        }
        if self.half_windows.is_empty() || self.half_windows.iter().any(|k| *k > 100) {
            let message =
                "`half_windows` in [claims] must have at least one number, each at most 100";
            return Err(Error::Usage(message.into()));
        }
        for (key, level) in [
            ("noise", self.noise),
            ("clutter", self.clutter),
            ("reverberation", self.reverberation),
        ] {
            check_level(Self::NAME, key, Some(level))?;
        }
        if self.poses().is_empty() {
            return Err(Error::Usage(format!(
                "--only {} leaves no scene; their words are built-in, mesh, water, tissue, quiet, disturbed",
                self.only.join(",")
            )));
        }
        Ok(())
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let geometries = Geometries::new(self)?;
        let tuned = self.tune(context, &geometries)?;
        let poses = self.poses();
        let mut scenes: Vec<SceneResult> = Vec::new();
        for merged in context.merged {
            scenes.extend(scene::read(merged)?);
        }
        let first = self.simulation.seed;
        let count = poses.len() as u64 * self.seeds;
        for (k, seed) in (first..first.saturating_add(self.seeds)).enumerate() {
            for (p, &geometry) in poses.iter().enumerate() {
                let number = k * poses.len() + p + 1;
                let what = format!("claims: pose {number} of {count}");
                let pose = Pose::new(self, context, &geometries, geometry, seed, &what)?;
                for scene in scene::scenes(&pose, &tuned)? {
                    scenes.retain(|old| !old.is_same(&scene));
                    scenes.push(scene);
                }
            }
        }
        scenes.sort_by_key(SceneResult::order);
        let bones = bones::shown(self, context, &geometries)?;
        let mechanism = mechanism::shown(self, context, &geometries)?;
        let result: ClaimsResult = judge(scenes, tuned, self);
        show::outcome(&result, bones, mechanism, geometries.attachment())
    }
}

impl Claims {
    /// DAS, and rank-1 ESMV with every time window, forward and forward-backward.
    fn variants(&self) -> Vec<Variant> {
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
    fn wants(&self, geometry: &str, medium: Medium, disturbed: bool) -> bool {
        let name = [geometry, medium.name(), pose::disturbance(disturbed)];
        self.only.iter().all(|word| name.contains(&&word[..]))
    }

    /// The geometries of which a scene is wanted.
    fn poses(&self) -> Vec<&'static str> {
        let wanted = |geometry: &&&str| {
            let media = [Medium::Water, Medium::Tissue].into_iter();
            media
                .flat_map(|medium| [(medium, false), (medium, true)])
                .any(|(medium, disturbed)| self.wants(geometry, medium, disturbed))
        };
        GEOMETRIES.iter().filter(wanted).copied().collect()
    }

    /// The parameters of phase symmetry that are best for each beamformer and medium, on seeds that are
    /// not judged.
    fn tune(&self, context: &Context<'_>, geometries: &Geometries) -> Result<Vec<Tuned>> {
        // Seeds far from those that are judged, here or in another run.
        let first = 1 << 40;
        let mut scores = Vec::new();
        for seed in first..first + self.tuning_seeds {
            for geometry in self.poses() {
                let what = format!("claims: tune {}", seed - first + 1);
                let pose = Pose::new(self, context, geometries, geometry, seed, &what)?;
                scores.extend(tuning::scores(&pose)?);
            }
        }
        Ok(tuning::best(tuning::means(scores)))
    }
}
