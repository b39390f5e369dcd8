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
use bonebeam_simulate::{Clutter, Phantom, Settings, Summation, Tissue, add_noise, channel_data};

/// Correlation of the aberration along the array: its full width at half maximum, m.
const ABERRATION_LENGTH: f64 = 3e-3;
/// Where tissue lies, lateral and in depth, m. The record's depths lie within.
pub const TISSUE: [[f64; 2]; 2] = [[-15e-3, 15e-3], [3e-3, 44e-3]];

use super::condition::{Condition, Medium};
use super::parameters::Claims;
use super::population::Bone;

/// The recordings of a pose, free of noise; those that are wanted.
struct Recordings {
    /// The bone, quiet and with clutter and reverberation.
    bone: [Option<ChannelData>; 2],
    tissue: Option<ChannelData>,
}

/// A bone in its conditions.
pub struct Pose<'a> {
    pub claims: &'a Claims,
    pub context: &'a Context<'a>,
    pub bone: Bone,
    /// What is told to the progress.
    what: &'a str,
}

/// The B-mode images of a scene by every beamformer, and the view of its bone.
pub struct Images {
    pub condition: Condition,
    pub view: View,
    pub images: Vec<(Variant, Array2<f32>)>,
    /// The lines of the first beamformer, DAS.
    pub das: BeamformedLines,
}

impl<'a> Pose<'a> {
    /// The bone of a number.
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

    /// Hands over the images of the wanted scenes, one scene after the other.
    ///
    /// # Errors
    /// A scene that cannot be simulated; what `each` fails with.
    pub fn images(
        &self,
        conditions: &[Condition],
        mut each: impl FnMut(Images) -> Result<()>,
    ) -> Result<()> {
        let parts = self.recordings(conditions)?;
        for condition in conditions {
            let data = self.mixed(&parts, *condition)?;
            each(self.beamformed(&data, *condition)?)?;
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
        let simulate = |part: &str, phantom: &Phantom| {
            let step = format!("{}: {part}", self.what);
            channel_data(&quiet, phantom, Summation::Cells, &|done| {
                (self.context.progress)(&step, done);
            })
        };
        let water = Phantom::rough_bone(&self.bone.outline, &claims.bone, seed)?;
        water.check_within(&quiet)?;
        let tissue = wanted.iter().any(|c| c.medium() == Medium::Tissue);
        let tissue = tissue.then(|| {
            let block = Tissue {
                seed,
                x: TISSUE[0],
                z: TISSUE[1],
                ..Tissue::default()
            };
            let mut phantom = water.clone().with_tissue(&block);
            phantom.scatterers.drain(..phantom.on_bone);
            (phantom.on_bone, phantom.seen_at) = (0, Vec::new());
            simulate("tissue", &phantom)
        });
        let disturbed = wanted.iter().any(|c| c.is_disturbed());
        let disturbed = disturbed.then(|| {
            let clutter = Clutter {
                diffuse: Some(claims.clutter),
                reverberation: Some(claims.reverberation),
                thickness: 0.0,
                depth_end: quiet.depth_end,
                seed,
            };
            let mut phantom = water.clone();
            clutter.add(&mut phantom)?;
            simulate("clutter", &phantom)
        });
        let undisturbed = wanted.iter().any(|c| !c.is_disturbed());
        let undisturbed = undisturbed.then(|| simulate("bone", &water));
        Ok(Recordings {
            bone: [undisturbed.transpose()?, disturbed.transpose()?],
            tissue: tissue.transpose()?,
        })
    }

    /// Array, pulse and transmit, focused at the bone's shallowest point.
    fn settings(&self) -> Settings {
        Settings {
            focus: self.bone.depth,
            ..self.claims.simulation.clone()
        }
    }

    /// The recording of a scene.
    fn mixed(&self, parts: &Recordings, condition: Condition) -> Result<ChannelData> {
        let claims = self.claims;
        let bone = parts.bone[usize::from(condition.is_disturbed())].as_ref();
        let none = || Error::Data("the bone was not simulated".into());
        let mut data = bone.ok_or_else(none)?.clone();
        if let Some(part) = parts
            .tissue
            .as_ref()
            .filter(|_| condition.medium() == Medium::Tissue)
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

    fn beamformed(&self, data: &ChannelData, condition: Condition) -> Result<Images> {
        let claims = self.claims;
        let (image, _) = claims.display(condition.medium());
        let mut heard = data.clone();
        heard.c *= condition.speed();
        let aligned = Aligned::new(&heard, &claims.receive)?;
        let (mut view, mut das) = (None, None);
        let mut images = Vec::new();
        for variant in claims.variants() {
            let progress = self.context.progress;
            let mut lines = aligned.lines(&variant, &claims.receive, self.what, progress)?;
            // Depths are told by the true speed, so that a wrong one defocuses and no more.
            lines.c = data.c;
            let bone = Some(&self.bone.outline);
            let grid = View::once(&mut view, bone, &lines, image)?.grid;
            let made = b_mode(&lines, image.dynamic_range as f32, &grid, image.median)?;
            images.push((variant, made.pixels));
            das.get_or_insert(lines);
        }
        let none = || Error::Data("no beamformer was asked for".into());
        Ok(Images {
            condition,
            view: view.ok_or_else(none)?,
            images,
            das: das.ok_or_else(none)?,
        })
    }
}

impl Claims {
    /// Image and paper's ridge filter in a medium.
    pub(super) fn display(&self, medium: Medium) -> (&Image, &PhaseSymmetry) {
        match medium {
            Medium::Water => (&self.water, &self.water_phase_symmetry),
            Medium::Tissue => (&self.tissue, &self.tissue_phase_symmetry),
        }
    }
}

/// The images of one scene of a bone with one time window, for a figure; `what` is told to the progress.
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
    made.ok_or_else(|| Error::Data("no scene was asked for".into()))
}
