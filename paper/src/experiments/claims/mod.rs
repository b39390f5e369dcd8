//! Do the paper's claims hold? DAS and rank-1 ESMV over bones, media, disturbances.
//!
//! A scene is one bone in one condition. Echoes add up, so bone, tissue and clutter are simulated once per bone and
//! summed for its scenes. Statistics count bones.

mod bones;
mod by_direction;
mod condition;
mod detectors;
mod judge;
mod mechanism;
mod parameters;
mod population;
mod pose;
mod scene;
mod show;
mod statements;
mod tuning;

use super::study::*;
use condition::Condition;
use judge::judge;
pub use parameters::Claims;
use pose::Pose;
use scene::SceneResult;
use tuning::Tuned;

/// First bone to tune on: far from the judged bones, here or in another run.
const TUNED: u64 = (1 << 40) + 100;

impl Experiment for Claims {
    /// Disturbed tissue, two bones, one to tune on, fewer beams, large pixels.
    fn quick() -> Self {
        let full = Claims::default();
        let coarse = |image: Image| Image {
            rows: Some(256),
            columns: Some(256),
            ..image
        };
        Claims {
            bones: 2,
            tuning_bones: 1,
            half_windows: vec![2],
            only: ["tissue", "disturbed"].map(String::from).to_vec(),
            simulation: common::quick(full.simulation),
            water: coarse(full.water),
            tissue: coarse(full.tissue),
            ..full
        }
    }

    fn resolve(&mut self) {
        self.receive.resolve(&self.simulation);
        self.water.resolve_square();
        self.tissue.resolve_square();
    }

    fn apply(&mut self, overrides: &Overrides) {
        let seed = &mut self.simulation.seed;
        *seed = overrides.seed.unwrap_or(*seed);
        overrides.replace_mesh(&mut self.mesh);
        if !overrides.only.is_empty() {
            self.only = overrides.only.clone();
        }
    }

    fn validate(&self) -> Result<()> {
        self.bone.validate(Self::NAME)?;
        if self.half_windows.is_empty() || self.half_windows.iter().any(|k| *k > 100) {
            let message =
                "`half_windows` in [claims] must have at least one number, each at most 100";
            return Err(Error::Usage(message.into()));
        }
        self.clutter.validate(Self::NAME)?;
        if self.conditions().is_empty() {
            let mut words: Vec<&str> = vec!["water", "tissue"];
            for [_, disturbance] in Condition::ALL.map(Condition::words) {
                if !words.contains(&disturbance) {
                    words.push(disturbance);
                }
            }
            return Err(Error::Usage(format!(
                "--only {} leaves no scene; valid words are {}",
                self.only.join(","),
                words.join(", ")
            )));
        }
        Ok(())
    }

    fn check_merged(&self, data: &serde_json::Value) -> Result<()> {
        scene::read(data).map(drop)
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let tuned = self.tune(context)?;
        let mut scenes: Vec<SceneResult> = Vec::new();
        for merged in context.merged {
            scenes.extend(scene::read(merged)?);
        }
        let first = self.simulation.seed;
        for number in first..first.saturating_add(self.bones) {
            let what = format!("claims: bone {} of {}", number - first + 1, self.bones);
            let pose = Pose::new(self, context, number, &what)?;
            for scene in scene::scenes(&pose, &tuned)? {
                scenes.retain(|old| !old.is_same(&scene));
                scenes.push(scene);
            }
        }
        scenes.sort_by_key(SceneResult::order);
        let bones = bones::shown(self, context)?;
        let mechanism = mechanism::shown(self, context)?;
        show::outcome(&judge(scenes, tuned, self)?, bones, mechanism)
    }
}

impl Claims {
    /// Best parameters of phase symmetry for each beamformer and medium.
    ///
    /// They are found on bones that are not judged.
    fn tune(&self, context: &Context<'_>) -> Result<Vec<Tuned>> {
        let mut scores = Vec::new();
        for number in TUNED..TUNED + self.tuning_bones {
            let what = format!("claims: tune {}", number - TUNED + 1);
            let pose = Pose::new(self, context, number, &what)?;
            scores.extend(tuning::scores(&pose)?);
        }
        Ok(tuning::best(tuning::means(scores)))
    }
}
