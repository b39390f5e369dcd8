//! The recordings of a bone, and the images of its scenes.

use ndarray::Array2;

use crate::experiments::Context;
use crate::experiments::common::aberration::aberrate;
use crate::experiments::common::bone::View;
use crate::experiments::common::variants::{Aligned, Variant};
use crate::{Error, Result};
use bonebeam_drive::config::{Image, PhaseSymmetry};
use bonebeam_drive::image::b_mode;
use bonebeam_files::{BeamformedLines, ChannelData, Samples};
use bonebeam_simulate::{
    self as simulate, Clutter, Layers, Outline, Phantom, Settings, Summation, Tissue, add_noise,
    channel_data,
};

/// Correlation of the aberration along the array: full width at half maximum, m.
const ABERRATION_LENGTH: f64 = 3e-3;
/// Range of the tissue, lateral and in depth, m.
///
/// The record's depths lie within.
pub const TISSUE: [[f64; 2]; 2] = [[-15e-3, 15e-3], [3e-3, 44e-3]];

use super::condition::{Condition, Medium};
use super::parameters::Claims;
use super::population::Bone;

/// Thickness of the slab of bone that echoes in three dimensions, m.
///
/// The image plane is in its middle.
const SLAB: f64 = 6e-3;

/// The selected recordings of a pose, free of noise.
struct Recordings {
    /// The bone: quiet, and with clutter and reverberation.
    bone: [Option<ChannelData>; 2],
    /// The bone in three dimensions, and its outline in the image plane.
    volume: Option<(ChannelData, Outline)>,
    tissue: Option<ChannelData>,
    /// Tissue with layers.
    layers: Option<ChannelData>,
    /// The bone with clutter and reverberation, and tissue, attenuated.
    attenuated: Option<[ChannelData; 2]>,
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
    ///
    /// # Errors
    /// A dynamic range that is not positive.
    pub fn over(&self, dynamic_range: f64, view: &View, median: bool) -> Result<Array2<f32>> {
        let made = b_mode(&self.lines, dynamic_range as f32, &view.grid, median)?;
        Ok(made.pixels)
    }
}

impl<'a> Pose<'a> {
    /// Makes the bone of a number.
    ///
    /// # Errors
    /// A bone that cannot be made.
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
    ///
    /// # Errors
    /// A scene that cannot be simulated, or an error of `each`.
    pub fn images(
        &self,
        conditions: &[Condition],
        mut each: impl FnMut(Images) -> Result<()>,
    ) -> Result<()> {
        let parts = self.recordings(conditions)?;
        for condition in conditions {
            let data = self.mixed(&parts, *condition)?;
            let outline = match &parts.volume {
                Some((_, outline)) if *condition == Condition::WaterVolume => outline,
                _ => &self.bone.outline,
            };
            each(self.beamformed(&data, *condition, outline.clone())?)?;
        }
        Ok(())
    }

