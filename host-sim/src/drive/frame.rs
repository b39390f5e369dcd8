//! A recording → beamformed lines.

use std::sync::atomic::{AtomicUsize, Ordering};

use bonebeam::geometry::Active;
use ndarray::{Array2, Axis};

use crate::Result;
use crate::config::Beamform;
use crate::drive::beamform::beamform;
use crate::drive::delay::DelayStage;
use crate::files::{AlignedData, ChannelData, Lines};

/// How many beams are delayed at a time: a multiple of the lanes, and enough for all threads,
/// while the aligned samples of a large set stay within some hundred megabytes.
pub(crate) const BEAMS_AT_A_TIME: usize = 64;

/// The speed of sound that lines tell where neither the file nor the configuration does, m/s.
const DEFAULT_SOUND_SPEED: f64 = 1540.0;

/// Delays and beamforms channel data. `progress` hears the fraction done, from any thread.
///
/// # Errors
/// Parameters that do not fit the record; see [`DelayStage::new`] and [`beamform`].
pub fn beamform_channel_data(
    data: &ChannelData,
    parameters: &Beamform,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Lines> {
    let stage = DelayStage::new(data, parameters)?;
    let (beams, samples) = (stage.beam_x().len(), stage.samples());
    let done = AtomicUsize::new(0);
    let count = |n: usize| report(progress, &done, n, beams * samples);
    let mut z = Array2::zeros((beams, samples));
    for first in (0..beams).step_by(BEAMS_AT_A_TIME) {
        let chunk = first..beams.min(first + BEAMS_AT_A_TIME);
        let x = stage.delay(chunk.clone())?;
        let active = |beam: usize, sample: usize| stage.active(first + beam, sample);
        let core = parameters.parameters();
        let part = beamform(x.view(), active, core, parameters.covariance, count)?;
        z.slice_axis_mut(Axis(0), chunk.into()).assign(&part);
    }
    Ok(Lines {
        z,
        fs: parameters.output_rate,
        t0: stage.start(),
        beam_x: stage.beam_x().to_vec(),
        c: stage.sound_speed(),
    })
}

/// Beamforms aligned data with all elements active. Beams without positions are taken to lie
/// `beam_spacing` apart, centred on 0.
///
/// # Errors
/// Parameters that do not fit the record; see [`beamform`].
pub fn beamform_aligned_data(
    data: &AlignedData,
    parameters: &Beamform,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Lines> {
    let (beams, samples, elements) = data.x.dim();
    let all = Active {
        first: 0,
        count: elements,
    };
    let done = AtomicUsize::new(0);
    let count = |n: usize| report(progress, &done, n, beams * samples);
    let core = parameters.parameters();
    let z = beamform(
        data.x.view(),
        |_, _| all,
        core,
        parameters.covariance,
        count,
    )?;
    let centre = (beams - 1) as f64 / 2.0;
    let even = || {
        (0..beams)
            .map(|b| (b as f64 - centre) * parameters.beam_spacing)
            .collect()
    };
    Ok(Lines {
        z,
        fs: data.fs,
        t0: data.t0,
        beam_x: data.beam_x.clone().unwrap_or_else(even),
        c: parameters.sound_speed.unwrap_or(DEFAULT_SOUND_SPEED),
    })
}

fn report(progress: &(dyn Fn(f64) + Sync), done: &AtomicUsize, n: usize, of: usize) {
    let done = done.fetch_add(n, Ordering::Relaxed) + n;
    progress(done as f64 / of as f64);
}
