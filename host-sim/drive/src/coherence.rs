//! Maps of short-lag coherence, beside the lines of a frame.

use bonebeam::beamform::{AlignedLine, Parameters, ShortLagCoherence};
use bonebeam::geometry::{self, Active};
use bonebeam::memory::Scratch;
use bonebeam::pipeline::Block;
use bonebeam::simd::InstructionSet;
use ndarray::{Array2, Axis, Slice};
use num_complex::Complex;
use rayon::prelude::*;

use super::frame::{DEFAULT_SOUND_SPEED, RecordingFrames, no_frame, other_kind};
use super::{config::Beamform, delay::DelayStage};
use crate::Result;
use bonebeam_files::{AlignedData, ChannelData, FrameSamples, Recording};

/// Half the time window of the coherence, m of depth.
const HALF_WINDOW: f64 = 0.4e-3;

/// Short-lag coherence of a frame of a recording, −1 to 1.
///
/// The axes are [line, sample], those of the lines of `frames`. Sub-lines have the coherence of their beam.
///
/// # Errors
/// [`Error::Usage`](crate::Error::Usage) for a frame that does not exist; a sample that is not finite.
pub fn of_frame(
    frames: &RecordingFrames<'_>,
    recording: &Recording,
    frame: usize,
) -> Result<Array2<f32>> {
    match (recording, frames.stage()) {
        (Recording::Channel(data), Some(stage)) => {
            let samples = data.samples.frame(frame);
            let samples = samples.ok_or_else(|| no_frame(frame, data.samples.frames()))?;
            of_channel_data(stage, samples)
        }
        (Recording::Aligned(data), None) => of_aligned_data(data, frame, frames.parameters()),
        _ => Err(other_kind()),
    }
}

/// Short-lag coherence of the first frame of channel data, as [`of_frame`].
///
/// # Errors
/// Parameters that do not fit the record; see [`DelayStage::new`].
pub fn of_first_frame(data: &ChannelData, parameters: &Beamform) -> Result<Array2<f32>> {
    let frame = data.samples.frame(0).ok_or_else(|| no_frame(0, 0))?;
    of_channel_data(&DelayStage::new(data, parameters)?, frame)
}

/// Short-lag coherence of a frame of channel data, as [`of_frame`].
///
/// # Errors
/// A sample that is not finite, or a frame of another shape than the stage's.
pub fn of_channel_data(stage: &DelayStage<'_>, frame: FrameSamples<'_>) -> Result<Array2<f32>> {
    let (beams, samples, elements) = (stage.rays().len(), stage.samples(), stage.elements());
    let coherence = ShortLagCoherence::over(HALF_WINDOW, &stage.depths());
    let (scan, set) = (stage.scan()?, InstructionSet::detect());
    let mut map = Array2::zeros((beams, samples));
    for lines in stage.passes() {
        let part = &mut map.as_slice_mut().unwrap_or_default()[samples * lines.start..];
        stage.source(frame, lines.clone(), Parameters::DEFAULT, &mut |source| {
            let rows = part.par_chunks_mut(samples).zip(lines.clone());
            rows.try_for_each_init(
                || (Vec::new(), vec![Complex::ZERO; samples * elements]),
                |(scratch, x), (row, line)| {
                    let block = Block::of_line(&scan, line);
                    let aligned = source.align(set, block, scratch, x)?;
                    of_line(coherence, aligned, |n| stage.active(line, n), row)
                },
            )
        })?;
    }
    // Each beam's row for each of its lines.
    let each = stage.all_rays().len() / beams.max(1);
    let beam_of = |line: usize| line / each.max(1);
    Ok(Array2::from_shape_fn(
        (each * beams, samples),
        |(line, n)| map[[beam_of(line), n]],
    ))
}

fn of_aligned_data(data: &AlignedData, frame: usize, parameters: &Beamform) -> Result<Array2<f32>> {
    let (frames, beams, samples, elements) = data.x.dim();
    if frame >= frames {
        return Err(no_frame(frame, frames));
    }
    let c = parameters.sound_speed.unwrap_or(DEFAULT_SOUND_SPEED);
    let depths = geometry::Axis {
        first: 0.0,
        step: c / data.fs / 2.0,
        count: samples,
    };
    let coherence = ShortLagCoherence::over(HALF_WINDOW, &depths);
    let x = data.x.index_axis(Axis(0), frame);
    let all = |_| Active {
        first: 0,
        count: elements,
    };
    let mut map: Array2<f32> = Array2::zeros((beams, samples));
    let rows = map.as_slice_mut().unwrap_or_default();
    let rows = rows.par_chunks_mut(samples.max(1)).enumerate();
    rows.try_for_each(|(beam, row)| {
        let x = x.index_axis(Axis(0), beam);
        let x = x.as_standard_layout();
        let line = AlignedLine::new(x.as_slice().unwrap_or_default(), elements)?;
        of_line(coherence, line, all, row)
    })?;
    // Lines have the computed samples alone.
    let step = parameters.core.depth_step.max(1) as isize;
    Ok(map
        .slice_axis(Axis(1), Slice::new(0, None, step))
        .to_owned())
}

fn of_line(
    coherence: ShortLagCoherence,
    line: AlignedLine<'_>,
    active: impl Fn(usize) -> Active,
    row: &mut [f32],
) -> Result<()> {
    let mut real = vec![0.0; coherence.need().real];
    let scratch = Scratch {
        real: &mut real,
        complex: &mut [],
    };
    Ok(coherence.line(line, active, scratch, row)?)
}