    fn recordings(&self, wanted: &[Condition]) -> Result<Recordings> {
        let claims = self.claims;
        let seed = self.bone.number;
        let quiet = Settings {
            noise: None,
            ..self.settings()
        };
        let simulated = |part: &str, settings: &Settings, phantom: &Phantom| {
            let step = format!("{}: {part}", self.what);
            channel_data(settings, phantom, Summation::Cells, &|done| {
                (self.context.progress)(&step, done);
            })
        };
        let water = Phantom::rough_bone(&self.bone.outline, &claims.bone, seed)?;
        water.check_within(&quiet)?;
        let attenuated = Settings {
            attenuation: claims.attenuation,
            ..quiet.clone()
        };
        let own = [Condition::Layers, Condition::Attenuation];
        let tissue = |layers: Layers| {
            let block = Tissue {
                amplitude: libm::pow(10.0, self.bone.tissue_level / 20.0),
                layers,
                seed,
                x: TISSUE[0],
                z: TISSUE[1],
                ..Tissue::default()
            };
            let mut phantom = water.clone().with_tissue(&block);
            phantom.scatterers.drain(..phantom.on_bone);
            (phantom.on_bone, phantom.seen_at) = (0, Vec::new());
            phantom
        };
        let is_uniform = |c: &Condition| c.medium() == Medium::Tissue && !own.contains(c);
        let uniform = wanted.iter().any(is_uniform);
        let uniform = uniform.then(|| simulated("tissue", &quiet, &tissue(Layers::Uniform)));
        let layers = wanted.contains(&Condition::Layers);
        let layers = layers.then(|| simulated("layers", &quiet, &tissue(Layers::Anatomy)));
        let clutter = |thickness: f64| Clutter {
            diffuse: Some(claims.clutter),
            reverberation: Some(claims.reverberation),
            thickness,
            depth_end: quiet.depth_end,
            seed,
        };
        let is_plane = |c: &Condition| *c != Condition::WaterVolume;
        let mut planes = wanted.iter().filter(|c| is_plane(c));
        let mut cluttered = water.clone();
        clutter(0.0).add(&mut cluttered)?;
        let disturbed = planes.any(|c| c.is_disturbed() && *c != Condition::Attenuation);
        let disturbed = disturbed.then(|| simulated("clutter", &quiet, &cluttered));
        let attenuates = wanted.contains(&Condition::Attenuation);
        let attenuated = attenuates.then(|| {
            let bone = simulated("clutter, attenuated", &attenuated, &cluttered)?;
            let tissue = tissue(Layers::Uniform);
            let tissue = simulated("tissue, attenuated", &attenuated, &tissue)?;
            Ok::<_, Error>([bone, tissue])
        });
        let shape = self
            .bone
            .shape
            .as_ref()
            .filter(|_| !wanted.iter().all(is_plane));
        let volume = shape.map(|shape| {
            let bone = simulate::Bone::Shape {
                shape,
                slice: self.bone.slice,
                tilt: self.bone.tilt,
            };
            let rough = Some((&claims.bone, seed));
            let (mut phantom, _) = bone.phantom(self.bone.depth, SLAB, rough)?;
            clutter(SLAB).add(&mut phantom)?;
            let array = Settings::volume();
            let settings = Settings {
                element_height: array.element_height,
                elevation_focus: array.elevation_focus,
                ..quiet.clone()
            };
            let none = || Error::Data("the image plane misses the bone".into());
            let outline = phantom.bone.clone().ok_or_else(none)?;
            Ok::<_, Error>((simulated("volume", &settings, &phantom)?, outline))
        });
        let undisturbed = wanted.iter().any(|c| !c.is_disturbed());
        let undisturbed = undisturbed.then(|| simulated("bone", &quiet, &water));
        Ok(Recordings {
            bone: [undisturbed.transpose()?, disturbed.transpose()?],
            volume: volume.transpose()?,
            tissue: uniform.transpose()?,
            layers: layers.transpose()?,
            attenuated: attenuated.transpose()?,
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
        let bone = match condition {
            Condition::WaterVolume => parts.volume.as_ref().map(|(data, _)| data),
            Condition::Attenuation => parts.attenuated.as_ref().map(|[bone, _]| bone),
            _ => parts.bone[usize::from(condition.is_disturbed())].as_ref(),
        };
        let none = || Error::Data("the bone was not simulated".into());
        let mut data = bone.ok_or_else(none)?.clone();
        let tissue = match condition {
            Condition::Layers => parts.layers.as_ref(),
            Condition::Attenuation => parts.attenuated.as_ref().map(|[_, tissue]| tissue),
            _ => parts.tissue.as_ref(),
        };
        if let Some(part) = tissue.filter(|_| condition.medium() == Medium::Tissue)
            && let (Samples::Rf(sum), Samples::Rf(part)) = (&mut data.samples, &part.samples)
        {
            *sum += part;
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
        let aligned = Aligned::new(&heard, &claims.receive)?;
        let mut view = None;
        let mut images = Vec::new();
        for variant in claims.variants() {
            let progress = self.context.progress;
            let mut lines = aligned.lines(&variant, &claims.receive, self.what, progress)?;
            // Depths follow from the true speed, so that a wrong one only defocuses.
            lines.c = data.c;
            let grid = View::once(&mut view, Some(&outline), &lines, image)?.grid;
            let made = b_mode(&lines, image.dynamic_range as f32, &grid, image.median)?;
            images.push(Beamformed {
                variant,
                lines,
                pixels: made.pixels,
            });
        }
        let none = || Error::Data("no beamformer was selected".into());
        Ok(Images {
            condition,
            outline,
            view: view.ok_or_else(none)?,
            images,
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
///
/// # Errors
/// A scene that cannot be simulated.
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
