//! The bone surface of a tracked sweep.

use std::collections::BTreeMap;
use std::path::PathBuf;

use ndarray::{Array2, ArrayView2, Slice};
use rayon::prelude::*;

use bonebeam_drive::config::Surface;
use bonebeam_drive::image::BModeImage;
use bonebeam_drive::surface::{
    FrameSurface, Picture, PictureFan, PictureSurface, SurfacePoint, of_picture,
};
use bonebeam_files::{PartialFrames, hash_of_array};

use crate::cloud::{Axes, CloudPoint, join, set_normals, unit};
use crate::delay::{Delay, estimate};
use crate::kept;
use crate::sequence::{Encoded, RECORDING_PIXEL, Sequence};
use crate::track::Track;
use crate::transforms::{Matrix, apply};
use crate::{Error, Result};

/// Frames in memory, for each thread.
const AHEAD: usize = 4;
/// Frames whose brightest levels show the fan.
const SHOWN: usize = 16;

/// How a sweep is searched.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The detector.
    pub surface: Surface,
    /// Indices of the frames.
    pub frames: Vec<usize>,
    /// Part of the pictures: x, y, width, height, pixels.
    pub crop: Option<[usize; 4]>,
    /// Distance within which points of different frames are one, mm; 0 joins none.
    pub join: f64,
    /// Delay of the pictures behind the poses.
    pub delay: Delay,
    /// File in which a run leaves its surfaces if it is interrupted, and the program's version.
    pub partial: Option<(PathBuf, &'static str)>,
}

/// The bone surface of a sweep.
#[derive(Clone, Debug, Default)]
pub struct Cloud {
    /// Points in the order of frames and lines.
    pub points: Vec<CloudPoint>,
    /// Name of the frame of reference.
    pub target: String,
    /// Number of searched frames, and of those with bone.
    pub searched: [usize; 2],
    /// Numbers of frames left out, by the reason.
    pub left_out: BTreeMap<String, usize>,
    /// Number of points that were joined to others.
    pub joined: usize,
    /// The fan, m from the first pixel's centre; `None` if columns are lines.
    pub fan: Option<PictureFan>,
    /// The delay that was estimated and its standard deviation, in the unit of the timestamps.
    pub delay: Option<[f64; 2]>,
    /// Number of frames that an interrupted run had searched.
    pub resumed: usize,
}

