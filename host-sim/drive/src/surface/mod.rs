//! Lines or a picture → the bone surface, through the core.

mod fan;
mod files;
mod lit;
mod mesh;
mod picture;
mod verdict;

use bonebeam::geometry::Axis;
use bonebeam::image::{Fan, envelope, largest, log_compression};
use bonebeam::memory::Scratch;
use bonebeam::surface::{Detector, Parameters, Point, Settings, Survey, grey};
use ndarray::{Array2, ArrayBase, ArrayView2, Data, Ix2};
use num_complex::Complex;
use rayon::prelude::*;

use bonebeam_files::{BeamformedLines, Recording};

use crate::coherence::{self, Measure};
use crate::config;
use crate::frame::RecordingFrames;
use crate::image::{Layout, layout, sample_axis};
use crate::{Error, Result};
pub use fan::PictureFan;
pub use files::{FrameSurface, Kind, add_surfaces_to};
pub use picture::{Picture, PictureSurface, of_picture};
use verdict::Facts;
pub use verdict::Verdict;

/// A point of the bone surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Index of the line, of the beam of the picture's fan, or of the picture's column.
    pub line: usize,
    /// Lateral position, m, in the coordinates of the lines or of the picture.
    pub x: f64,
    /// Depth, m.
    pub z: f64,
    /// Confidence, from 0 to 1.
    pub confidence: f32,
    /// Index of the piece of surface that the point belongs to.
    pub piece: usize,
}

/// Finds the surface in lines: at most one point per line, in their order.
///
/// # Errors
/// Lines that cross or are not in order from left to right, a NaN or infinite sample, lines that are too short, or a
/// parameter out of range.
pub fn of_lines<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    section: &config::Surface,
) -> Result<Vec<SurfacePoint>> {
    of_lines_with(lines, None, section, f64::INFINITY)
}

/// Finds the surface in the lines of a frame of a recording.
///
/// Lines of channel data are searched with the coherence of their samples; missing values of the section are then those
/// of [`Settings::COHERENCE`]. Lines, and those of aligned data, are searched without coherence, as by [`of_lines`]: such data may
/// hold only a few elements. `known` is the frame's coherence, if it is already computed.
///
/// # Errors
/// As [`of_lines`] and [`of_frame`](crate::coherence::of_frame).
pub fn of_recording(
    frames: &RecordingFrames<'_>,
    (recording, frame): (&Recording, usize),
    lines: &BeamformedLines,
    known: Option<&Array2<f32>>,
    section: &config::Surface,
) -> Result<Vec<SurfacePoint>> {
    let Recording::Channel(data) = recording else {
        return of_lines(lines, section);
    };
    let [_, end] = data.depths(lines.c);
    let of_frame = |map: &Array2<f32>| of_lines_with(lines, Some(map.view()), section, end);
    match known {
        Some(map) => of_frame(map),
        None => of_frame(&coherence::of_frame(
            frames,
            recording,
            frame,
            Measure::ShortLag,
        )?),
    }
}

/// [`of_lines`] with the coherence of their samples, −1 to 1, [line, sample].
///
/// # Errors
/// As [`of_lines`]; a coherence of another shape.
pub fn of_lines_with_coherence<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    coherence: ArrayView2<'_, f32>,
    section: &config::Surface,
) -> Result<Vec<SurfacePoint>> {
    of_lines_with(lines, Some(coherence), section, f64::INFINITY)
}

