//! A recording or a picture, the settings, and the results so far.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use bonebeam::simd::InstructionSet;
use bonebeam_drive::config::{Beamform, Image, PhaseSymmetry, Surface};
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::frame::RecordingFrames;
use bonebeam_drive::image::{BModeImage, image_of};
use bonebeam_drive::policy::warnings;
use bonebeam_drive::surface::{Picture, SurfacePoint, of_picture, of_recording};
use bonebeam_drive::{Error, Result, phase_symmetry};
use bonebeam_files::{BeamformedLines, ChannelData, Recording, Transmits, image, npy, npz};
use bonebeam_measure::contrast::gcnr;
use bonebeam_measure::profile::{largest, width};
use ndarray::Array2;
use num_complex::Complex;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use twox_hash::XxHash3_128;

use crate::describe;

/// JSON, and numbers as bytes.
pub type Answer = (Value, Vec<u8>);

/// Name of the recording or picture in messages.
const NAME: &str = "the file";
/// Depth step of a coarse picture.
const COARSE: usize = 4;
/// Longer side of a coarse picture, pixels.
const COARSE_SIDE: usize = 256;

/// The sections of the configuration that the page has.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    beamform: Beamform,
    image: Image,
    phase_symmetry: PhaseSymmetry,
    surface: Surface,
}

impl Settings {
    /// Sets a key, such as `beamform.method`, to a flag's text.
    fn set(&mut self, key: &str, text: &str) -> Result<()> {
        match key.split_once('.') {
            Some(("beamform", name)) => describe::set(&mut self.beamform, name, text),
            Some(("image", name)) => describe::set(&mut self.image, name, text),
            Some(("phase_symmetry", name)) => describe::set(&mut self.phase_symmetry, name, text),
            Some(("surface", name)) => describe::set(&mut self.surface, name, text),
            _ => Err(Error::Usage(format!("there is no key `{key}`"))),
        }
    }
}

fn of_json<T: DeserializeOwned>(json: &[u8]) -> Result<T> {
    serde_json::from_slice(json).map_err(|e| Error::Usage(e.to_string()))
}

/// All of it lives as long as the module: a new file has a new module.
#[derive(Default)]
pub struct State {
    recording: Option<&'static Recording>,
    /// Every second beam of the recording, for coarse pictures.
    half: Option<&'static ChannelData>,
    coarse: bool,
    picture: Option<Array2<f32>>,
    settings: Settings,
    /// The beamformer's section that the parts have.
    beamform: Option<&'static Beamform>,
    stage: Option<DelayStage<'static>>,
    parts: Vec<([usize; 2], RecordingFrames<'static>)>,
    lines: Option<BeamformedLines>,
    image: Option<BModeImage>,
}

impl State {
    pub fn describe(&mut self, _: Vec<u8>) -> Result<Answer> {
        let keys = describe::keys();
        text(json!({ "keys": keys, "defaults": Settings::default() }))
    }

    pub fn open(&mut self, npz: Vec<u8>) -> Result<Answer> {
        let file = &mut npz::Reader::of(Box::new(Cursor::new(npz)), Path::new(NAME))?;
        let (recording, frames) = Recording::of_npz(file, 0..usize::MAX)?;
        let recording: &'static Recording = Box::leak(Box::new(recording));
        self.recording = Some(recording);
        text(match recording {
            Recording::Channel(data) => of_channel_data(data, frames),
            Recording::Aligned(_) => json!({ "kind": "aligned", "frames": frames }),
            Recording::Lines(_) => json!({ "kind": "lines", "frames": frames }),
        })
    }

    pub fn picture(&mut self, png: Vec<u8>) -> Result<Answer> {
        let pixels = image::levels_of_png(&png, Path::new(NAME))?;
        let (rows, columns) = pixels.dim();
        self.picture = Some(pixels);
        text(json!({ "kind": "picture", "frames": 1, "rows": rows, "columns": columns }))
    }

    pub fn read_toml(&mut self, toml: Vec<u8>) -> Result<Answer> {
        let toml = String::from_utf8_lossy(&toml);
        let settings: Settings =
            toml::from_str(&toml).map_err(|e| Error::Usage(e.message().to_owned()))?;
        text(json!(settings))
    }

    pub fn settle(&mut self, json: Vec<u8>, coarse: usize) -> Result<Answer> {
        let mut settings = Settings::default();
        let given: BTreeMap<String, String> = of_json(&json)?;
        for (key, text) in &given {
            settings.set(key, text)?;
        }
        settings.beamform.resolve();
        let any_size = settings.image.rows.is_none() && settings.image.columns.is_none();
        if any_size && settings.phase_symmetry.resize.is_none() {
            // As the command does for its bone map.
            settings.phase_symmetry.pad = true;
        }
        settings.beamform.validate()?;
        settings.image.validate()?;
        settings.phase_symmetry.validate()?;
        settings.surface.validate()?;
        let toml = toml::to_string(&settings).map_err(|e| Error::Usage(e.to_string()))?;
        if coarse > 0 {
            self.coarsen(&mut settings)?;
        }
        let warnings = match self.recording {
            Some(Recording::Channel(data)) => {
                warnings(data, &data.samples.survey(), &settings.beamform)?
            }
            _ => Vec::new(),
        };
        if self.beamform != Some(&settings.beamform) || self.coarse != (coarse > 0) {
            (self.stage, self.parts) = (None, Vec::new());
            self.beamform = Some(Box::leak(Box::new(settings.beamform.clone())));
        }
        (self.settings, self.coarse) = (settings, coarse > 0);
        text(json!({ "toml": toml, "warnings": warnings }))
    }

