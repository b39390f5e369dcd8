//! A recording → beamformed lines.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use bonebeam::beamform::{CoherenceSums, Parameters};
use bonebeam::geometry::{Active, Axis as Depths};
use bonebeam::simd::InstructionSet;
use ndarray::{Array2, ArrayViewMut2, Axis};
use num_complex::Complex;

use super::beamform::{Plan, Tile};
use super::delay::{DelayStage, other_kind};
use super::short_lag;
use crate::config::Beamform;
use crate::{Error, Result};
use bonebeam_files::{AlignedData, BeamformedLines, ChannelData, FrameSamples, Recording};

/// Default speed of sound of lines, m/s.
///
/// It is used if neither the file nor the configuration gives one.
pub const DEFAULT_SOUND_SPEED: f64 = 1540.0;

/// Beamforming of a recording's frames, with tables and memory made once.
pub struct RecordingFrames<'a> {
    plan: Plan,
    of: Of<'a>,
    parameters: &'a Beamform,
    /// All sub-lines of a frame as beamformed, if they are not the output.
    all: Mutex<Array2<Complex<f32>>>,
}

enum Of<'a> {
    /// Ranges of lines beamformed together, with their tiles.
    Channel(Box<DelayStage<'a>>, Vec<(Range<usize>, Vec<Tile>)>),
    /// Aligned data, or lines, which are the output.
    Aligned,
}

impl<'a> RecordingFrames<'a> {
    /// Prepares for the frames of a recording, which itself need not hold them.
    ///
    /// # Errors
    /// Parameters that do not fit the record; see [`DelayStage::new`] and [`Plan::new`].
    pub fn new(recording: &'a Recording, parameters: &'a Beamform) -> Result<Self> {
        match recording {
            Recording::Channel(data) => Self::of_channel_data(data, parameters),
            Recording::Aligned(data) => Self::of_aligned_data(data, parameters),
            Recording::Lines(_) => Ok(RecordingFrames {
                plan: plan(parameters.parameters(), 1)?,
                all: Mutex::new(Array2::zeros((0, 0))),
                of: Of::Aligned,
                parameters,
            }),
        }
    }

    /// As [`RecordingFrames::new`], for channel data.
    ///
    /// # Errors
    /// As [`RecordingFrames::new`].
    pub fn of_channel_data(data: &'a ChannelData, parameters: &'a Beamform) -> Result<Self> {
        Self::of_part(data, parameters, [0, 1], InstructionSet::detect())
    }

    /// As [`RecordingFrames::of_channel_data`], for part `k` of `n` of the lines.
    ///
    /// Its output has only [`RecordingFrames::own_lines`]. Parts together are the whole frame, bit for bit, by any `set`.
    ///
    /// # Errors
    /// As [`RecordingFrames::new`].
    pub fn of_part(
        data: &'a ChannelData,
        parameters: &'a Beamform,
        [k, n]: [usize; 2],
        set: InstructionSet,
    ) -> Result<Self> {
        let stage = DelayStage::new(data, parameters)?.with_instruction_set(set);
        let (lines, samples) = (stage.rays().len(), stage.samples());
        let own = lines * k / n..lines * (k + 1) / n;
        let adaptive = parameters.adaptive_samples(&stage.depths())?;
        let active = |line: usize, sample: usize| stage.active(line, sample);
        let widest = (0..lines).map(|line| active(line, samples - 1).count).max();
        let core = Parameters {
            sub_lines: stage.sub_lines(),
            ..parameters.parameters()
        };
        let plan = Plan::new(set, core, widest.unwrap_or(0))?.within(adaptive);
        let plan = plan.steered(&stage.scan()?, own.clone())?;
        let passes = stage.passes().map(|pass| {
            let lines = pass.start.max(own.start)..pass.end.min(own.end);
            let shape = (samples, stage.elements());
            Ok((lines.clone(), plan.tiles_of_lines(lines, shape, &active)?))
        });
        let passes = passes.filter(|pass| !matches!(pass, Ok((lines, _)) if lines.is_empty()));
        let passes = passes.collect::<Result<_>>()?;
        Ok(RecordingFrames {
            plan,
            all: Mutex::new(match stage.puts_out_beamformed() {
                false => Array2::zeros((own.len() * stage.sub_lines(), stage.line_samples())),
                true => Array2::zeros((0, 0)),
            }),
            of: Of::Channel(Box::new(stage), passes),
            parameters,
        })
    }

