//! Do the paper's claims hold? DAS and rank-1 ESMV over seeds, geometries, media and disturbances.
//!
//! A scene is one pose of one bone in water or in tissue, quiet or disturbed. Echoes add up, so that bone,
//! tissue and clutter are simulated once a pose and summed for its four scenes.

mod bones;
mod geometry;
mod judge;
mod kept;
mod mechanism;
mod medium;
mod parameters;
mod pose;
mod scene;
mod show;
mod statements;
mod tuning;

use crate::{Error, Result};
use bonebeam_files::settings::{LENGTHS, check_level, check_positive, out_of_range};

use super::{Context, Covers, Experiment, Outcome, Overrides, common};
use geometry::Geometries;
use judge::{ClaimsResult, judge};
pub use parameters::Claims;
use pose::Pose;
use scene::SceneResult;
use tuning::Tuned;

impl Experiment for Claims {
    const NAME: &'static str = "claims";

    const COVERS: Covers = Covers {
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
            simulation: common::quick(full.simulation),
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
        for (key, level) in [("noise", self.noise), ("reverberation", self.reverberation)] {
            check_level(Self::NAME, key, Some(level))?;
        }
        self.clutter.validate(Self::NAME)?;
        if self.poses().is_empty() {
            return Err(Error::Usage(format!(
                "--only {} leaves no scene; their words are built-in, mesh, water, tissue, quiet, disturbed",
                self.only.join(",")
            )));
        }
        Ok(())
    }

    fn check_merged(&self, data: &serde_json::Value) -> Result<()> {
        scene::read(data).map(drop)
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