/// Finds the bone in the frames of a sweep.
///
/// The fan is found once. Frames are read in order, some ahead, and searched by all threads. `progress` gets the share
/// that is done. Returns also the file that keeps the surfaces, to be finished when the output exists.
///
/// # Errors
/// Lines in place of pictures, no frame with a pose, a damaged file, or an error of the detector.
pub fn sweep(
    sequence: &Sequence,
    track: &Track,
    settings: &Settings,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<(Cloud, Option<PartialFrames>)> {
    let own = |message: &str| bonebeam_files::file_error(&sequence.path, message);
    if sequence.content.is_lines() {
        return Err(own("holds lines of RF; a sweep needs pictures"));
    }
    let known = match settings.delay {
        Delay::Known(delay) if delay != 0.0 => Some(track.delayed(sequence, delay)?),
        Delay::Known(_) | Delay::Estimated => None,
    };
    let mut track = known.as_ref().unwrap_or(track);
    let frames = track.usable(&settings.frames);
    let finder = Finder::new(sequence, track, settings, &frames)?;
    let mut partial = None;
    if let Some((path, program)) = &settings.partial {
        partial = Some(kept::open((path, program), sequence, &finder, &frames)?);
    }
    let surfaces = search(sequence, &finder, &frames, &mut partial, progress)?;
    let estimated;
    let mut delay = None;
    if settings.delay == Delay::Estimated {
        let found = estimate(sequence, track, &finder, &surfaces)?;
        delay = Some(found);
        estimated = track.delayed(sequence, found[0])?;
        track = &estimated;
    }
    let points = placed(track, &finder, &surfaces).into_iter();
    let points = surfaces.iter().map(|(frame, _)| *frame).zip(points);
    let cloud = Cloud {
        fan: finder.surface.fan,
        delay,
        resumed: partial.as_ref().map_or(0, PartialFrames::resumed),
        ..Cloud::of(track, settings, points.collect())
    };
    Ok((cloud, partial))
}

impl Cloud {
    /// The points of the searched frames that have a pose.
    fn of(track: &Track, settings: &Settings, found: Vec<(usize, Vec<CloudPoint>)>) -> Self {
        let searched = found
            .iter()
            .filter(|(frame, _)| track.poses[*frame].is_ok());
        let with = searched.clone().filter(|(_, points)| !points.is_empty());
        let searched = [searched.clone().count(), with.count()];
        let mut points = found.into_iter().flat_map(|(_, points)| points).collect();
        let joined = join(&mut points, settings.join);
        set_normals(&mut points, |frame| axes(track, frame));
        let mut left_out = BTreeMap::new();
        let poses = settings
            .frames
            .iter()
            .filter_map(|&frame| track.poses.get(frame));
        for reason in poses.filter_map(|pose| pose.as_ref().err()) {
            *left_out.entry(reason.clone()).or_default() += 1;
        }
        Self {
            target: track.target.clone(),
            searched,
            left_out,
            joined,
            points,
            ..Self::default()
        }
    }

    /// The cloud of surfaces in frames of a recording.
    ///
    /// They are in the coordinates of its array. `starts` are those of its beams.
    pub fn of_surfaces(
        track: &Track,
        settings: &Settings,
        surfaces: &[FrameSurface],
        starts: &[[f64; 2]],
    ) -> Self {
        let frames = track.usable(&settings.frames);
        let found = frames.into_iter().map(|(frame, pose)| {
            let place = |metres: [f64; 2]| {
                let [column, row] = metres.map(|metres| 1e3 * metres / RECORDING_PIXEL);
                apply(&pose, [column, row, 0.0])
            };
            let point = |point: &SurfacePoint| {
                let position = place([point.x, point.z]);
                let start = starts.get(point.line).copied().unwrap_or([point.x, 0.0]);
                CloudPoint {
                    position,
                    normal: [0.0; 3],
                    path: crate::cloud::sub(position, place(start)),
                    confidence: point.confidence,
                    frame,
                    line: point.line,
                }
            };
            let own = surfaces.iter().find(|own| own.frame == frame);
            let points = own.map_or(Vec::new(), |own| own.points.iter().map(point).collect());
            (frame, points)
        });
        Self::of(track, settings, found.collect())
    }
}

/// The surface in each of the frames; those that are kept are not searched again.
fn search(
    sequence: &Sequence,
    finder: &Finder,
    frames: &[(usize, Matrix)],
    partial: &mut Option<PartialFrames>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<(usize, Vec<SurfacePoint>)>> {
    let mut surfaces = Vec::with_capacity(frames.len());
    if let Some(partial) = partial {
        for (k, (frame, _)) in frames.iter().enumerate().take(partial.done()) {
            surfaces.push((*frame, partial.read(k, kept::decoded)?));
        }
    }
    let at_a_time = AHEAD * rayon::current_num_threads();
    let mut reader = sequence.reader()?;
    let mut blocks = frames[surfaces.len()..].chunks(at_a_time);
    let mut read = |block: Option<&[(usize, Matrix)]>| -> Result<Vec<Encoded>> {
        block
            .unwrap_or_default()
            .iter()
            .map(|(frame, _)| reader.frame(*frame))
            .collect()
    };
    let mut block = blocks.next();
    let mut encoded = read(block)?;
    while let Some(own) = block {
        let next = blocks.next();
        let (found, ahead) = rayon::join(
            || {
                let frames = own.par_iter().zip(encoded);
                let found = frames.map(|((frame, _), encoded)| {
                    let pixels = finder.part_of(sequence.picture(encoded)?);
                    let hash = hash_of_array(&pixels.view());
                    Ok((*frame, finder.search(&pixels)?.points, hash))
                });
                found.collect::<Result<Vec<_>>>()
            },
            || read(next),
        );
        for (frame, found, hash) in found? {
            if let Some(partial) = partial {
                partial.append(&kept::encoded(&found), hash)?;
            }
            surfaces.push((frame, found));
        }
        progress(surfaces.len() as f64 / frames.len() as f64);
        (block, encoded) = (next, ahead?);
    }
    Ok(surfaces)
}

/// The points of each surface in space, by the poses of a track, without normals.
pub(crate) fn placed(
    track: &Track,
    finder: &Finder,
    surfaces: &[(usize, Vec<SurfacePoint>)],
) -> Vec<Vec<CloudPoint>> {
    let of = |(frame, found): &(usize, Vec<SurfacePoint>)| match &track.poses[*frame] {
        Ok(pose) => finder.points(found, *frame, pose),
        Err(_) => Vec::new(),
    };
    surfaces.iter().map(of).collect()
}

/// Directions of a frame's picture; 0 without a pose.
pub(crate) fn axes(track: &Track, frame: usize) -> Axes {
    let column = |k: usize| match &track.poses[frame] {
        Ok(pose) => unit([0, 1, 2].map(|row| pose[row][k])),
        Err(_) => [0.0; 3],
    };
    Axes {
        across: column(0),
        down: column(1),
    }
}

/// A part of a picture: x, y, width, height.
fn cut(picture: &Array2<f32>, [x, y, width, height]: [usize; 4]) -> ArrayView2<'_, f32> {
    picture.slice_each_axis(|axis| match axis.axis.index() {
        0 => Slice::from(y..y + height),
        _ => Slice::from(x..x + width),
    })
}

/// Finds the surface in single pictures.
#[derive(Clone, Debug)]
pub struct Finder {
    /// The detector as asked for, and with the fan that the first pictures show.
    asked: Surface,
    surface: Surface,
    /// Columns and rows of the pictures.
    sides: [usize; 2],
    /// First column and row, columns, rows.
    part: [usize; 4],
    /// Distances of columns and of rows, m.
    pixel: [f64; 2],
    /// Factor that makes the largest number 255.
    scale: f32,
    /// The brightest levels of the first pictures, and the number of these.
    brightest: Array2<f32>,
    shown: usize,
    /// The sequence, for errors.
    path: PathBuf,
}

impl Finder {
    /// Finds the fan in the brightest levels of some frames.
    ///
    /// # Errors
    /// No frame, a crop beyond the pictures, or errors as of [`sweep`].
    pub fn new(
        sequence: &Sequence,
        track: &Track,
        settings: &Settings,
        frames: &[(usize, Matrix)],
    ) -> Result<Self> {
        if frames.is_empty() {
            let message = "has no frame with a picture and a pose";
            return Err(bonebeam_files::file_error(&sequence.path, message));
        }
        let part = settings.crop.or(sequence.part);
        let mut finder = Self::of(&settings.surface, part, sequence.sides, track.pixel)?;
        finder.path.clone_from(&sequence.path);
        let mut reader = sequence.reader()?;
        for (frame, _) in frames.iter().take(SHOWN) {
            finder.show(&sequence.picture(reader.frame(*frame)?)?);
        }
        finder.settle()?;
        sequence.check_levels(&(&finder.brightest * finder.scale))?;
        Ok(finder)
    }

    /// For pictures of `sides` pixels of the sides `pixel` in mm, or a part of them.
    ///
    /// # Errors
    /// A part beyond the pictures.
    pub fn of(
        surface: &Surface,
        part: Option<[usize; 4]>,
        [columns, rows]: [usize; 2],
        [x, y]: [f64; 2],
    ) -> Result<Self> {
        let part = part.unwrap_or([0, 0, columns, rows]);
        if part[0].saturating_add(part[2]) > columns || part[1].saturating_add(part[3]) > rows {
            let message =
                format!("--crop ends beyond the {columns} x {rows} pixels of the pictures");
            return Err(Error::Usage(message));
        }
        Ok(Self {
            asked: surface.clone(),
            surface: surface.clone(),
            sides: [columns, rows],
            part,
            // By matrices: sides that differ by rounding are one.
            pixel: match (x - y).abs() < 1e-3 * x {
                true => [1e-3 * (x * y).sqrt(); 2],
                false => [1e-3 * x, 1e-3 * y],
            },
            scale: 1.0,
            brightest: Array2::zeros((part[3], part[2])),
            shown: 0,
            path: "pictures".into(),
        })
    }

    /// Whether pictures have these sides, and pixels of these sides in mm, up to a hundredth.
    pub fn is_for(&self, sides: [usize; 2], pixel: [f64; 2]) -> bool {
        let mut own = self.pixel.iter().zip(pixel);
        let near = |(own, side): (&f64, f64)| (1e3 * own - side).abs() < 0.01 * side;
        self.sides == sides && own.all(near)
    }

    /// Adds one of the first pictures, and says whether it was one.
    pub fn show(&mut self, picture: &Array2<f32>) -> bool {
        let part = cut(picture, self.part);
        self.shown += 1;
        self.brightest
            .zip_mut_with(&part, |most, level| *most = most.max(*level));
        self.shown <= SHOWN
    }

    /// Finds the scale of the levels and the fan in the pictures shown.
    ///
    /// # Errors
    /// As [`of_picture`].
    pub fn settle(&mut self) -> Result<()> {
        let most = self.brightest.iter().copied().fold(255.0, f32::max);
        self.scale = 255.0 / most;
        self.surface.clone_from(&self.asked);
        if self.asked.fan.is_none() && !self.asked.columns_as_lines {
            let found = self.search(&(&self.brightest * self.scale))?;
            self.surface.fan = found.fan;
            self.surface.columns_as_lines = found.fan.is_none();
        }
        Ok(())
    }

    /// A searched part as an image from its own top left.
    pub fn image(&self, pixels: Array2<f32>) -> BModeImage {
        BModeImage {
            pixels,
            x0: 0.0,
            z0: 0.0,
            pixel: self.pixel,
            angles: None,
        }
    }

    /// First column and row, columns and rows of the searched part.
    pub fn part(&self) -> [usize; 4] {
        self.part
    }

    /// The levels of a picture's part, 0 to 255.
    pub fn part_of(&self, mut picture: Array2<f32>) -> Array2<f32> {
        if picture.dim() != self.brightest.dim() {
            picture = cut(&picture, self.part).to_owned();
        }
        if self.scale != 1.0 {
            picture *= self.scale;
        }
        picture
    }

    /// The surface in the levels of a part.
    ///
    /// # Errors
    /// As [`of_picture`].
    pub fn search(&self, picture: &Array2<f32>) -> Result<PictureSurface> {
        let of = Picture {
            pixels: picture.view(),
            pixel: self.pixel,
            x0: 0.0,
            z0: 0.0,
            depth: 0.0,
        };
        let found = of_picture(&of, &self.surface);
        found.map_err(|e| match e {
            Error::Usage(message) => Error::Usage(message),
            e => bonebeam_files::file_error(&self.path, e.to_string()),
        })
    }

    /// The points of a surface in space, without normals.
    pub fn points(&self, found: &[SurfacePoint], frame: usize, pose: &Matrix) -> Vec<CloudPoint> {
        let fan = &self.surface.fan;
        let place = |[x, z]: [f64; 2]| {
            let [column, row] = [x / self.pixel[0], z / self.pixel[1]];
            apply(
                pose,
                [column + self.part[0] as f64, row + self.part[1] as f64, 0.0],
            )
        };
        let point = |point: &SurfacePoint| {
            let [x, z] = [point.x, point.z];
            let start = match fan {
                Some(fan) => fan.at(fan.radii[0], (x - fan.x).atan2(z - fan.z)),
                None => [x, 0.0],
            };
            let position = place([x, z]);
            CloudPoint {
                position,
                normal: [0.0; 3],
                path: crate::cloud::sub(position, place(start)),
                confidence: point.confidence,
                frame,
                line: point.line + if fan.is_none() { self.part[0] } else { 0 },
            }
        };
        found.iter().map(point).collect()
    }
}
