//! Inputs of `host-sim surface`: pictures, lines, recordings; their surfaces.

use std::ops::Range;
use std::path::Path;

use super::about;
use super::check::warn_of;
use super::frames::FrameRange;
use crate::config::Config;
use crate::progress::Progress;
use crate::provenance::Snapshot;
use crate::{Error, Result};
use bonebeam_drive::frame::RecordingFrames;
use bonebeam_drive::image::{BModeImage, image_of};
use bonebeam_drive::policy::{Pictures, working_memory};
use bonebeam_drive::surface::{self, FrameSurface, Picture, PictureFan, of_picture};
use bonebeam_files::terminal::remark;
use bonebeam_files::{BeamformedLines, Recording, SharedHash, image, memory};
use bonebeam_formats::RecordingFile;
use bonebeam_tracked::{PoseTable, Sequence};
use ndarray::{Array2, Slice};

/// Part of a picture, pixels.
#[derive(Clone, Copy, Debug)]
pub struct Crop {
    pub x: usize,
    pub y: usize,
    pub width: usize,
    pub height: usize,
}

/// Parses `X,Y,WIDTH,HEIGHT`.
pub fn parse_crop(text: &str) -> std::result::Result<Crop, String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Crop {
            x,
            y,
            width,
            height,
        }),
        _ => Err("expected four whole numbers of pixels, such as 80,40,512,480".into()),
    }
}

/// The input file, and the part of it to read.
pub struct Source<'a> {
    pub path: &'a Path,
    pub crop: Option<Crop>,
    pub frames: Option<&'a FrameRange>,
    /// The hash of the file, if it is wanted.
    pub hash: Option<SharedHash>,
    /// Distance of the frames of a recording that are searched.
    pub every: usize,
    /// Whether the picture is drawn.
    pub drawn: bool,
    /// A given flag that applies only to pictures.
    pub of_picture: Option<&'a str>,
}

impl Source<'_> {
    /// Refuses a flag for pictures if the input is not a picture.
    fn refuse_of_picture(&self) -> Result<()> {
        let Some(flag) = self.of_picture else {
            return Ok(());
        };
        Err(Error::Usage(format!(
            "--{flag} has no effect on {}, which is not a picture",
            self.path.display()
        )))
    }

    /// The frames to search, out of `held` frames; a sweep has several.
    fn range(&self, held: usize, config: &Config) -> Result<Range<usize>> {
        let range = FrameRange::of(self.frames, held)?;
        match config.surface.sweep_step {
            Some(_) if range.len() < 2 => Err(Error::Usage(format!(
                "--sweep-step needs several frames; {} gives one",
                self.path.display()
            ))),
            _ => Ok(range),
        }
    }
}

/// Surfaces of the frames, and the picture of the first.
pub struct Found {
    /// At least one.
    pub frames: Vec<FrameSurface>,
    pub lines: usize,
    /// Where the beams of a recording begin, x and z, m.
    pub starts: Vec<[f64; 2]>,
    pub picture: Option<BModeImage>,
    /// Fan of a picture whose lines are beams.
    pub fan: Option<PictureFan>,
}

impl Found {
    /// Finds the surfaces in a source.
    ///
    /// # Errors
    /// Flags that have no effect on the source, invalid data, or an error of the core.
    pub fn of(source: &Source<'_>, config: &Config, snapshot: &Snapshot) -> Result<Self> {
        let path = source.path;
        if image::is_image(path) {
            if source.frames.is_some() {
                let message = format!("--frames has no effect on {}, a picture", path.display());
                return Err(Error::Usage(message));
            }
            return of_pictures(source, config, 1, (None, None), |_| {
                image::read_levels(path)
            });
        }
        if path.is_file() && Sequence::recognizes(path) {
            let sequence = Sequence::open(path, &PoseTable::default())?;
            if !sequence.content.is_lines() {
                return of_sequence(source, config, &sequence);
            }
        }
        source.refuse_of_picture()?;
        of_recording(source, config, snapshot)
    }
}

/// The surfaces of the pictures of a sequence.
fn of_sequence(source: &Source<'_>, config: &Config, sequence: &Sequence) -> Result<Found> {
    for what in &sequence.assumed {
        remark(&format!("{}: {what}", source.path.display()));
    }
    let known = sequence.pixel.map(|sides| sides.map(|mm| 1e-3 * mm));
    let part = sequence.part;
    let mut reader = sequence.reader()?;
    let count = sequence.frames.len();
    let mut is_checked = false;
    of_pictures(source, config, count, (known, part), |frame| {
        let picture = sequence.picture(reader.frame(frame)?)?;
        if !std::mem::replace(&mut is_checked, true) {
            sequence.check_levels(&picture)?;
        }
        Ok(picture)
    })
}

