//! Maps of the coherence of the samples, beside the lines of a frame.

use bonebeam::beamform::{AlignedLine, Beamformer, Parameters, ShortLagCoherence, Sizes};
use bonebeam::geometry::{self, Active};
use bonebeam::memory::Scratch;
use bonebeam::pipeline::Block;
use bonebeam::simd::InstructionSet;
use ndarray::{Array2, Axis, Slice};
use num_complex::Complex;
use rayon::prelude::*;

use super::beamform::{check_window, memory};
use super::config::Beamform;
use super::delay::{DelayStage, other_kind};
use super::frame::{DEFAULT_SOUND_SPEED, RecordingFrames, no_frame};
use super::short_lag::{of_lines, short_lag};
use crate::Result;
use bonebeam_files::choice;
use bonebeam_files::{AlignedData, ChannelData, FrameSamples, Recording};

choice! {
    /// A measure of coherence.
    Measure = ShortLag {
        /// Short-lag coherence: how alike the echoes of neighbouring elements are, −1 to 1
        ShortLag = "short-lag",
        /// λ₁/tr R: the share of the largest eigenvalue of the covariance, 1/L to 1
        ///
        /// Subapertures, averaging and time window are those of the beamformer, without diagonal loading.
        LargestEigenvalue = "largest-eigenvalue",
    }
}

/// A measure with its parameters.
enum Kernel {
    ShortLag(ShortLagCoherence),
    LargestEigenvalue(Beamformer, Sizes),
}

impl Kernel {
    /// For lines of these samples, with up to `largest` active elements.
    fn new(
        measure: Measure,
        parameters: &Beamform,
        samples: &geometry::Axis,
        largest: usize,
    ) -> Result<Self> {
        if measure == Measure::ShortLag {
            return Ok(Kernel::ShortLag(short_lag(samples)));
        }
        let beamformer = Beamformer::new(Parameters {
            depth_step: 1,
            ..parameters.parameters()
        })?;
        check_window(beamformer.parameters(), samples.count)?;
        let sizes = beamformer.eigenvalue_sizes(largest);
        Ok(Kernel::LargestEigenvalue(beamformer, sizes))
    }

    /// The row of a line.
    fn line(
        &self,
        line: AlignedLine<'_>,
        active: impl Fn(usize) -> Active,
        row: &mut [f32],
    ) -> Result<()> {
        match self {
            Kernel::ShortLag(coherence) => {
                let mut real = vec![0.0; coherence.need().real];
                let scratch = Scratch::new(&mut real, &mut []);
                Ok(coherence.line(line, active, scratch, row)?)
            }
            Kernel::LargestEigenvalue(beamformer, sizes) => {
                let mut memory = memory(InstructionSet::detect(), *sizes)?;
                Ok(memory.eigenvalue_shares(beamformer, line, &active, row)?)
            }
        }
    }
}

/// The coherence of a frame of a recording.
///
/// The axes are [line, sample], those of the lines of `frames`. Sub-lines have the coherence of their beam.
///
/// # Errors
/// [`Error::Usage`](crate::Error::Usage) for a frame that does not exist, and for a time window longer than the record;
/// a sample that is not finite.
pub fn of_frame(
    frames: &RecordingFrames<'_>,
    recording: &Recording,
    frame: usize,
    measure: Measure,
) -> Result<Array2<f32>> {
    let parameters = frames.parameters();
    match (recording, frames.stage()) {
        (Recording::Channel(data), Some(stage)) => {
            let samples = data.samples.frame(frame);
            let samples = samples.ok_or_else(|| no_frame(frame, data.samples.frames()))?;
            let (lines, last) = (0..stage.rays().len(), stage.samples() - 1);
            let largest = lines.map(|line| stage.active(line, last).count).max();
            let largest = largest.unwrap_or(0);
            let kernel = Kernel::new(measure, parameters, &stage.depths(), largest)?;
            of_stage(stage, samples, &kernel)
        }
        (Recording::Lines(_), None) => {
            let needs = "coherence needs the samples of the elements; the file holds lines";
            Err(crate::Error::Data(needs.into()))
        }
        (Recording::Aligned(data), None) => of_aligned_data(data, frame, (measure, parameters)),
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
    let kernel = Kernel::ShortLag(short_lag(&stage.depths()));
    of_stage(stage, frame, &kernel)
}

fn of_stage(
    stage: &DelayStage<'_>,
    frame: FrameSamples<'_>,
    kernel: &Kernel,
) -> Result<Array2<f32>> {
    let (beams, samples, elements) = (stage.rays().len(), stage.samples(), stage.elements());
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
                    kernel.line(aligned, |n| stage.active(line, n), row)
                },
            )
        })?;
    }
    Ok(of_lines(stage, &map))
}

fn of_aligned_data(
    data: &AlignedData,
    frame: usize,
    (measure, parameters): (Measure, &Beamform),
) -> Result<Array2<f32>> {
    let (frames, beams, samples, elements) = data.x.dim();
    if frame >= frames {
        return Err(no_frame(frame, frames));
    }
    let c = parameters.sound_speed.unwrap_or(DEFAULT_SOUND_SPEED);
    let depths = geometry::Axis::new(0.0, c / data.fs / 2.0, samples);
    let kernel = Kernel::new(measure, parameters, &depths, elements)?;
    let x = data.x.index_axis(Axis(0), frame);
    let all = |_| Active::new(0, elements);
    let mut map: Array2<f32> = Array2::zeros((beams, samples));
    let rows = map.as_slice_mut().unwrap_or_default();
    let rows = rows.par_chunks_mut(samples.max(1)).enumerate();
    rows.try_for_each(|(beam, row)| {
        let x = x.index_axis(Axis(0), beam);
        let x = x.as_standard_layout();
        let line = AlignedLine::new(x.as_slice().unwrap_or_default(), elements)?;
        kernel.line(line, all, row)
    })?;
    // Lines have the computed samples alone.
    let step = parameters.depth_step().max(1) as isize;
    Ok(map
        .slice_axis(Axis(1), Slice::new(0, None, step))
        .to_owned())
}