    /// Larger steps in depth, half the lines and fewer pixels.
    fn coarsen(&self, settings: &mut Settings) -> Result<()> {
        let beamform = &mut settings.beamform;
        beamform.depth_step = Some(beamform.depth_step().max(COARSE));
        beamform.sub_lines = Some(1);
        let image = &mut settings.image;
        let whole = image.rows.is_none() && image.columns.is_none() && image.pixel_size.is_none();
        if let (Some(Recording::Channel(data)), true) = (self.recording, whole) {
            let stage = DelayStage::new(data, beamform)?;
            let depths = stage.depths();
            let x = stage.beam_x();
            let width = image.width.unwrap_or(x[x.len() - 1] - x[0]);
            match width > image.depth.unwrap_or(depths.last()) - depths.first {
                true => image.columns = Some(COARSE_SIDE),
                false => image.rows = Some(COARSE_SIDE),
            }
            let own = matches!(data.transmits, Transmits::Focused { .. });
            let lines = beamform.line_spacing.is_some() || beamform.lateral_start.is_some();
            if !own && !lines && beamform.lateral_end.is_none() {
                let count = beamform.line_count.unwrap_or(stage.rays().len());
                beamform.line_count = Some(count.div_ceil(2).max(2));
            }
        }
        Ok(())
    }

    /// The channel data of the lines, and the beamformer's section.
    fn data(&mut self) -> Result<(&'static ChannelData, &'static Beamform)> {
        let (Some(Recording::Channel(data)), Some(beamform)) = (self.recording, self.beamform)
        else {
            return Err(no_recording());
        };
        let beams = data.transmits.len();
        let own = matches!(data.transmits, Transmits::Focused { .. });
        if !self.coarse || !own || beams < 4 {
            return Ok((data, beamform));
        }
        let half = self.half.get_or_insert_with(|| {
            let every: Vec<usize> = (0..beams).step_by(2).collect();
            Box::leak(Box::new(data.only(&every)))
        });
        Ok((*half, beamform))
    }

    pub fn shape(&mut self, _: Vec<u8>) -> Result<Answer> {
        let (data, beamform) = self.data()?;
        if self.stage.is_none() {
            self.stage = Some(DelayStage::new(data, beamform)?);
        }
        let stage = self.stage.as_ref().ok_or_else(no_recording)?;
        text(json!({
            "lines": stage.all_rays().len(),
            "beams": stage.rays().len(),
            "samples": stage.samples(),
            "sub_lines": stage.sub_lines(),
            "loss_db": stage.loss_between(),
        }))
    }

    pub fn part(&mut self, _: Vec<u8>, frame: usize, k: usize, n: usize) -> Result<Answer> {
        let (data, beamform) = self.data()?;
        let known = self.parts.iter().position(|(part, _)| *part == [k, n]);
        let index = match known {
            Some(index) => index,
            None => {
                if !matches!(data.transmits, Transmits::Focused { .. }) {
                    // Compounded records take memory, too.
                    self.parts.clear();
                }
                let frames =
                    RecordingFrames::of_part(data, beamform, [k, n], InstructionSet::detect())?;
                self.parts.push(([k, n], frames));
                self.parts.len() - 1
            }
        };
        let frames = &self.parts[index].1;
        let stage = frames.stage().ok_or_else(no_recording)?;
        let samples = data.samples.frame(frame);
        let samples = samples.ok_or_else(|| Error::Usage(format!("there is no frame {frame}")))?;
        let lines = frames.own_lines();
        let mut z = Array2::zeros((lines.len(), stage.samples()));
        frames.frame(samples, &|_| (), z.view_mut())?;
        let z: &[f32] = bytemuck::cast_slice(z.as_slice().unwrap_or_default());
        Ok((json!({ "first": lines.start }), bytes_of(z)))
    }

