//! Comparison of detectors of the bone surface.
//!
//! The scenes are three views of a spine under layers of tissue, clean and disturbed.

pub(super) mod detectors;
pub(super) mod disturb;
pub(super) mod show;

use super::study::*;
use bonebeam_drive::coherence::of_first_frame;
use bonebeam_simulate::Bone;

use super::common::layers::fill_layers;
use detectors::{Answer, DEPTHS, DETECTORS, Frame, METHODS};
use disturb::{Condition, Disturbances};
use show::{FAMILIES, SceneResult};

parameters! {
    /// Section `[surface]`.
    Surface "surface" [simulation, receive, image] {
        /// Frames of each view.
        seeds: u64 = 2, within([1.0, 10_000.0], "");
        /// Depth of the bone's shallowest point, m.
        depth: f64 = 15e-3, positive(LENGTHS, " (m)");
        /// Thickness of the slab, m.
        thickness: f64 = 4e-3, positive([1e-6, 0.1], " (m)");
        /// Scatterers per m³, scaled to the brightness of 60 per mm³.
        density: f64 = 30e9, positive([1e6, 1e13], " (per m³)");
        /// The threshold of phase symmetry.
        threshold: f64 = 15.0, positive([1e-6, 1e12], "");
        /// Array, pulse, transmit, noise.
        simulation: Settings = Settings {
            fs: 40e6,
            depth_start: 2e-3,
            depth_end: 45e-3,
            focus: 20e-3,
            ..Settings::volume()
        } => Settings::validate;
        /// Delay and beamformer.
        receive: Receive = Receive::between(2.2e-3, 44.2e-3) => Receive::validate;
        /// The image for phase symmetry.
        image: Image = Image { median: true, ..Image::default() } => Image::validate;
        /// Disturbances of the recordings.
        disturbances: Disturbances = Disturbances::default() => Disturbances::check;
    }
}

/// The answers of every detector in one disturbed scene.
struct Answered {
    family: &'static str,
    condition: Condition,
    /// Lateral positions of the lines, m.
    x: Vec<f64>,
    surface: Vec<Option<f64>>,
    /// Answers in the order of [`DETECTORS`].
    answers: Vec<Vec<Answer>>,
}

impl Answered {
    fn known(&self) -> Known<'_> {
        Known {
            x: &self.x,
            depths: &self.surface,
        }
    }
}

impl Experiment for Surface {
    fn quick() -> Self {
        let full = Surface::default();
        Surface {
            seeds: 1,
            thickness: 0.5e-3,
            density: 8e9,
            simulation: common::quick(full.simulation),
            ..full
        }
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let mut scenes = Vec::new();
        let first = self.simulation.seed;
        for seed in first..first.saturating_add(self.seeds) {
            for (name, bone) in &FAMILIES {
                self.scene(context, name, bone.as_ref(), seed, &mut scenes)?;
            }
        }
        let mut results = Vec::new();
        for condition in Condition::ALL {
            let scenes = || scenes.iter().filter(|s| s.condition == condition);
            for (k, detector) in DETECTORS.iter().enumerate() {
                let frames: Vec<_> = scenes()
                    .map(|s| (s.answers[k].clone(), s.known()))
                    .collect();
                let judged = scenes().zip(detectors::judged(&frames, TOLERANCE));
                results.extend(judged.map(|(scene, judged)| SceneResult {
                    family: scene.family,
                    condition,
                    detector: detector.name,
                    judged,
                }));
            }
        }
        show::outcome(self.seeds, &results)
    }
}

impl Surface {
    /// The answers of every detector in every condition of a scene.
    fn scene(
        &self,
        context: &Context<'_>,
        name: &'static str,
        bone: Option<&Bone<'_>>,
        seed: u64,
        scenes: &mut Vec<Answered>,
    ) -> Result<()> {
        let settings = Settings {
            seed,
            ..self.simulation.clone()
        };
        let phantom = phantom(bone, self.depth, [self.thickness, self.density], &settings)?;
        let what = format!("surface: {name}, seed {seed}");
        let file = format!("surface-{}-{seed}", name.replace(' ', "-"));
        let names = [&file[..], &format!("{what}: simulate")];
        let recorded = recording(context, names, &settings, &phantom)?;
        let disturbed = self.disturbances.of(&settings, &recorded)?;
        for condition in Condition::ALL {
            let step = format!("{what}: {}", condition.title());
            (context.progress)(&step, 0.0);
            let data = disturbed.under(condition)?;
            let variants = METHODS.map(|key| Variant::of(key, 0));
            let mut lines = lines_of(&step, &data, &self.receive, &variants, context.progress)?;
            // Depths are by the true speed of sound.
            lines.iter_mut().for_each(|lines| lines.c = recorded.c);
            let surface = lines[0].beam_x.iter().map(|x| {
                let depth = phantom.bone.as_ref()?.first_hit(*x)?;
                (DEPTHS[0]..=DEPTHS[1]).contains(&depth).then_some(depth)
            });
            let surface = surface.collect();
            let coherence = of_first_frame(&data, &self.receive.0)?;
            let frame = |lines| Frame::new(lines, Some(&coherence), &self.image, self.threshold);
            let frames: Vec<Frame<'_>> = lines.iter().map(frame).collect();
            let mut answers = Vec::new();
            for (k, detector) in DETECTORS.iter().enumerate() {
                (context.progress)(&step, k as f64 / DETECTORS.len() as f64);
                answers.push(frames[detector.method].answers(*detector)?);
            }
            scenes.push(Answered {
                family: name,
                condition,
                x: lines[0].beam_x.clone(),
                surface,
                answers,
            });
        }
        Ok(())
    }
}

/// A slab of tissue layers with a bone whose shallowest point is at `depth`, m.
///
/// The slab has a thickness, m, and a number of scatterers per m³. Without a bone, it has the layers alone.
///
/// # Errors
/// A bone that does not lie below the array.
pub(super) fn phantom(
    bone: Option<&Bone<'_>>,
    depth: f64,
    [thickness, density]: [f64; 2],
    settings: &Settings,
) -> Result<Phantom> {
    let mut phantom = match bone {
        Some(bone) => bone.phantom(depth, thickness, None)?.0,
        None => Phantom::default(),
    };
    fill_layers(&mut phantom, [thickness, density], settings)?;
    Ok(phantom)
}