/// Samples deeper than `end`, m, are not read: silence below the last recorded echo would look like a shadow.
fn of_lines_with<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    coherence: Option<ArrayView2<'_, f32>>,
    section: &config::Surface,
    end: f64,
) -> Result<Vec<SurfacePoint>> {
    let mut samples = sample_axis(lines);
    let spacing = match layout(lines)? {
        Layout::Even(beams) => beams.step,
        Layout::Fan { fan, angles } => spacing_of_fan(&fan, &angles, &samples),
        Layout::Any(lattice) => lattice.width() / (lattice.rays().len() - 1) as f64,
    };
    let mut grey = grey_of_lines(lines, section.grey_range as f32)?;
    let mut coherence = coherence.map(levels_of_coherence).transpose()?;
    // With the sample that holds the end, as lines have by default. The cast saturates.
    let recorded = ((end - samples.first) / samples.step + 2.0) as usize;
    if recorded < samples.count {
        for levels in [&mut grey].into_iter().chain(&mut coherence) {
            let lines = levels.chunks_exact(samples.count);
            *levels = lines.flat_map(|line| &line[..recorded]).copied().collect();
        }
        samples.count = recorded;
    }
    let settings = section.settings(match &coherence {
        Some(_) => Settings::COHERENCE,
        None => Settings::DEFAULT,
    });
    let (mut points, _) = detect(&grey, coherence.as_deref(), samples, spacing, settings)?;
    let falls = [POINT_FALL, SIDE_LOBES].map(|fall| (fall / section.grey_range * 255.0) as u8);
    doubt_points(&mut points, &grey, samples, spacing, falls);
    let place = |line, r| lines.point(line, r);
    Ok(placed(points, section.min_confidence, place))
}

/// Level below its brightest echo down to which a piece of surface must be long, dB.
const POINT_FALL: f64 = 20.0;
/// Length below which a piece is an echo of a point with its side lobes, m.
const POINT_LENGTH: f64 = 1.5e-3;
/// Level of side lobes below their point, at most, dB.
const SIDE_LOBES: f64 = 25.0;
/// Largest confidence of such a piece.
const POINT_CONFIDENCE: f32 = 0.25;
/// Distance of an echo from its point, m.
const ECHO: f64 = 0.4e-3;

/// Lowers the confidence of pieces as short as a point's echo, and of its side lobes.
///
/// Their length counts down to the first number of grey levels below their brightest echo. Side lobes are the second
/// number below the brightest point.
/// In water a point has an echo and a shadow as bone has, and side lobes that go on from line to line.
fn doubt_points(
    points: &mut [Option<Point>],
    grey: &[u8],
    samples: Axis,
    spacing: f64,
    [fall, side_lobes]: [u8; 2],
) {
    let reach = (ECHO / samples.step) as usize;
    let echo = |line: usize, point: &Point| {
        // The cast saturates.
        let at = ((f64::from(point.depth) - samples.first) / samples.step).round() as usize;
        let levels = grey.get(line * samples.count..(line + 1) * samples.count)?;
        let end = at.saturating_add(reach + 1).min(levels.len());
        levels
            .get(at.saturating_sub(reach)..end)?
            .iter()
            .copied()
            .max()
    };
    let echoes: Vec<Option<u8>> = points
        .iter()
        .enumerate()
        .map(|(line, point)| echo(line, point.as_ref()?))
        .collect();
    // Each piece: its lines, its brightest echo, and whether it is a point.
    let mut pieces = Vec::new();
    let mut first = 0;
    while first < points.len() {
        let goes_on = |point: &&Option<Point>| point.is_some_and(|point| !point.begins);
        let end = first + 1 + points[first + 1..].iter().take_while(goes_on).count();
        let of_piece = echoes[first..end].iter().flatten();
        let brightest = of_piece.clone().copied().max().unwrap_or(0);
        let bright = of_piece.filter(|echo| **echo >= brightest.saturating_sub(fall));
        let is_point = (bright.count() as f64) * spacing < POINT_LENGTH;
        pieces.push((first..end, brightest, is_point));
        first = end;
    }
    let brightest_points = pieces.iter().filter(|piece| piece.2).map(|piece| piece.1);
    let faint = brightest_points
        .max()
        .unwrap_or(0)
        .saturating_sub(side_lobes);
    for (lines, brightest, is_point) in pieces {
        if is_point || brightest < faint {
            for point in points[lines].iter_mut().flatten() {
                point.confidence = point.confidence.min(POINT_CONFIDENCE);
            }
        }
    }
}

/// Distance between neighbouring lines of a fan at half its depth, m.
fn spacing_of_fan(fan: &Fan, angles: &Axis, samples: &Axis) -> f64 {
    let middle = (samples.first + samples.last()) / 2.0;
    angles.step * (fan.radius + middle)
}

