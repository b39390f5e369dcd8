//! The recordings of a bone, and the images of its scenes.

use crate::experiments::study::*;
use std::collections::{BTreeMap, BTreeSet};

use crate::experiments::common::aberration::aberrate;
use bonebeam_simulate::{self as simulate, Layers, Summation, Tissue, add_noise, channel_data};

/// Correlation of the aberration along the array: full width at half maximum, m.
const ABERRATION_LENGTH: f64 = 3e-3;
/// Range of the tissue, lateral and in depth, m.
///
/// The record's depths lie within.
pub const TISSUE: [[f64; 2]; 2] = [[-15e-3, 15e-3], [3e-3, 44e-3]];

use super::condition::{Condition, Medium};
use super::parameters::{Claims, SHOWN};
use super::population::Bone;

/// Thickness of the slab of bone that echoes in three dimensions, m.
///
/// The image plane is in its middle.
const SLAB: f64 = 6e-3;

/// A part of a bone's scenes, which is simulated alone and free of noise; its name is that of the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Bone,
    /// The bone with clutter and reverberation, like those below.
    Cluttered,
    Attenuated,
    /// In three dimensions.
    Volume,
    Tissue,
    Layers,
    AttenuatedTissue,
}

impl Part {
    /// The parts whose sum is a scene.
    fn of(condition: Condition) -> Vec<Part> {
        let bone = match condition {
            Condition::WaterVolume => Part::Volume,
            Condition::Attenuation => Part::Attenuated,
            other if other.is_disturbed() => Part::Cluttered,
            _ => Part::Bone,
        };
        let tissue = match condition {
            Condition::Layers => Part::Layers,
            Condition::Attenuation => Part::AttenuatedTissue,
            _ => Part::Tissue,
        };
        let tissue = (condition.medium() == Medium::Tissue).then_some(tissue);
        std::iter::once(bone).chain(tissue).collect()
    }
}

/// The recordings of parts, and the volume's outline in the image plane.
#[derive(Default)]
struct Recordings {
    parts: BTreeMap<Part, ChannelData>,
    volume: Option<Outline>,
}

/// A bone in its conditions.
pub struct Pose<'a> {
    pub claims: &'a Claims,
    pub context: &'a Context<'a>,
    pub bone: Bone,
    /// Name in progress messages.
    what: &'a str,
}

/// B-mode images of a scene by every beamformer, and the view of its bone.
pub struct Images {
    pub condition: Condition,
    /// The bone in the image plane.
    pub outline: Outline,
    pub view: View,
    /// DAS first.
    pub images: Vec<Beamformed>,
}

/// A beamformer's image of a scene.
pub struct Beamformed {
    pub variant: Variant,
    pub lines: BeamformedLines,
    /// B-mode over the medium's dynamic range.
    pub pixels: Array2<f32>,
}

impl Beamformed {
    /// B-mode over another dynamic range, dB.
    pub fn over(&self, dynamic_range: f64, view: &View, median: bool) -> Result<Array2<f32>> {
        let made = b_mode(&self.lines, dynamic_range as f32, &view.grid, median)?;
        Ok(made.pixels)
    }
}

impl<'a> Pose<'a> {
    /// Makes the bone of a number.
    pub fn new(
        claims: &'a Claims,
        context: &'a Context<'a>,
        number: u64,
        what: &'a str,
    ) -> Result<Self> {
        Ok(Pose {
            claims,
            context,
            bone: Bone::new(claims, number)?,
            what,
        })
    }

    /// The conditions of its scenes.
    pub fn conditions(&self) -> Vec<Condition> {
        let claims = self.claims;
        let first = claims.simulation.seed;
        let is_volume = self.bone.shape.is_some() && self.bone.number < first + claims.volumes;
        let mut conditions = claims.conditions();
        conditions.retain(|c| is_volume || *c != Condition::WaterVolume);
        conditions
    }

    /// Passes the images of the selected scenes to `each`, one scene at a time.
    pub fn images(
        &self,
        conditions: &[Condition],
        mut each: impl FnMut(Images) -> Result<()>,
    ) -> Result<()> {
        let parts = self.recordings(conditions)?;
        for condition in conditions {
            let data = self.mixed(&parts, *condition)?;
            let volume = parts.volume.as_ref();
            let volume = volume.filter(|_| *condition == Condition::WaterVolume);
            let outline = volume.unwrap_or(&self.bone.outline);
            each(self.beamformed(&data, *condition, outline.clone())?)?;
        }
        Ok(())
    }

    fn recordings(&self, wanted: &[Condition]) -> Result<Recordings> {
        let settings = Settings {
            noise: None,
            ..self.settings()
        };
        let seed = self.bone.number;
        let bone = Phantom::rough_bone(&self.bone.outline, &self.claims.bone, seed)?;
        bone.check_within(&settings)?;
        let mut recordings = Recordings::default();
        let parts: BTreeSet<Part> = wanted.iter().flat_map(|c| Part::of(*c)).collect();
        for part in parts {
            let (phantom, settings) = self.part(part, bone.clone(), settings.clone())?;
            let step = format!("{}: {part:?}", self.what).to_lowercase();
            let in_figures = matches!(part, Part::Bone | Part::Cluttered | Part::Tissue)
                && seed.wrapping_sub(self.claims.simulation.seed) < SHOWN;
            let data = match in_figures {
                true => recording(self.context, ["claims", &step], &settings, &phantom)?,
                false => channel_data(&settings, &phantom, Summation::Cells, &|done| {
                    (self.context.progress)(&step, done);
                })?,
            };
            recordings.parts.insert(part, data);
            if part == Part::Volume {
                recordings.volume = phantom.bone;
            }
        }
        Ok(recordings)
    }

