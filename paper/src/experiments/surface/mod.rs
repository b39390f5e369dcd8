//! Comparison of detectors of the bone surface.
//!
//! The scenes are three views of a spine under layers of tissue, clean and disturbed.

pub(super) mod detectors;
pub(super) mod disturb;
pub(super) mod show;

use serde::{Deserialize, Serialize};

use crate::Result;
use bonebeam_drive::coherence::of_first_frame;
use bonebeam_drive::config::Image;
use bonebeam_files::BeamformedLines;
use bonebeam_files::settings::{LENGTHS, check_level, check_positive, out_of_range};
use bonebeam_simulate::{Bone, Phantom, Settings};

use crate::measure::surface::Known;

use super::common::layers::fill_layers;
use super::common::recording::recording;
use super::common::truth::TOLERANCE;
use super::common::variants::{Aligned, Variant};
use super::common::{self, Receive};
use super::{Context, Experiment, Outcome, Overrides};
use detectors::{Answer, DEPTHS, DETECTORS, Frame, METHODS};
use disturb::{Condition, Disturbances};
use show::{FAMILIES, SceneResult};

/// Section `[surface]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Surface {
    /// Frames of each view.
    seeds: u64,
    /// Depth of the bone's shallowest point, m.
    depth: f64,
    /// Thickness of the slab, m.
    thickness: f64,
    /// Scatterers per m³, scaled to the brightness of 60 per mm³.
    density: f64,
    /// The threshold of phase symmetry.
    threshold: f64,
    /// Array, pulse, transmit, noise.
    simulation: Settings,
    /// Delay and beamformer.
    receive: Receive,
    /// The image for phase symmetry.
    image: Image,
    /// Disturbances of the recordings.
    disturbances: Disturbances,
}

impl Default for Surface {
    fn default() -> Self {
        let mut receive = Receive::default();
        receive.0.depth_start = Some(2.2e-3);
        receive.0.depth_end = Some(44.2e-3);
        Surface {
            seeds: 2,
            depth: 15e-3,
            thickness: 4e-3,
            density: 30e9,
            threshold: 15.0,
            simulation: Settings {
                fs: 40e6,
                depth_start: 2e-3,
                depth_end: 45e-3,
                focus: 20e-3,
                ..Settings::volume()
            },
            receive,
            image: Image {
                median: true,
                ..Image::default()
            },
            disturbances: Disturbances::default(),
        }
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
    const NAME: &'static str = "surface";

    const FLAGS: &'static [&'static str] = &["--keep"];

    fn quick() -> Self {
        let full = Surface::default();
        Surface {
            seeds: 1,
            thickness: 2e-3,
            density: 10e9,
            simulation: common::quick(full.simulation),
            ..full
        }
    }

    fn resolve(&mut self) {
        common::resolve(&self.simulation, &mut self.receive, &mut self.image);
    }

    fn apply(&mut self, overrides: &Overrides) {
        overrides.replace(&mut self.simulation.seed, None);
    }

    fn validate(&self) -> Result<()> {
        common::validate(&self.simulation, &self.receive, &self.image)?;
        check_positive(Self::NAME, "depth", self.depth, LENGTHS, " (m)")?;
        check_positive(Self::NAME, "thickness", self.thickness, [1e-6, 0.1], " (m)")?;
        check_positive(
            Self::NAME,
            "density",
            self.density,
            [1e6, 1e13],
            " (per m³)",
        )?;
        check_positive(Self::NAME, "threshold", self.threshold, [1e-6, 1e12], "")?;
        if !(1..=10_000).contains(&self.seeds) {
            return Err(out_of_range(Self::NAME, "seeds", self.seeds, "1 to 10000"));
        }
        let d = &self.disturbances;
        check_level("surface.disturbances", "clutter", Some(d.clutter))?;
        check_level("surface.disturbances", "noise", Some(d.noise))?;
        let section = "surface.disturbances";
        check_positive(section, "aberration", d.aberration, [1e-12, 1e-6], " (s)")?;
        check_positive(
            section,
            "aberration_length",
            d.aberration_length,
            LENGTHS,
            " (m)",
        )?;
        check_positive(section, "speed_error", d.speed_error, [1e-6, 0.5], "")
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
            let scenes: Vec<&Answered> =
                scenes.iter().filter(|s| s.condition == condition).collect();
            for (k, detector) in DETECTORS.iter().enumerate() {
                let frames: Vec<_> = scenes
                    .iter()
                    .map(|s| (s.answers[k].clone(), s.known()))
                    .collect();
                let judged = detectors::judged(&frames, TOLERANCE);
                results.extend(
                    scenes
                        .iter()
                        .zip(judged)
                        .map(|(scene, judged)| SceneResult {
                            family: scene.family,
                            condition,
                            detector: detector.name(),
                            judged,
                        }),
                );
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
        let recorded = recording(context, &file, &settings, &phantom, &|done| {
            (context.progress)(&format!("{what}: simulate"), done);
        })?;
        let disturbed = self.disturbances.of(&settings, &recorded)?;
        for condition in Condition::ALL {
            let step = format!("{what}: {}", condition.name());
            (context.progress)(&step, 0.0);
            let data = disturbed.under(condition)?;
            let aligned = Aligned::new(&data, &self.receive)?;
            let by = |key: &&str| {
                let variant = Variant::forward(key, 0);
                let lines = aligned.lines(&variant, &self.receive, &step, context.progress);
                // Depths are by the true speed of sound.
                lines.map(|lines| BeamformedLines {
                    c: recorded.c,
                    ..lines
                })
            };
            let lines: Vec<BeamformedLines> = METHODS.iter().map(by).collect::<Result<_>>()?;
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
                answers.push(frames[detector.method()].answers(*detector)?);
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
