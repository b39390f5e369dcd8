//! One scene: its phantom, its images, its measures.

use std::fs;
use std::hash::Hasher;
use std::path::Path;

use fnv::FnvHasher;
use ndarray::Array2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::config::{Image, PhaseSymmetry};
use crate::drive::image::b_mode;
use crate::experiments::Context;
use crate::experiments::common::bone::{BoneMeasure, View};
use crate::experiments::common::pictures::ridges;
use crate::experiments::common::truth::precision;
use crate::experiments::common::variants::{Aligned, Variant};
use crate::experiments::outcome::Attachment;
use crate::files::atomic::Outputs;
use crate::files::{ChannelData, Samples, stage_surface};
use crate::measure::signed_distance::Region;
use crate::simulate::{
    Bone, Outline, Phantom, Settings, Summation, Tissue, add_noise, channel_data, slice_mesh,
    slice_vertebra,
};
use crate::{Error, Result};

use super::Claims;
use super::mechanism::{Zones, zones};

/// The geometries by name.
pub const GEOMETRIES: [&str; 2] = ["built-in", "mesh"];
/// How far a seed moves the bone sideways and in depth at the most, m.
const SHIFT: f64 = 1e-3;
/// Density of the clutter in the image plane, per m².
const CLUTTER_DENSITY: f64 = 30e6;

/// What surrounds the bone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Medium {
    /// Nothing that echoes.
    Water,
    /// Scatterers as bright as those of bone.
    Tissue,
}

impl Medium {
    /// As `--only` has it.
    pub fn name(self) -> &'static str {
        match self {
            Medium::Water => "water",
            Medium::Tissue => "tissue",
        }
    }
}

/// As `--only` has it.
pub fn disturbance(disturbed: bool) -> &'static str {
    if disturbed { "disturbed" } else { "quiet" }
}

/// What came out of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneResult {
    /// Which bone.
    pub geometry: String,
    /// What surrounds it.
    pub medium: Medium,
    /// With noise, clutter and reverberation.
    pub disturbed: bool,
    /// Seed of pose, tissue, clutter and noise.
    pub seed: u64,
    /// DAS first.
    pub beamformers: Vec<SceneMeasure>,
    /// What an image of one grey level scores, B-mode and phase symmetry.
    pub uniform: [BoneMeasure; 2],
    /// DAS's image with parts of rank-1 ESMV's; in tissue alone.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub zones: Option<Zones>,
}

/// The measures of a beamformer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneMeasure {
    /// Its key.
    pub beamformer: String,
    /// The B-mode image.
    pub b_mode: BoneMeasure,
    /// Phase symmetry with the paper's parameters.
    pub phase_symmetry: BoneMeasure,
    /// Phase symmetry with those that are best for this beamformer on other seeds.
    pub tuned: BoneMeasure,
}

/// Parameters of phase symmetry for a beamformer in a medium.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tuned {
    /// What surrounds the bone.
    pub medium: Medium,
    /// The beamformer's key.
    pub beamformer: String,
    /// Scales, cycles per pixel.
    pub scales: Vec<f64>,
    /// Threshold.
    pub threshold: f64,
    /// Mean average precision on the seeds that they were tuned on.
    pub average_precision: f64,
    #[serde(skip)]
    scenes: usize,
}

impl SceneResult {
    /// Whether it is of the same scene.
    pub fn is_same(&self, other: &Self) -> bool {
        self.order() == other.order()
    }

    /// The order in which scenes stand.
    pub fn order(&self) -> (Medium, bool, String, u64) {
        (
            self.medium,
            self.disturbed,
            self.geometry.clone(),
            self.seed,
        )
    }
}

/// The scenes of another run's data.
///
/// # Errors
/// Data of another program or version.
pub fn read(data: &serde_json::Value) -> Result<Vec<SceneResult>> {
    let scenes = data.get("scenes").cloned().unwrap_or_default();
    serde_json::from_value(scenes).map_err(|e| {
        Error::Data(format!(
            "--merge: `claims.scenes` is not a list of scenes of this version: {e}"
        ))
    })
}

/// The bones, at x = 0 and any depth.
pub struct Geometries {
    outlines: [Outline; 2],
    mesh: Option<Vec<u8>>,
}