    fn part(&self, part: Part, bone: Phantom, quiet: Settings) -> Result<(Phantom, Settings)> {
        let claims = self.claims;
        let seed = self.bone.number;
        let clutter = |mut phantom: Phantom, thickness: f64| -> Result<Phantom> {
            let clutter = Clutter {
                diffuse: Some(claims.clutter),
                reverberation: Some(claims.reverberation),
                thickness,
                depth_end: quiet.depth_end,
                seed,
            };
            clutter.add(&mut phantom)?;
            Ok(phantom)
        };
        let tissue = |layers: Layers| {
            let block = Tissue {
                amplitude: libm::pow(10.0, self.bone.tissue_level / 20.0),
                layers,
                seed,
                x: TISSUE[0],
                z: TISSUE[1],
                ..Tissue::default()
            };
            let mut phantom = bone.clone().with_tissue(&block);
            phantom.scatterers.drain(..phantom.on_bone);
            (phantom.on_bone, phantom.seen_at) = (0, Vec::new());
            phantom
        };
        let attenuated = Settings {
            attenuation: claims.attenuation,
            ..quiet.clone()
        };
        Ok(match part {
            Part::Bone => (bone, quiet),
            Part::Cluttered => (clutter(bone, 0.0)?, quiet),
            Part::Attenuated => (clutter(bone, 0.0)?, attenuated),
            Part::Tissue => (tissue(Layers::Uniform), quiet),
            Part::Layers => (tissue(Layers::Anatomy), quiet),
            Part::AttenuatedTissue => (tissue(Layers::Uniform), attenuated),
            Part::Volume => {
                let none = || Error::Data("a mesh has no volume here".into());
                let bone = simulate::Bone::Shape {
                    shape: self.bone.shape.as_ref().ok_or_else(none)?,
                    slice: self.bone.slice,
                    tilt: self.bone.tilt,
                };
                let rough = Some((&claims.bone, seed));
                let (phantom, _) = bone.phantom(self.bone.depth, SLAB, rough)?;
                let array = Settings::volume();
                let settings = Settings {
                    element_height: array.element_height,
                    elevation_focus: array.elevation_focus,
                    ..quiet.clone()
                };
                (clutter(phantom, SLAB)?, settings)
            }
        })
    }

    /// Array, pulse and transmit, focused at the bone's shallowest point.
    fn settings(&self) -> Settings {
        Settings {
            focus: self.bone.depth,
            ..self.claims.simulation.clone()
        }
    }

    /// The recording of a scene, as a sum of its parts.
    fn mixed(&self, parts: &Recordings, condition: Condition) -> Result<ChannelData> {
        let claims = self.claims;
        let of_scene = Part::of(condition).into_iter();
        let mut of_scene = of_scene.filter_map(|part| parts.parts.get(&part));
        let none = || Error::Data("the bone was not simulated".into());
        let mut data = of_scene.next().ok_or_else(none)?.clone();
        for part in of_scene {
            if let (Samples::Rf(sum), Samples::Rf(part)) = (&mut data.samples, &part.samples) {
                *sum += part;
            }
        }
        if let Some(rms) = condition.aberration() {
            aberrate(&mut data, rms, ABERRATION_LENGTH, self.bone.number)?;
        }
        let settings = Settings {
            noise: match condition.is_disturbed() {
                true => Some(claims.noise),
                false => claims.simulation.noise,
            },
            seed: self.bone.number,
            ..self.settings()
        };
        add_noise(&settings, &mut data)?;
        Ok(data)
    }

    fn beamformed(
        &self,
        data: &ChannelData,
        condition: Condition,
        outline: Outline,
    ) -> Result<Images> {
        let claims = self.claims;
        let (image, _) = claims.display(condition.medium());
        let mut heard = data.clone();
        heard.c *= condition.speed();
        let variants = claims.variants();
        let progress = self.context.progress;
        let mut all = lines_of(self.what, &heard, &claims.receive, &variants, progress)?;
        // Depths follow from the true speed, so that a wrong one only defocuses.
        all.iter_mut().for_each(|lines| lines.c = data.c);
        let view = View::of_lines(Some(&outline), &all[0], image)?;
        let images = variants.into_iter().zip(all).map(|(variant, lines)| {
            let range = image.dynamic_range as f32;
            let pixels = b_mode(&lines, range, &view.grid, image.median)?.pixels;
            Ok(Beamformed {
                variant,
                lines,
                pixels,
            })
        });
        Ok(Images {
            condition,
            images: images.collect::<Result<_>>()?,
            outline,
            view,
        })
    }
}

impl Claims {
    /// Image and the paper's filter in a medium.
    pub(super) fn display(&self, medium: Medium) -> (&Image, &PhaseSymmetry) {
        match medium {
            Medium::Water => (&self.water, &self.water_phase_symmetry),
            Medium::Tissue => (&self.tissue, &self.tissue_phase_symmetry),
        }
    }
}

/// The images of one scene of a bone with one time window, for a figure.
pub fn one(
    claims: &Claims,
    context: &Context<'_>,
    number: u64,
    condition: Condition,
    half_window: usize,
    what: &str,
) -> Result<Images> {
    let narrowed = Claims {
        half_windows: vec![half_window],
        ..claims.clone()
    };
    let mut made = None;
    Pose::new(&narrowed, context, number, what)?.images(&[condition], |images| {
        made = Some(images);
        Ok(())
    })?;
    made.ok_or_else(|| Error::Data("no scene was selected".into()))
}
