//! A pose of a bone: its recordings, and the images of its scenes.

use ndarray::Array2;

use crate::experiments::Context;
use crate::experiments::common::bone::View;
use crate::experiments::common::variants::{Aligned, Variant};
use crate::{Error, Result};
use bonebeam_drive::config::{Image, PhaseSymmetry};
use bonebeam_drive::image::b_mode;
use bonebeam_files::{ChannelData, Samples};
use bonebeam_simulate::{
    Clutter, Outline, Phantom, Settings, Summation, Tissue, add_noise, channel_data,
};

use super::geometry::Geometries;
use super::medium::{Medium, disturbance};
use super::parameters::Claims;

/// The recordings of a pose, free of noise; those that are wanted.
struct Recordings {
    /// The bone, quiet and with clutter and reverberation.
    bone: [Option<ChannelData>; 2],
    tissue: Option<ChannelData>,
}

/// A pose of a bone, as a seed has it.
pub struct Pose<'a> {
    pub claims: &'a Claims,
    pub context: &'a Context<'a>,
    pub geometry: &'a str,
    pub seed: u64,
    bone: Outline,
    /// What is told to the progress.
    what: &'a str,
}

/// The B-mode images of a scene by every beamformer, and the view of its bone.
pub struct Images {
    pub medium: Medium,
    pub disturbed: bool,
    pub view: View,
    pub images: Vec<(Variant, Array2<f32>)>,
}

impl<'a> Pose<'a> {
    /// The pose of a geometry.
    ///
    /// # Errors
    /// A bone that cannot be placed.
    pub fn new(
        claims: &'a Claims,
        context: &'a Context<'a>,
        geometries: &Geometries,
        geometry: &'a str,
        seed: u64,
        what: &'a str,
    ) -> Result<Self> {
        Ok(Pose {
            claims,
            context,
            geometry,
            seed,
            bone: geometries.posed(claims, geometry, seed)?,
            what,
        })
    }

    /// Hands over the images of every wanted scene, one scene after the other.
    ///
    /// # Errors
    /// A scene that cannot be simulated; what `each` fails with.
    pub fn images(&self, mut each: impl FnMut(Images) -> Result<()>) -> Result<()> {
        let parts = self.recordings()?;
        for (medium, disturbed) in self.wanted() {
            let data = self.mixed(&parts, medium, disturbed)?;
            each(self.beamformed(&data, medium, disturbed)?)?;
        }
        Ok(())
    }

    /// Media and disturbances that are wanted.
    fn wanted(&self) -> Vec<(Medium, bool)> {
        let all = [Medium::Water, Medium::Tissue].into_iter();
        all.flat_map(|medium| [(medium, false), (medium, true)])
            .filter(|(medium, disturbed)| self.claims.wants(self.geometry, *medium, *disturbed))
            .collect()
    }

    fn recordings(&self) -> Result<Recordings> {
        let claims = self.claims;
        let quiet = Settings {
            noise: None,
            ..claims.simulation.clone()
        };
        let simulate = |part: &str, phantom: &Phantom| {
            let step = format!("{}: {part}", self.what);
            channel_data(&quiet, phantom, Summation::Cells, &|done| {
                (self.context.progress)(&step, done);
            })
        };
        let wanted = self.wanted();
        let water = Phantom::bone(&self.bone)?;
        water.check_within(&quiet)?;
        let tissue = wanted.iter().any(|(medium, _)| *medium == Medium::Tissue);
        let tissue = tissue.then(|| {
            let block = Tissue {
                seed: self.seed,
                ..Tissue::default()
            };
            let mut phantom = water.clone().with_tissue(&block);
            phantom.scatterers.drain(..phantom.on_bone);
            phantom.on_bone = 0;
            simulate("tissue", &phantom)
        });
        let disturbed = wanted.iter().any(|(_, disturbed)| *disturbed);
        let disturbed = disturbed.then(|| {
            let clutter = Clutter {
                diffuse: Some(claims.clutter),
                reverberation: Some(claims.reverberation),
                thickness: 0.0,
                depth_end: quiet.depth_end,
                seed: self.seed,
            };
            let mut phantom = water.clone();
            clutter.add(&mut phantom)?;
            simulate("clutter", &phantom)
        });
        let quiet = wanted.iter().any(|(_, disturbed)| !disturbed);
        let quiet = quiet.then(|| simulate("bone", &water));
        Ok(Recordings {
            bone: [quiet.transpose()?, disturbed.transpose()?],
            tissue: tissue.transpose()?,
        })
    }

    /// The recording of a scene.
    fn mixed(&self, parts: &Recordings, medium: Medium, disturbed: bool) -> Result<ChannelData> {
        let claims = self.claims;
        let bone = parts.bone[usize::from(disturbed)].as_ref();
        let none = || Error::Data("the bone was not simulated".into());
        let mut data = bone.ok_or_else(none)?.clone();
        if let Some(part) = parts.tissue.as_ref().filter(|_| medium == Medium::Tissue)
            && let (Samples::Rf(sum), Samples::Rf(part)) = (&mut data.samples, &part.samples)
        {
            *sum += part;
        }
        let settings = Settings {
            noise: match disturbed {
                true => Some(claims.noise),
                false => claims.simulation.noise,
            },
            seed: self.seed,
            ..claims.simulation.clone()
        };
        add_noise(&settings, &mut data)?;
        Ok(data)
    }

    fn beamformed(&self, data: &ChannelData, medium: Medium, disturbed: bool) -> Result<Images> {
        let claims = self.claims;
        let (image, _) = claims.display(medium);
        let aligned = Aligned::new(data, &claims.receive)?;
        let mut view = None;
        let mut images = Vec::new();
        for variant in claims.variants() {
            let progress = self.context.progress;
            let lines = aligned.lines(&variant, &claims.receive, self.what, progress)?;
            let grid = View::once(&mut view, Some(&self.bone), &lines, image)?.grid;
            let made = b_mode(&lines, image.dynamic_range as f32, &grid, image.median)?;
            images.push((variant, made.pixels));
        }
        let view = view.ok_or_else(|| Error::Data("no beamformer was asked for".into()))?;
        Ok(Images {
            medium,
            disturbed,
            view,
            images,
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

/// The images of one scene with one time window, for a figure; `what` is told to the progress.
///
/// # Errors
/// A scene that cannot be simulated.
pub fn one(
    claims: &Claims,
    context: &Context<'_>,
    geometries: &Geometries,
    (geometry, medium, disturbed): (&str, Medium, bool),
    half_window: usize,
    what: &str,
) -> Result<Images> {
    let narrowed = Claims {
        only: [geometry, medium.name(), disturbance(disturbed)]
            .map(String::from)
            .to_vec(),
        half_windows: vec![half_window],
        ..claims.clone()
    };
    let seed = claims.simulation.seed;
    let mut made = None;
    Pose::new(&narrowed, context, geometries, geometry, seed, what)?.images(|images| {
        made = Some(images);
        Ok(())
    })?;
    made.ok_or_else(|| Error::Data("no scene was asked for".into()))
}