impl Geometries {
    /// The built-in vertebra's slice, and that of the mesh. Without one a mesh is made: the built-in vertebra
    /// at another height, wider and turned in the image plane.
    pub fn new(claims: &Claims) -> Result<Self> {
        let built_in = slice_vertebra(claims.slice)?;
        let (mesh, bytes) = match &claims.mesh {
            Some(path) => (slice_mesh(path, claims.mesh_slice)?, None),
            None => {
                let folder = tempfile::tempdir()
                    .map_err(|e| Error::Data(format!("no folder for a mesh: {e}")))?;
                let path = folder.path().join("mesh.ply");
                write_mesh(&path)?;
                let bytes = fs::read(&path).map_err(|e| Error::File {
                    path: path.clone(),
                    message: e.kind().to_string(),
                })?;
                (slice_mesh(&path, claims.mesh_slice)?, Some(bytes))
            }
        };
        Ok(Geometries {
            outlines: [built_in, mesh],
            mesh: bytes,
        })
    }

    /// The mesh, where it was made here.
    pub fn attachment(self) -> Option<Attachment> {
        self.mesh.map(|bytes| Attachment {
            file: "claims-mesh.ply".into(),
            description: "the second geometry, mm".into(),
            bytes,
        })
    }

    /// A bone in the pose of a seed.
    fn posed(&self, claims: &Claims, geometry: &str, seed: u64) -> Result<Outline> {
        let index = usize::from(geometry != GEOMETRIES[0]);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(1 + index as u64);
        let mut shift = || SHIFT * (2.0 * random.random::<f64>() - 1.0);
        let (across, down) = (shift(), shift());
        let placed = self.outlines[index].at_depth(claims.depth + down)?;
        let loops = placed.loops().iter();
        let moved = loops.map(|points| points.iter().map(|p| [p[0] + across, p[1]]).collect());
        Outline::new(moved.collect())
    }
}

/// The built-in vertebra's surface 4 mm lower, 8 % wider and turned by 7° in the image plane, as a mesh.
fn write_mesh(path: &Path) -> Result<()> {
    let bone = Bone::Vertebra {
        mesh: None,
        slice: -8e-3,
    };
    let (surface, _) = bone.surface(15e-3, 4e-3)?;
    let (sin, cos) = libm::sincos(7f64.to_radians());
    // A mesh has +x towards the front, +y across, +z towards the head.
    let vertices: Vec<[f64; 3]> = surface
        .vertices()
        .iter()
        .map(|[x, y, z]| {
            let (x, z) = (1.08 * x, z - 25e-3);
            [sin * x + cos * z, cos * x - sin * z, *y]
        })
        .collect();
    let mut outputs = Outputs::new();
    stage_surface(path, &vertices, surface.triangles(), &mut outputs)?;
    outputs.commit()
}

/// The recordings of a pose, free of noise; those that are wanted.
struct Recordings {
    /// The bone, quiet and with clutter and reverberation.
    bone: [Option<ChannelData>; 2],
    tissue: Option<ChannelData>,
}

/// A pose of a bone.
struct Pose<'a> {
    claims: &'a Claims,
    geometry: &'a str,
    seed: u64,
    bone: Outline,
}

impl<'a> Pose<'a> {
    fn new(
        claims: &'a Claims,
        geometries: &Geometries,
        geometry: &'a str,
        seed: u64,
    ) -> Result<Self> {
        Ok(Pose {
            claims,
            geometry,
            seed,
            bone: geometries.posed(claims, geometry, seed)?,
        })
    }

    /// Media and disturbances that are wanted.
    fn wanted(&self) -> Vec<(Medium, bool)> {
        let all = [Medium::Water, Medium::Tissue].into_iter();
        all.flat_map(|medium| [(medium, false), (medium, true)])
            .filter(|(medium, disturbed)| self.claims.wants(self.geometry, *medium, *disturbed))
            .collect()
    }