/// Grey levels of lines, `[line][sample]`, over a dynamic range in dB.
fn grey_of_lines<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    dynamic_range: f32,
) -> Result<Vec<u8>> {
    let z = lines.z.as_standard_layout();
    let z = z.as_slice().unwrap_or_default();
    let samples = lines.z.ncols().max(1);
    let mut envelopes = vec![0.0; z.len()];
    let each = z.par_chunks(samples).zip(envelopes.par_chunks_mut(samples));
    each.try_for_each(|(z, out)| envelope(z, out))?;
    let reference = largest(&envelopes);
    let mut levels = vec![0; z.len()];
    let each = envelopes
        .par_chunks(samples)
        .zip(levels.par_chunks_mut(samples));
    each.try_for_each(|(envelope, out)| {
        let mut level = vec![0.0; envelope.len()];
        log_compression(envelope, reference, dynamic_range, &mut level)?;
        grey(&level, out)
    })?;
    Ok(levels)
}

/// Coherence as the core takes it, 0 for none or less and 255 for 1.
fn levels_of_coherence(map: ArrayView2<'_, f32>) -> Result<Vec<u8>> {
    let scaled: Vec<f32> = map.iter().map(|coherence| 255.0 * coherence).collect();
    let mut levels = vec![0; scaled.len()];
    grey(&scaled, &mut levels)?;
    Ok(levels)
}

/// Runs the core's detector over a whole frame; returns its levels too.
fn detect(
    grey: &[u8],
    coherence: Option<&[u8]>,
    samples: Axis,
    spacing: f64,
    mut settings: Settings,
) -> Result<(Vec<Option<Point>>, Facts)> {
    // Nearer to the end of the data there is too little shadow to judge, and the end itself looks like a shadow.
    let end = samples.last() - settings.far[1];
    if settings.depths[1].is_infinite() && end > settings.depths[0] + settings.far[1] {
        settings.depths[1] = end;
    }
    let lines = grey.len() / samples.count.max(1);
    let of_piece = |piece| {
        Detector::new(Parameters {
            samples,
            spacing,
            settings: Settings { piece, ..settings },
            latency: lines.saturating_sub(1),
        })
    };
    let (detector, sure) = (of_piece(0.0)?, of_piece(settings.piece)?);
    let need = detector.need();
    let mut real = Vec::new();
    let refused = |_| Error::Usage("not enough memory for the bone surface".into());
    real.try_reserve_exact(need.real).map_err(refused)?;
    real.resize(need.real, 0.0);
    let mut scratch = Scratch::new(&mut real, &mut []);
    let mut survey = Survey::new(&detector, scratch.reborrow())?;
    for line in grey.chunks_exact(samples.count).step_by(Survey::EVERY) {
        survey.line(line)?;
    }
    let levels = survey.levels();
    let mut points = vec![None; lines];
    match coherence {
        Some(map) => detector.frame_with_coherence(grey, map, scratch, &mut points)?,
        None => detector.frame(grey, scratch, &mut points)?,
    }
    let surface = points.iter().any(Option::is_some);
    sure.keep_sure_pieces(&mut points);
    Ok((points, Facts { levels, surface }))
}

/// Points at the positions `at(line, depth)`, in pieces.
///
/// Points with a confidence below `least` are left out.
fn placed(
    points: Vec<Option<Point>>,
    least: f64,
    at: impl Fn(usize, f64) -> [f64; 2],
) -> Vec<SurfacePoint> {
    let mut placed: Vec<SurfacePoint> = Vec::new();
    let mut begins = true;
    for (line, point) in points.into_iter().enumerate() {
        let sure = point.filter(|point| f64::from(point.confidence) >= least);
        let Some(point) = sure else {
            begins = true;
            continue;
        };
        let [x, z] = at(line, f64::from(point.depth));
        let piece = match placed.last() {
            None => 0,
            Some(last) => last.piece + usize::from(begins || point.begins),
        };
        placed.push(SurfacePoint {
            line,
            x,
            z,
            confidence: point.confidence,
            piece,
        });
        begins = false;
    }
    placed
}