    /// As [`RecordingFrames::new`], for aligned data.
    ///
    /// All elements are active at every depth. Lines have only the computed samples of a depth step.
    ///
    /// # Errors
    /// As [`RecordingFrames::new`].
    pub fn of_aligned_data(data: &AlignedData, parameters: &'a Beamform) -> Result<Self> {
        let (.., samples, elements) = data.x.dim();
        let c = parameters.sound_speed.unwrap_or(DEFAULT_SOUND_SPEED);
        let adaptive = parameters.adaptive_samples(&Depths {
            first: c * data.t0 / 2.0,
            step: c / data.fs / 2.0,
            count: samples,
        })?;
        Ok(RecordingFrames {
            plan: plan(parameters.parameters(), elements)?.within(adaptive),
            all: Mutex::new(Array2::zeros((0, 0))),
            of: Of::Aligned,
            parameters,
        })
    }

    /// The delay stage of channel data.
    pub fn stage(&self) -> Option<&DelayStage<'a>> {
        match &self.of {
            Of::Channel(stage, _) => Some(stage),
            Of::Aligned => None,
        }
    }

    /// The output lines that are beamformed: all, or those of a part.
    pub fn own_lines(&self) -> Range<usize> {
        let Of::Channel(stage, passes) = &self.of else {
            return 0..0;
        };
        let first = passes.first().map_or(0, |(lines, _)| lines.start);
        let end = passes.last().map_or(0, |(lines, _)| lines.end);
        let outputs = stage.all_rays().len() / stage.rays().len().max(1);
        first * outputs..end * outputs
    }

    /// The parameters.
    pub(crate) fn parameters(&self) -> &Beamform {
        self.parameters
    }

    /// Beamforms one frame of channel data of this shape into `z` [beam, sample].
    ///
    /// The frame can be outside the recording. Lines are [`RecordingFrames::own_lines`] of [`DelayStage::all_rays`]. `progress`
    /// receives the fraction done, from any thread.
    ///
    /// # Errors
    /// Errors of the core: see [`Plan::run`].
    pub fn frame(
        &self,
        frame: FrameSamples<'_>,
        progress: &(dyn Fn(f64) + Sync),
        z: ArrayViewMut2<'_, Complex<f32>>,
    ) -> Result<()> {
        self.frame_with(frame, progress, z, None)
    }

    /// [`RecordingFrames::frame`] with the sums for the coherence of its beams, [beam, sample].
    fn frame_with(
        &self,
        frame: FrameSamples<'_>,
        progress: &(dyn Fn(f64) + Sync),
        mut z: ArrayViewMut2<'_, Complex<f32>>,
        mut sums: Option<&mut [CoherenceSums]>,
    ) -> Result<()> {
        let Of::Channel(stage, passes) = &self.of else {
            return Err(other_kind());
        };
        let done = AtomicUsize::new(0);
        let count = |n: usize| report(progress, &done, n, z_len(stage));
        let mut all = self.all.lock().unwrap_or_else(PoisonError::into_inner);
        // Coherence is that of every sample, whatever the depth step.
        let beamformer = match sums {
            Some(_) => Parameters::DEFAULT,
            None => self.parameters.parameters(),
        };
        for (lines, tiles) in passes {
            let mut out = match stage.puts_out_beamformed() {
                false => all.view_mut(),
                true => z.view_mut(),
            };
            stage.source(frame, lines.clone(), beamformer, &mut |source| {
                let sums = sums.as_deref_mut();
                self.plan
                    .run_source(tiles, source, &count, out.view_mut(), sums)
            })?;
        }
        match stage.puts_out_beamformed() {
            false => stage.pool(all.view(), z),
            true => Ok(()),
        }
    }

    /// Lines of some frames of a recording of this shape.
    ///
    /// The recording can be another part of the same file.
    ///
    /// # Errors
    /// [`Error::Usage`] for frames that do not exist; as [`RecordingFrames::frame`].
    pub fn lines(
        &self,
        recording: &Recording,
        frames: Range<usize>,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BeamformedLines>> {
        match recording {
            Recording::Channel(data) => {
                let (start, count) = (frames.start, frames.len() as f64);
                let one = |index: usize| {
                    let scaled = |part: f64| progress(((index - start) as f64 + part) / count);
                    let frame = self.of_frame(data, index, &scaled, false);
                    frame.map(|(lines, _)| lines)
                };
                frames.map(one).collect()
            }
            Recording::Aligned(data) => self.of_aligned(data, frames, progress),
            Recording::Lines(lines) => {
                let held = lines.z.dim().0;
                let one = |index| match index < held {
                    true => Ok(lines.frame(index)),
                    false => Err(no_frame(index, held)),
                };
                frames.map(one).collect()
            }
        }
    }

    /// Lines of a frame, and of channel data their short-lag coherence.
    ///
    /// The samples are aligned once for both. The coherence has the bits of `coherence::of_frame`.
    ///
    /// # Errors
    /// As [`RecordingFrames::lines`].
    pub fn lines_and_coherence(
        &self,
        recording: &Recording,
        frame: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<(BeamformedLines, Option<Array2<f32>>)> {
        if let Recording::Channel(data) = recording {
            return self.of_frame(data, frame, progress, true);
        }
        let mut lines = self.lines(recording, frame..frame + 1, progress)?;
        Ok((lines.remove(0), None))
    }

    fn of_frame(
        &self,
        data: &ChannelData,
        index: usize,
        progress: &(dyn Fn(f64) + Sync),
        with_coherence: bool,
    ) -> Result<(BeamformedLines, Option<Array2<f32>>)> {
        let stage = self.stage().ok_or_else(other_kind)?;
        let frame = data.samples.frame(index);
        let frame = frame.ok_or_else(|| no_frame(index, data.samples.frames()))?;
        let mut z = Array2::zeros((stage.all_rays().len(), stage.samples()));
        let mut sums = with_coherence.then(|| vec![[0.0; 2]; z_len(stage)]);
        self.frame_with(frame, progress, z.view_mut(), sums.as_deref_mut())?;
        let coherence = sums.map(|sums| short_lag::of_sums(stage, &sums));
        Ok((stage.lines(z), coherence))
    }

    fn of_aligned(
        &self,
        data: &AlignedData,
        frames: Range<usize>,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BeamformedLines>> {
        let (held, beams, samples, elements) = data.x.dim();
        let all = Active::new(0, elements);
        let done = AtomicUsize::new(0);
        let of = frames.len() * beams * samples;
        let count = |n: usize| report(progress, &done, n, of);
        let spacing = self.parameters.beam_spacing;
        let beam_x = data.beam_x.clone();
        let beam_x = beam_x.unwrap_or_else(|| even_beams(beams, spacing));
        let lines = frames.map(|index| {
            if index >= held {
                return Err(no_frame(index, held));
            }
            let x = data.x.index_axis(Axis(0), index);
            let z = self.plan.run(x, &|_, _| all, &count)?;
            // The carrier for the interpolation is unknown.
            let fs = data.fs / self.parameters.depth_step() as f64;
            let c = self.parameters.sound_speed.unwrap_or(DEFAULT_SOUND_SPEED);
            let axis = [fs, data.t0, c];
            Ok(BeamformedLines::straight(z, beam_x.clone(), axis))
        });
        lines.collect()
    }
}

/// Beamforms the first frame of channel data.
///
/// `progress` receives the fraction done, from any thread.
///
/// # Errors
/// As [`RecordingFrames::new`] and [`RecordingFrames::frame`].
pub fn beamform_channel_data(
    data: &ChannelData,
    parameters: &Beamform,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<BeamformedLines> {
    let frames = RecordingFrames::of_channel_data(data, parameters)?;
    let (lines, _) = frames.of_frame(data, 0, progress, false)?;
    Ok(lines)
}

fn plan(parameters: Parameters, largest: usize) -> Result<Plan> {
    Plan::new(InstructionSet::detect(), parameters, largest)
}

fn z_len(stage: &DelayStage<'_>) -> usize {
    stage.rays().len() * stage.samples()
}

pub(crate) fn no_frame(index: usize, frames: usize) -> Error {
    Error::Usage(format!(
        "there is no frame {index}; expected 0 to {}",
        frames.saturating_sub(1)
    ))
}

/// Positions of beams that are `spacing` apart, centred on 0, m.
pub fn even_beams(beams: usize, spacing: f64) -> Vec<f64> {
    let centre = beams.saturating_sub(1) as f64 / 2.0;
    (0..beams).map(|b| (b as f64 - centre) * spacing).collect()
}

fn report(progress: &(dyn Fn(f64) + Sync), done: &AtomicUsize, n: usize, of: usize) {
    let done = done.fetch_add(n, Ordering::Relaxed) + n;
    progress(done as f64 / of as f64);
}