    fn recordings(&self, context: &Context<'_>, what: &str) -> Result<Recordings> {
        let claims = self.claims;
        let quiet = Settings {
            noise: None,
            ..claims.simulation.clone()
        };
        let simulate = |part: &str, phantom: &Phantom| {
            let step = format!("{what}: {part}");
            channel_data(&quiet, phantom, Summation::Cells, &|done| {
                (context.progress)(&step, done);
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
            let amplitude = |level: f64| libm::pow(10.0, level / 20.0);
            let block = Tissue {
                density: CLUTTER_DENSITY,
                amplitude: amplitude(claims.clutter),
                x: [-20e-3, 20e-3],
                // What echoes several times comes later than the bone's first echo.
                z: [claims.depth, quiet.depth_end],
                seed: self.seed.wrapping_add(1 << 32),
            };
            let phantom = Phantom {
                clutter: Phantom::default().with_tissue(&block).scatterers,
                reverberation: amplitude(claims.reverberation),
                ..water.clone()
            };
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

/// The B-mode images of every beamformer, and the view of the bone.
pub(super) struct Images {
    pub view: View,
    pub images: Vec<(Variant, Array2<f32>)>,
}

fn images(
    pose: &Pose<'_>,
    context: &Context<'_>,
    data: &ChannelData,
    medium: Medium,
    what: &str,
) -> Result<Images> {
    let claims = pose.claims;
    let (image, _) = claims.display(medium);
    let aligned = Aligned::new(data, &claims.receive)?;
    let mut view = None;
    let mut images = Vec::new();
    for variant in claims.variants() {
        let lines = aligned.lines(&variant, &claims.receive, what, context.progress)?;
        let grid = View::once(&mut view, Some(&pose.bone), &lines, image)?.grid;
        let made = b_mode(&lines, image.dynamic_range as f32, &grid, image.median)?;
        images.push((variant, made.pixels));
    }
    let view = view.ok_or_else(|| Error::Data("no beamformer was asked for".into()))?;
    Ok(Images { view, images })
}

/// The images of one scene with one time window, for a figure; `what` is told to the progress.
pub(super) fn one(
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
    let pose = Pose::new(&narrowed, geometries, geometry, claims.simulation.seed)?;
    let parts = pose.recordings(context, what)?;
    let data = pose.mixed(&parts, medium, disturbed)?;
    images(&pose, context, &data, medium, what)
}

/// The measures of the scenes of a pose; from the folder of kept results where they are there.
pub fn scenes(
    claims: &Claims,
    context: &Context<'_>,
    geometries: &Geometries,
    geometry: &str,
    seed: u64,
    what: &str,
    tuned: &[Tuned],
) -> Result<Vec<SceneResult>> {
    let key = format!("{claims:?} {tuned:?} {geometry} {seed}");
    kept(context, "claims", &key, || {
        measured(claims, context, geometries, geometry, seed, what, tuned)
    })
}

/// A result from the folder of kept ones, or computed and put there. `what` begins its file's name, `key` has
/// all that it depends on.
fn kept<T: Serialize + DeserializeOwned>(
    context: &Context<'_>,
    what: &str,
    key: &str,
    compute: impl FnOnce() -> Result<T>,
) -> Result<T> {
    let Some(folder) = context.kept else {
        return compute();
    };
    let mut hasher = FnvHasher::default();
    hasher.write(key.as_bytes());
    hasher.write(env!("CARGO_PKG_VERSION").as_bytes());
    let path = folder.join(format!("{what}-{:016x}.json", hasher.finish()));
    if let Ok(text) = fs::read(&path)
        && let Ok(found) = serde_json::from_slice(&text)
    {
        return Ok(found);
    }
    let found = compute()?;
    let mut outputs = Outputs::new();
    outputs.stage(&path, |sink| Ok(serde_json::to_writer(sink, &found)?))?;
    outputs.commit()?;
    Ok(found)
}

fn measured(
    claims: &Claims,
    context: &Context<'_>,
    geometries: &Geometries,
    geometry: &str,
    seed: u64,
    what: &str,
    tuned: &[Tuned],
) -> Result<Vec<SceneResult>> {
    let pose = Pose::new(claims, geometries, geometry, seed)?;
    let parts = pose.recordings(context, what)?;
    let mut found = Vec::new();
    for (medium, disturbed) in pose.wanted() {
        let data = pose.mixed(&parts, medium, disturbed)?;
        let Images { view, images } = images(&pose, context, &data, medium, what)?;
        let (_, paper) = claims.display(medium);
        let mut beamformers = Vec::new();
        for (variant, image) in &images {
            let best = tuned
                .iter()
                .find(|t| t.medium == medium && t.beamformer == variant.key)
                .map_or(paper.clone(), |t| PhaseSymmetry {
                    scales: t.scales.clone(),
                    threshold: t.threshold,
                    ..paper.clone()
                });
            let measured =
                |section| Ok(view.measure(&ridges(image, section)?, Region::PHASE_SYMMETRY));
            let measured: Result<_> = measured(paper).and_then(|m| Ok([m, measured(&best)?]));
            let [phase_symmetry, tuned]: [BoneMeasure; 2] = measured?;
            beamformers.push(SceneMeasure {
                beamformer: variant.key.clone(),
                b_mode: view.measure(image, Region::B_MODE),
                phase_symmetry,
                tuned,
            });
        }
        found.push(SceneResult {
            geometry: geometry.to_owned(),
            medium,
            disturbed,
            seed,
            beamformers,
            uniform: [Region::B_MODE, Region::PHASE_SYMMETRY].map(|region| view.uniform(region)),
            zones: match medium {
                Medium::Water => None,
                Medium::Tissue => zones(&view, &images, paper, claims.tissue.dynamic_range)?,
            },
        });
    }
    Ok(found)
}

/// The filters that are tried: scales as exponents of 2, from and to, and thresholds.
const SCALES: [[i32; 2]; 5] = [[5, 9], [5, 7], [6, 8], [7, 9], [5, 6]];
const THRESHOLDS: [f64; 4] = [5.0, 10.0, 15.0, 30.0];

/// The score of a filter on a scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Score {
    medium: Medium,
    beamformer: String,
    scales: Vec<f64>,
    threshold: f64,
    average_precision: f64,
}

/// The scores of every filter on the scenes of a pose; from the folder of kept results where they are there.
pub fn scores(
    claims: &Claims,
    context: &Context<'_>,
    geometries: &Geometries,
    geometry: &str,
    seed: u64,
    what: &str,
) -> Result<Vec<Score>> {
    let key = format!("{claims:?} {geometry} {seed}");
    kept(context, "claims-tune", &key, || {
        let pose = Pose::new(claims, geometries, geometry, seed)?;
        let parts = pose.recordings(context, what)?;
        let mut scores = Vec::new();
        for (medium, disturbed) in pose.wanted() {
            let data = pose.mixed(&parts, medium, disturbed)?;
            let Images { view, images } = images(&pose, context, &data, medium, what)?;
            let (_, paper) = claims.display(medium);
            for (variant, image) in &images {
                for [from, to] in SCALES {
                    for threshold in THRESHOLDS {
                        let scales: Vec<f64> = (from..=to).map(|k| f64::from(-k).exp2()).collect();
                        let section = PhaseSymmetry {
                            scales: scales.clone(),
                            threshold,
                            ..paper.clone()
                        };
                        let map = ridges(image, &section)?;
                        let score = precision(&map, &view.hits, &view.grid);
                        scores.push(Score {
                            medium,
                            beamformer: variant.key.clone(),
                            scales,
                            threshold,
                            average_precision: score.unwrap_or(0.0),
                        });
                    }
                }
            }
        }
        Ok(scores)
    })
}

/// The mean score of every filter.
pub fn means(scores: Vec<Score>) -> Vec<Tuned> {
    let mut means: Vec<Tuned> = Vec::new();
    for score in scores {
        let same = |t: &&mut Tuned| {
            t.medium == score.medium
                && t.beamformer == score.beamformer
                && t.scales == score.scales
                && t.threshold == score.threshold
        };
        match means.iter_mut().find(same) {
            Some(found) => {
                found.scenes += 1;
                let weight = 1.0 / found.scenes as f64;
                found.average_precision +=
                    weight * (score.average_precision - found.average_precision);
            }
            None => means.push(Tuned {
                medium: score.medium,
                beamformer: score.beamformer,
                scales: score.scales,
                threshold: score.threshold,
                average_precision: score.average_precision,
                scenes: 1,
            }),
        }
    }
    means
}

/// The best filter of every beamformer and medium.
pub fn best(means: Vec<Tuned>) -> Vec<Tuned> {
    let mut best: Vec<Tuned> = Vec::new();
    for score in means {
        let same = |t: &&mut Tuned| t.medium == score.medium && t.beamformer == score.beamformer;
        match best.iter_mut().find(same) {
            Some(found) if found.average_precision < score.average_precision => *found = score,
            Some(_) => {}
            None => best.push(score),
        }
    }
    best
}