/// The surfaces of pictures, of a number of frames.
///
/// A file may say the sides of a pixel in m, and the part that shows tissue, in pixels.
fn of_pictures(
    source: &Source<'_>,
    config: &Config,
    count: usize,
    (known, part): (Option<[f64; 2]>, Option<[usize; 4]>),
    mut picture: impl FnMut(usize) -> Result<Array2<f32>>,
) -> Result<Found> {
    let path = source.path;
    let pixel = match (config.image.pixel_size, known) {
        (Some(pixel), _) => pixel.sides(),
        (None, Some(sides)) => sides,
        (None, None) => {
            return Err(Error::Usage(format!(
                "{} is a picture; give its pixel size in m, such as --pixel-size 0.0001",
                path.display()
            )));
        }
    };
    if let Some(side) = pixel.iter().find(|side| !(1e-6..=1e-2).contains(*side)) {
        return Err(Error::Usage(format!(
            "--pixel-size is {side}; expected 1e-6 to 0.01 (m)"
        )));
    }
    let crop = source
        .crop
        .map(|crop| [crop.x, crop.y, crop.width, crop.height]);
    let (mut section, mut frames, mut first) = (config.surface.clone(), Vec::new(), None);
    let range = source.range(count, config)?;
    let bar = Progress::new("searching", range.len() as u64);
    for frame in range.clone() {
        bar.set((frame - range.start) as u64, range.len() as u64);
        let pixels = picture(frame)?;
        let (rows, columns) = pixels.dim();
        let [x, y, width, height] = crop.or(part).unwrap_or([0, 0, columns, rows]);
        let ends = [x.saturating_add(width), y.saturating_add(height)];
        if ends[0] > columns || ends[1] > rows {
            return Err(Error::Usage(format!(
                "--crop ends at {},{}; {} has {columns} x {rows} pixels",
                ends[0],
                ends[1],
                path.display()
            )));
        }
        let cropped = pixels.slice_each_axis(|axis| match axis.axis.index() {
            0 => Slice::from(y..ends[1]),
            _ => Slice::from(x..ends[0]),
        });
        let cropped = Picture {
            pixels: cropped,
            pixel,
            x0: x as f64 * pixel[0],
            z0: y as f64 * pixel[1],
            depth: 0.0,
        };
        let mut found = of_picture(&cropped, &section).map_err(|e| about(path, e))?;
        if found.fan.is_none() {
            // Columns of the whole picture.
            for point in &mut found.points {
                point.line += x;
            }
        }
        frames.push(FrameSurface {
            frame,
            points: found.points,
            verdict: Some(found.verdict.to_string()),
        });
        if first.is_none() {
            // The fan stays where it is.
            section.fan = found.fan.or(section.fan);
            let (x0, z0, angles) = (0.0, 0.0, None);
            let picture = BModeImage {
                pixels,
                x0,
                z0,
                pixel,
                angles,
            };
            first = Some((found.lines, picture, found.fan));
        }
    }
    bar.clear();
    let (lines, picture, fan) = first.ok_or_else(no_frame)?;
    Ok(Found {
        frames,
        lines,
        starts: Vec::new(),
        picture: Some(picture),
        fan,
    })
}

fn no_frame() -> Error {
    Error::Usage("--frames selects no frame".into())
}

/// Adds the surface of a frame; of the first frame also the picture if asked for.
///
/// `recorded` is the frame in its recording.
fn add_frame(
    found: &mut Option<Found>,
    frame: usize,
    (lines, coherence): (&BeamformedLines, Option<&Array2<f32>>),
    (source, config): (&Source<'_>, &Config),
    (frames, recorded): (&RecordingFrames<'_>, (&Recording, usize)),
) -> Result<()> {
    let of_file = |error| about(source.path, error);
    let points = surface::of_recording(frames, recorded, lines, coherence, &config.surface);
    let points = points.map_err(of_file)?;
    let surface = FrameSurface {
        frame,
        points,
        verdict: None,
    };
    match found {
        Some(found) => found.frames.push(surface),
        None => {
            let depth = |k: usize| lines.rays.as_ref().map_or(0.0, |rays| rays.z[k]);
            let starts = lines.beam_x.iter().enumerate();
            let wanted = source.drawn;
            let picture = wanted.then(|| image_of(lines, &config.image)).transpose();
            *found = Some(Found {
                frames: vec![surface],
                lines: lines.beam_x.len(),
                starts: starts.map(|(k, &x)| [x, depth(k)]).collect(),
                picture: picture.map_err(of_file)?,
                fan: None,
            });
        }
    }
    Ok(())
}

/// Beamforms frames in the file's blocks, and finds the surface of each.
fn of_recording(source: &Source<'_>, config: &Config, snapshot: &Snapshot) -> Result<Found> {
    let path = source.path;
    let file = RecordingFile::open_hashed(path, &config.variables, source.hash.clone())?;
    let frames = source.range(file.frames(), config)?;
    super::tell_assumed(path, &file);
    let first = file.first();
    if let Recording::Channel(data) = first {
        warn_of(path, data, &config.beamform)?;
    }
    let pictures = source.drawn.then_some(Pictures {
        image: &config.image,
        bone_map: None,
        figure: false,
    });
    let at_a_time = file.frames_at_a_time().min(frames.len());
    let bytes = working_memory(first, &config.beamform, pictures.as_ref(), at_a_time);
    memory::check(bytes, "beamforming").map_err(|e| about(path, e))?;
    let (shared, mut blocks) = file.into_blocks(frames.clone(), at_a_time);
    let beamformer = RecordingFrames::new(&shared, &config.beamform).map_err(|e| about(path, e))?;
    let bar = Progress::new("beamforming", 1000);
    let mut found = None;
    for start in frames.clone().step_by(at_a_time.max(1)) {
        let (recording, own) = blocks.block(start)?;
        snapshot.check()?;
        let (done, block) = ((start - frames.start) as f64, own.len() as f64);
        let fraction = |part: f64| (done + part * block) / frames.len() as f64;
        let progress = |part: f64| bar.set((1000.0 * fraction(part)) as u64, 1000);
        for (index, held) in (start..).zip(own) {
            if !(index - frames.start).is_multiple_of(source.every) {
                continue;
            }
            let progress = |part: f64| progress(((index - start) as f64 + part) / block);
            let both = beamformer.lines_and_coherence(recording, held, &progress);
            let (lines, coherence) = both.map_err(|e| about(path, e))?;
            let recorded = (&beamformer, (recording, held));
            let lines = (&lines, coherence.as_ref());
            add_frame(&mut found, index, lines, (source, config), recorded)?;
        }
    }
    bar.clear();
    found.ok_or_else(no_frame)
}
