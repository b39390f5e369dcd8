//! The bone surface of a tracked sweep.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rayon::prelude::*;

use bonebeam_drive::config::Surface;
use bonebeam_drive::surface::{FrameSurface, PictureFan, SurfacePoint};
use bonebeam_files::{PartialFrames, hash_of_array};

use crate::cloud::{CloudPoint, join, set_normals};
use crate::delay::{Delay, estimate};
use crate::finder::{Finder, axes, placed};
use crate::kept;
use crate::sequence::{Encoded, RECORDING_PIXEL, Sequence};
use crate::track::Track;
use crate::transforms::{Matrix, apply};
use crate::{Result, agreement};

/// Frames in memory, for each thread.
const AHEAD: usize = 4;
/// Mean confidence of a piece from which neighbouring frames may confirm it.
const UNSURE: f64 = 0.3;

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
    /// The output beside which an interrupted run leaves its surfaces, and the program's version.
    pub resumable: Option<(PathBuf, &'static str)>,
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
    /// Number of points left out since no neighbouring frame shows them.
    pub alone: usize,
    /// Number of points of unsure pieces that neighbouring frames confirm.
    pub confirmed: usize,
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
    let sure = settings.surface.settings_of_picture()?.piece;
    let surface = Surface {
        min_piece: Some(UNSURE.min(f64::from(sure))),
        ..settings.surface.clone()
    };
    let mut finder = Finder::new(sequence, track, (&surface, settings.crop), &frames)?;
    finder.sure = sure;
    let mut partial = None;
    if let Some((output, program)) = &settings.resumable {
        partial = Some(kept::open((output, program), sequence, &finder, &frames)?);
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
        fan: finder.fan(),
        delay,
        resumed: partial.as_ref().map_or(0, PartialFrames::resumed),
        ..Cloud::of(track, settings, points.collect())
    };
    Ok((cloud, partial))
}

impl Cloud {
    /// The points of the searched frames that have a pose.
    fn of(track: &Track, settings: &Settings, mut found: Vec<(usize, Vec<CloudPoint>)>) -> Self {
        found.retain(|(frame, _)| track.poses[*frame].is_ok());
        let [alone, confirmed] =
            agreement::weigh(&mut found, settings.surface.min_confidence, |frame| {
                let pose = track.poses[frame].as_ref();
                let origin = pose.map_or([0.0; 3], |pose| [0, 1, 2].map(|row| pose[row][3]));
                (origin, axes(track, frame))
            });
        let with = found.iter().filter(|(_, points)| !points.is_empty());
        let searched = [found.len(), with.count()];
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
            alone,
            confirmed,
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
                CloudPoint::new(
                    position,
                    place(start),
                    point.confidence,
                    [frame, point.line],
                )
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
    let is_kept = partial.is_some();
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
                    let hash = is_kept.then(|| hash_of_array(&pixels.view()));
                    Ok((*frame, finder.search(&pixels)?.points, hash))
                });
                found.collect::<Result<Vec<_>>>()
            },
            || read(next),
        );
        for (frame, found, hash) in found? {
            if let (Some(partial), Some(hash)) = (&mut *partial, hash) {
                partial.append(&kept::encoded(&found), hash)?;
            }
            surfaces.push((frame, found));
        }
        progress(surfaces.len() as f64 / frames.len() as f64);
        (block, encoded) = (next, ahead?);
    }
    Ok(surfaces)
}
