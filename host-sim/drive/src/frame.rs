//! A recording → beamformed lines.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use bonebeam::geometry::{Active, Axis as Depths, Ray};
use ndarray::{Array2, Array3, ArrayViewMut2, Axis};
use num_complex::Complex;

use crate::beamform::beamform_within;
use crate::config::{Beamform, RfReading};
use crate::delay::DelayStage;
use crate::{Error, Result};
use bonebeam_files::{AlignedData, BeamRays, ChannelData, Frame, Lines};

/// How many beams are delayed at a time: a multiple of the lanes, and enough for all threads,
/// while the aligned samples of a large set stay within some hundred megabytes.
const BEAMS_AT_A_TIME: usize = 64;
/// Where records are upsampled for so many beams at a time: rarely.
const BEAMS_UPSAMPLED: usize = 128;

/// How many beams are delayed at a time.
pub(crate) fn beams_at_a_time(parameters: &Beamform) -> usize {
    match parameters.rf_reading {
        Some(RfReading::Upsampled) => BEAMS_UPSAMPLED,
        _ => BEAMS_AT_A_TIME,
    }
}

/// The speed of sound that lines tell where neither the file nor the configuration does, m/s.
pub const DEFAULT_SOUND_SPEED: f64 = 1540.0;

/// Delays and beamforms the first frame of channel data. `progress` hears the fraction done, from any
/// thread.
///
/// # Errors
/// Parameters that do not fit the record; see [`DelayStage::new`] and [`beamform_within`].
pub fn beamform_channel_data(
    data: &ChannelData,
    parameters: &Beamform,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Lines> {
    let mut lines = beamform_frames(data, parameters, 0..1, progress)?;
    Ok(lines.remove(0))
}

/// Delays and beamforms some frames of channel data, as lines each.
///
/// # Errors
/// [`Error::Usage`] for frames that there are not; as [`beamform_channel_data`].
pub fn beamform_frames(
    data: &ChannelData,
    parameters: &Beamform,
    frames: Range<usize>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Lines>> {
    let stage = DelayStage::new(data, parameters)?;
    let shape = (stage.beam_x().len(), stage.samples());
    let rays = beam_rays(&stage);
    let (start, count) = (frames.start, frames.len() as f64);
    let lines = frames.map(|index| {
        let frame = data.samples.frame(index);
        let frame = frame.ok_or_else(|| no_frame(index, data.samples.frames()))?;
        let share = |part: f64| progress(((index - start) as f64 + part) / count);
        let mut z = Array2::zeros(shape);
        beamform_frame(&stage, frame, parameters, &share, z.view_mut())?;
        Ok(Lines {
            z,
            fs: parameters.rate_of(data),
            t0: stage.start(),
            beam_x: stage.beam_x().to_vec(),
            rays: rays.clone(),
            c: stage.sound_speed(),
        })
    });
    lines.collect()
}

/// Delays and beamforms one frame of the stage's data, which may lie elsewhere, into `z` [beam, sample].
///
/// # Errors
/// What the core refuses; see [`beamform_within`].
pub fn beamform_frame(
    stage: &DelayStage<'_>,
    frame: Frame<'_>,
    parameters: &Beamform,
    progress: &(dyn Fn(f64) + Sync),
    mut z: ArrayViewMut2<'_, Complex<f32>>,
) -> Result<()> {
    let (beams, samples) = z.dim();
    let done = AtomicUsize::new(0);
    let count = |n: usize| report(progress, &done, n, beams * samples);
    let core = parameters.parameters();
    let adaptive = parameters.adaptive_samples(&stage.depths())?;
    let at_a_time = beams_at_a_time(parameters).min(beams);
    // Asked for once: fresh memory takes the system as long as much of the work.
    let mut x = Array3::zeros((at_a_time, samples, stage.elements()));
    for first in (0..beams).step_by(at_a_time.max(1)) {
        let chunk = first..beams.min(first + at_a_time);
        let mut x = x.slice_axis_mut(Axis(0), (..chunk.len()).into());
        let own = x.as_slice_mut().expect("whole beams of a standard layout");
        stage.delay_frame_into(frame, chunk.clone(), own)?;
        let active = |beam: usize, sample: usize| stage.active(first + beam, sample);
        let within = adaptive.clone();
        let part = beamform_within(x.view(), active, within, core, parameters.covariance, count)?;
        z.slice_axis_mut(Axis(0), chunk.into()).assign(&part);
    }
    Ok(())
}

/// Where the beams of a delay stage begin and go, where that is not straight down from z = 0.
pub fn beam_rays(stage: &DelayStage<'_>) -> Option<BeamRays> {
    let rays = stage.rays();
    let down = |ray: &Ray| ray.z() == 0.0 && ray.angle() == 0.0;
    (!rays.iter().all(down)).then(|| BeamRays {
        z: rays.iter().map(Ray::z).collect(),
        angle: rays.iter().map(Ray::angle).collect(),
    })
}

/// Beamforms some frames of aligned data with all elements active, as lines each. Beams without positions
/// are taken to lie `beam_spacing` apart, centred on 0.
///
/// # Errors
/// [`Error::Usage`] for frames that there are not, and parameters that do not fit the record; see
/// [`beamform_within`].
pub fn beamform_aligned_frames(
    data: &AlignedData,
    parameters: &Beamform,
    frames: Range<usize>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Lines>> {
    let (held, beams, samples, elements) = data.x.dim();
    let all = Active {
        first: 0,
        count: elements,
    };
    let done = AtomicUsize::new(0);
    let of = frames.len() * beams * samples;
    let count = |n: usize| report(progress, &done, n, of);
    let core = parameters.parameters();
    let c = parameters.sound_speed.unwrap_or(DEFAULT_SOUND_SPEED);
    let depths = Depths {
        first: c * data.t0 / 2.0,
        step: c / data.fs / 2.0,
        count: samples,
    };
    let adaptive = parameters.adaptive_samples(&depths)?;
    let beam_x = data
        .beam_x
        .clone()
        .unwrap_or_else(|| even_beams(beams, parameters.beam_spacing));
    let lines = frames.map(|index| {
        if index >= held {
            return Err(no_frame(index, held));
        }
        let x = data.x.index_axis(Axis(0), index);
        let covariance = parameters.covariance;
        Ok(Lines {
            z: beamform_within(x, |_, _| all, adaptive.clone(), core, covariance, count)?,
            fs: data.fs,
            t0: data.t0,
            beam_x: beam_x.clone(),
            rays: None,
            c,
        })
    });
    lines.collect()
}

fn no_frame(index: usize, frames: usize) -> Error {
    Error::Usage(format!(
        "there is no frame {index}; expected 0 to {}",
        frames.saturating_sub(1)
    ))
}

/// The positions of beams that lie `spacing` apart, centred on 0, m.
pub fn even_beams(beams: usize, spacing: f64) -> Vec<f64> {
    let centre = beams.saturating_sub(1) as f64 / 2.0;
    (0..beams).map(|b| (b as f64 - centre) * spacing).collect()
}

fn report(progress: &(dyn Fn(f64) + Sync), done: &AtomicUsize, n: usize, of: usize) {
    let done = done.fetch_add(n, Ordering::Relaxed) + n;
    progress(done as f64 / of as f64);
}