    pub fn image(&mut self, z: Vec<u8>) -> Result<Answer> {
        let made = match (self.recording, &self.picture) {
            (_, Some(pixels)) => {
                let pixel = self.settings.image.pixel_size.map(|size| size.sides());
                BModeImage {
                    pixels: pixels.clone(),
                    x0: 0.0,
                    z0: 0.0,
                    pixel: pixel.ok_or_else(no_pixel_size)?,
                    angles: None,
                }
            }
            (Some(Recording::Lines(lines)), _) => {
                self.lines = Some(lines.frame(0));
                image_of(&lines.frame(0), &self.settings.image)?
            }
            (Some(_), _) => {
                let stage = self.stage.as_ref().ok_or_else(no_recording)?;
                let mut lines = Array2::zeros((stage.all_rays().len(), stage.samples()));
                // The module's memory is little-endian, as all bytes here.
                let own: &mut [Complex<f32>] = lines.as_slice_mut().unwrap_or_default();
                let own: &mut [u8] = bytemuck::cast_slice_mut(own);
                if own.len() != z.len() {
                    return Err(Error::Data("the lines are those of other settings".into()));
                }
                own.copy_from_slice(&z);
                let z = lines;
                let lines = self.lines.insert(stage.lines(z));
                image_of(lines, &self.settings.image)?
            }
            (None, None) => return Err(no_recording()),
        };
        let answer = pixels_of(&made.pixels, &made);
        self.image = Some(made);
        answer
    }

    pub fn bone_map(&mut self, _: Vec<u8>) -> Result<Answer> {
        let image = self.image.as_ref().ok_or_else(no_recording)?;
        let pixel = image.angles.is_none().then_some(image.pixel);
        let section = &self.settings.phase_symmetry;
        let map = phase_symmetry::of_image(image.pixels.clone(), section, pixel, &mut |_, _| ())?;
        pixels_of(&map, image)
    }

    pub fn surface(&mut self, _: Vec<u8>, frame: usize) -> Result<Answer> {
        let section = &self.settings.surface;
        let points = match (self.recording, &self.picture, &self.lines) {
            (_, Some(pixels), _) => {
                let image = self.image.as_ref().ok_or_else(no_recording)?;
                let picture = Picture {
                    pixels: pixels.view(),
                    pixel: image.pixel,
                    x0: 0.0,
                    z0: 0.0,
                    depth: 0.0,
                };
                let found = of_picture(&picture, section)?;
                return text(json!({
                    "points": points_of(&found.points),
                    "verdict": found.verdict.to_string(),
                }));
            }
            (Some(recording), _, Some(lines)) => {
                let beamform = self.beamform.ok_or_else(no_recording)?;
                let frames = RecordingFrames::new(recording, beamform)?;
                of_recording(&frames, (recording, frame), lines, None, section)?
            }
            _ => return Err(no_recording()),
        };
        text(json!({ "points": points_of(&points) }))
    }

    pub fn measure(&mut self, request: Vec<u8>) -> Result<Answer> {
        text(match of_json(&request)? {
            Measure::Profile { step, db } => {
                let x: Vec<f64> = (0..db.len()).map(|k| k as f64 * step).collect();
                let peak = largest(&db);
                let at = |level: f64| peak.and_then(|peak| width(&x, &db, peak, db[peak] + level));
                json!({ "peak": peak, "width_6db": at(-6.0), "width_12db": at(-12.0) })
            }
            Measure::Regions { a, b } => json!({ "gcnr": gcnr(&a, &b) }),
        })
    }
}

/// A request of [`State::measure`].
#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Measure {
    /// Levels, dB, at even steps.
    Profile { step: f64, db: Vec<f64> },
    /// Levels of two regions.
    Regions { a: Vec<f64>, b: Vec<f64> },
}

fn text(value: Value) -> Result<Answer> {
    Ok((value, Vec::new()))
}

fn no_recording() -> Error {
    Error::Usage("there is no recording yet".into())
}

fn no_pixel_size() -> Error {
    Error::Usage("a picture needs the size of its pixels, such as a pixel_size of 0.0001 m".into())
}

fn of_channel_data(data: &ChannelData, frames: usize) -> Value {
    let (_, transmits, elements, samples) = data.samples.dim();
    json!({
        "kind": "channel",
        "frames": frames,
        "transmits": transmits,
        "elements": elements,
        "samples": samples,
        "fs": data.fs,
        "f0": data.f0,
        "c": data.c,
        "iq": data.samples.f_demod().is_some(),
        "focused": matches!(data.transmits, Transmits::Focused { .. }),
        "warnings": data.warnings(&data.samples.survey()),
    })
}

fn points_of(points: &[SurfacePoint]) -> Vec<Value> {
    let of_point = |p: &SurfacePoint| json!([p.x, p.z, p.confidence, p.piece]);
    points.iter().map(of_point).collect()
}

/// The pixels, where they lie, and the hash of their `.npy` file.
fn pixels_of(pixels: &Array2<f32>, image: &BModeImage) -> Result<Answer> {
    let mut file = Vec::new();
    npy::write(pixels, &mut file).map_err(|e| Error::Data(e.to_string()))?;
    let levels = pixels.as_standard_layout();
    Ok((
        json!({
            "rows": pixels.nrows(),
            "columns": pixels.ncols(),
            "x0": image.x0,
            "z0": image.z0,
            "pixel": image.pixel,
            "polar": image.angles.is_some(),
            "hash": format!("{:032x}", XxHash3_128::oneshot(&file)),
        }),
        bytes_of(levels.as_slice().unwrap_or_default()),
    ))
}

fn bytes_of(numbers: &[f32]) -> Vec<u8> {
    bytemuck::cast_slice(numbers).to_vec()
}
