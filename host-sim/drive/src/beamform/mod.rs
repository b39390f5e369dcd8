//! Runs the core's beamformer over frames, on all threads.
//!
//! Each thread processes as many segments at a time as it has lanes.

mod work_items;

use crate::{Error, Result};
use bonebeam::beamform::{
    AlignedLine, Beamformer, CoherenceSums, Method, Parameters, Segment, ShortLagCoherence, Sizes,
    SteeredSegments,
};
use bonebeam::geometry::{Scan, Steering};
use bonebeam::simd::InstructionSet;
pub use bonebeam_kernels::memory::{AnyMemory, Memory, memory};
use bonebeam_kernels::source::LineSource;
use ndarray::{Array2, ArrayView3, ArrayViewMut2, Axis};
use num_complex::Complex;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

pub use work_items::Apertures;
pub(super) use work_items::Tile;
use work_items::{WorkItem, adaptive_segments, groups, largest, other_segments, tiles};

/// Bytes of aligned samples that a thread works on at a time.
pub(crate) const TILE: usize = 4 << 20;
/// Samples of a line in a tile, approximately.
const DEPTHS: usize = 256;
/// Tiles per thread, so that all threads stay busy to the end.
const TILES_A_THREAD: usize = 4;
const FEWEST: usize = 64;

/// Callback with the number of output samples just finished, from any thread.
pub type Finished<'a> = dyn Fn(usize) + Sync + 'a;

/// Beamforms every beam of `x` (`[beam, sample, element]`).
///
/// `active(beam, sample)` is the active set. Returns `z` as `[beam, computed sample]`, in the input's scale. The
/// result does not depend on the number of threads. For many frames, a range of depths, or a given instruction set,
/// use [`Plan`].
///
/// # Errors
/// As [`Plan::new`] and [`Plan::run`].
pub fn beamform(
    x: ArrayView3<'_, Complex<f32>>,
    active: &Apertures<'_>,
    parameters: Parameters,
    progress: &Finished<'_>,
) -> Result<Array2<Complex<f32>>> {
    let (beams, samples, _) = x.dim();
    check_window(&parameters, samples)?;
    let most = largest(beams, samples, active);
    Plan::new(InstructionSet::detect(), parameters, most)?.run(x, active, progress)
}

/// Beamforming of many frames, with the threads' memory allocated once.
///
/// It works on the threads of the rayon pool in which it is called.
pub struct Plan {
    set: InstructionSet,
    beamformer: Beamformer,
    /// Samples made by the beamformer; the others are DAS.
    adaptive: Range<usize>,
    das: Beamformer,
    sizes: Sizes,
    /// The lines that the output of records has.
    lines: Range<usize>,
    /// Directions of each line's sub-lines, if there are any.
    steering: Vec<Vec<Complex<f32>>>,
    lanes: usize,
    /// Workers that no thread uses.
    workers: Mutex<Vec<Worker>>,
}

/// Memory of a thread.
struct Worker {
    memory: Box<dyn AnyMemory>,
    scratch: Vec<f32>,
    aligned: Vec<Complex<f32>>,
    z: Vec<Complex<f32>>,
    sums: Vec<CoherenceSums>,
}

/// Output of the lines.
struct Output<'z> {
    /// Computed samples of a line.
    samples: usize,
    z: &'z mut [Complex<f32>],
    /// Sums of all samples of a line for its coherence, if they are wanted.
    sums: Option<(usize, &'z mut [CoherenceSums])>,
}

/// Input of the lines.
#[derive(Clone, Copy)]
enum Input<'a, 's> {
    /// Aligned samples in memory, by beam.
    Aligned(&'a [AlignedLine<'a>]),
    /// Records, aligned a tile at a time.
    Source(&'a LineSource<'s>),
}

impl Plan {
    /// A plan for frames whose beams have up to `largest` active elements.
    ///
    /// # Errors
    /// [`Error::Usage`] if the sizes need more memory than is allowed; [`Error::Core`] for parameters out of range.
    pub fn new(set: InstructionSet, parameters: Parameters, largest: usize) -> Result<Self> {
        let beamformer = Beamformer::new(parameters)?;
        let das = Beamformer::new(Parameters {
            method: Method::Das,
            temporal_half_window: 0,
            ..parameters
        })?;
        let sizes = beamformer.sizes(largest);
        let first = Worker::new(sizes, set)?;
        Ok(Plan {
            set,
            beamformer,
            adaptive: 0..usize::MAX,
            das,
            sizes,
            lines: 0..usize::MAX,
            steering: Vec::new(),
            lanes: first.memory.lanes(),
            workers: Mutex::new(vec![first]),
        })
    }

    /// The same plan; samples of every beam outside `adaptive` are DAS.
    pub fn within(self, adaptive: Range<usize>) -> Self {
        Plan { adaptive, ..self }
    }

    /// The same plan for some lines of a scan, and their sub-lines.
    ///
    /// [`Plan::run_source`] needs it if the parameters ask for sub-lines.
    ///
    /// # Errors
    /// None: the memory is of the length needed.
    pub(super) fn steered(self, scan: &Scan<'_>, lines: Range<usize>) -> Result<Self> {
        let count = self.sub_lines();
        if count == 1 {
            return Ok(Plan { lines, ..self });
        }
        let length = Steering::need(scan.samples(), count).complex;
        let of_line = |line| {
            let mut directions = vec![Complex::ZERO; length];
            Steering::new(scan, line, count, &mut directions)?;
            Ok(directions)
        };
        let steering = lines.clone().into_par_iter().map(of_line);
        Ok(Plan {
            steering: steering.collect::<Result<_>>()?,
            lines,
            ..self
        })
    }

    /// Number of sub-lines of a line.
    pub(super) fn sub_lines(&self) -> usize {
        self.beamformer.parameters().sub_lines
    }

    /// Beamforms a frame of aligned samples: see [`beamform()`].
    ///
    /// # Errors
    /// [`Error::Data`] naming beam, sample and element of a sample that is not finite; [`Error::Usage`] for a time
    /// window longer than the record; [`Error::Core`] if there are more active elements than planned.
    pub fn run(
        &self,
        x: ArrayView3<'_, Complex<f32>>,
        active: &Apertures<'_>,
        progress: &Finished<'_>,
    ) -> Result<Array2<Complex<f32>>> {
        let (beams, samples, _) = x.dim();
        let mut z = Array2::zeros((beams, self.beamformer.line_samples(samples)));
        self.run_into(x, active, progress, z.view_mut())?;
        Ok(z)
    }

    /// Beamforms into the caller's `z`, as `[beam, computed sample]`.
    ///
    /// # Errors
    /// As [`Plan::run`], and [`Error::Data`] if `z` has another order or shape. After an error, the content of `z`
    /// is undefined.
    pub fn run_into(
        &self,
        x: ArrayView3<'_, Complex<f32>>,
        active: &Apertures<'_>,
        progress: &Finished<'_>,
        z: ArrayViewMut2<'_, Complex<f32>>,
    ) -> Result<()> {
        let (beams, samples, elements) = x.dim();
        if self.sub_lines() > 1 {
            return Err(Error::Usage(
                "--sub-lines needs channel data; aligned data have no element positions".into(),
            ));
        }
        let x = x.as_standard_layout();
        let of_beam = |beam| {
            let line = x.index_axis(Axis(0), beam).to_slice();
            let line = line.expect("one beam of a standard layout is contiguous");
            AlignedLine::new(line, elements).map_err(|error| name_sample(error, beam, elements))
        };
        let lines: Vec<Result<_>> = (0..beams).into_par_iter().map(of_beam).collect();
        let computed = self.beamformer.line_samples(samples);
        let z = in_order(z, (beams, computed))?;
        let tiles = self.tiles(0..beams, samples, active, None)?;
        // The first bad beam is named, whichever thread found one first.
        let lines = lines.into_iter().collect::<Result<Vec<_>>>()?;
        let output = Output {
            samples: computed,
            z,
            sums: None,
        };
        self.work(&tiles, Input::Aligned(&lines), progress, output)
    }

    /// Beamforms the `tiles` of some lines from records into `z`.
    ///
    /// `z` is `[line, computed sample]` of the plan's lines, or of all their sub-lines. `sums`, if they are wanted, are
    /// `[line, sample]`; the source then aligns every sample.
    ///
    /// # Errors
    /// Errors of the core, and of [`Plan::run`] about `z`.
    pub(super) fn run_source(
        &self,
        tiles: &[Tile],
        source: &LineSource<'_>,
        progress: &Finished<'_>,
        z: ArrayViewMut2<'_, Complex<f32>>,
        sums: Option<&mut [CoherenceSums]>,
    ) -> Result<()> {
        let (lines, samples) = source.shape();
        let computed = self.beamformer.line_samples(samples);
        let lines = self.lines.end.min(lines) - self.lines.start;
        let output = Output {
            samples: computed,
            z: in_order(z, (lines * self.sub_lines(), computed))?,
            sums: sums.map(|sums| (samples, sums)),
        };
        self.work(tiles, Input::Source(source), progress, output)
    }

    /// Aligns the blocks of all tiles and does nothing else, to measure that part.
    pub(super) fn align(&self, tiles: &[Tile], source: &LineSource<'_>) -> Result<()> {
        tiles.iter().par_bridge().try_for_each(|tile| {
            let mut worker = self.worker()?;
            self.blocks(tile, source, &mut worker.scratch, &mut worker.aligned)?;
            locked(&self.workers).push(worker);
            Ok(())
        })
    }

    /// Tiles for the threads: the whole frame's work items, or those of some lines.
    ///
    /// Tiles of lines have up to `most` samples each; others are groups of work items.
    ///
    /// # Errors
    /// [`Error::Usage`] for a time window longer than the record.
    pub(super) fn tiles(
        &self,
        lines: Range<usize>,
        samples: usize,
        active: &Apertures<'_>,
        most: Option<usize>,
    ) -> Result<Vec<Tile>> {
        let parameters = self.beamformer.parameters();
        check_window(parameters, samples)?;
        let window = parameters.temporal_half_window;
        let adaptive = adaptive_segments(lines.clone(), samples, active, &self.adaptive, window);
        let others = other_segments(lines, samples, active, &self.adaptive);
        let of = |segments: &[WorkItem], by_das: bool, window: usize| {
            let tiles = tiles(segments, most, self.lanes, window).into_iter();
            tiles.map(move |tile| Tile { by_das, ..tile })
        };
        let adaptive = of(&adaptive, false, window);
        Ok(adaptive.chain(of(&others, true, 0)).collect())
    }

    /// Tiles of some lines of records, `(samples, elements)` each.
    ///
    /// A tile has at least as many lines as lanes, so that the lanes are full, and is deep enough for the margins
    /// of alignment.
    ///
    /// # Errors
    /// As [`Plan::tiles`].
    pub(super) fn tiles_of_lines(
        &self,
        lines: Range<usize>,
        (samples, elements): (usize, usize),
        active: &Apertures<'_>,
    ) -> Result<Vec<Tile>> {
        let fair = (lines.len() * samples).div_ceil(TILES_A_THREAD * rayon::current_num_threads());
        let fair = fair.max(self.lanes * FEWEST);
        let most = (TILE / (elements * size_of::<Complex<f32>>())).min(fair);
        let at_a_time = (most / DEPTHS).next_multiple_of(self.lanes).max(self.lanes);
        let mut tiles = Vec::new();
        for first in lines.clone().step_by(at_a_time) {
            let lines = first..lines.end.min(first + at_a_time);
            tiles.extend(self.tiles(lines, samples, active, Some(most))?);
        }
        Ok(tiles)
    }

    /// Runs `work` on all tiles; each thread takes the next tile when it is free.
    fn work(
        &self,
        tiles: &[Tile],
        input: Input<'_, '_>,
        progress: &Finished<'_>,
        output: Output<'_>,
    ) -> Result<()> {
        let with_sums = output.sums.is_some();
        let output = Mutex::new(output);
        let done = |tile: &Tile| -> Result<()> {
            let mut worker = self.worker()?;
            let done = self.tile(&mut worker, tile, input, with_sums);
            if done.is_ok() {
                let count = self.put(tile, &worker, &mut locked(&output));
                progress(count);
            }
            locked(&self.workers).push(worker);
            done
        };
        let failed = tiles.iter().enumerate().par_bridge();
        let failed = failed.filter_map(|(index, tile)| Some((index, done(tile).err()?)));
        // The first of them: which threads there were does not matter.
        let first = failed.min_by_key(|(index, _)| *index);
        first.map_or(Ok(()), |(_, error)| Err(error))
    }

    fn worker(&self) -> Result<Worker> {
        let idle = locked(&self.workers).pop();
        idle.map_or_else(|| Worker::new(self.sizes, self.set), Ok)
    }

    /// The blocks of a tile, aligned.
    fn blocks<'x>(
        &self,
        tile: &Tile,
        source: &LineSource<'_>,
        scratch: &mut Vec<f32>,
        aligned: &'x mut Vec<Complex<f32>>,
    ) -> Result<Vec<AlignedLine<'x>>> {
        let elements = source.elements();
        aligned.resize(aligned.len().max(tile.buffered() * elements), Complex::ZERO);
        let mut rest = &mut aligned[..];
        let blocks = tile.blocks.iter().map(|(block, samples)| {
            let (own, behind) = std::mem::take(&mut rest).split_at_mut(samples * elements);
            rest = behind;
            source.align(self.set, *block, scratch, own)
        });
        blocks.collect()
    }

    /// The outputs of a tile, item after item, and the sums for their coherence.
    fn tile(
        &self,
        worker: &mut Worker,
        tile: &Tile,
        input: Input<'_, '_>,
        with_sums: bool,
    ) -> Result<()> {
        let beamformer = match tile.by_das {
            true => &self.das,
            false => &self.beamformer,
        };
        let Worker {
            memory,
            scratch,
            aligned,
            z,
            sums,
        } = worker;
        let blocks = match input {
            Input::Aligned(_) => Vec::new(),
            Input::Source(source) => self.blocks(tile, source, scratch, aligned)?,
        };
        let line = |item: &WorkItem| match input {
            Input::Aligned(lines) => lines[item.beam],
            Input::Source(_) => blocks[tile.block_of(item)],
        };
        sums.clear();
        for item in tile.items.iter().filter(|_| with_sums) {
            let first = sums.len();
            sums.resize(first + item.samples, [0.0; 2]);
            let own = &mut sums[first..];
            ShortLagCoherence::sums(line(item), item.first_sample, item.active, own);
        }
        let sub_lines = self.sub_lines();
        let outputs = tile.items.iter().map(|item| self.outputs(item).len());
        let numbers = outputs.sum::<usize>() * sub_lines;
        z.resize(z.len().max(numbers), Complex::ZERO);
        let mut rest = &mut z[..];
        for group in groups(&tile.items, self.lanes) {
            let mut out = Vec::with_capacity(group.len());
            let mut segments = Vec::with_capacity(group.len());
            for item in group {
                let (own, behind) = rest.split_at_mut(self.outputs(item).len() * sub_lines);
                out.push(own);
                rest = behind;
                let (element, sample) = (item.active.first, item.first_sample);
                segments.push(Segment::new(line(item), element, sample));
            }
            let active = group[0].active.count;
            if sub_lines == 1 {
                memory.segments(beamformer, &segments, active, &mut out)?;
                continue;
            }
            let steering = |item: &WorkItem| {
                Steering::of(&self.steering[item.beam - self.lines.start], sub_lines)
            };
            let steering: Vec<_> = group.iter().map(steering).collect();
            let lines = SteeredSegments::new(&segments, &steering);
            memory.sub_lines(beamformer, lines, active, &mut out)?;
        }
        Ok(())
    }

    /// The indices of a work item's outputs among those of its line.
    fn outputs(&self, item: &WorkItem) -> Range<usize> {
        let before = |sample| self.beamformer.line_samples(sample);
        before(item.first_sample)..before(item.first_sample + item.samples)
    }

    /// Copies a tile's outputs into the lines; returns the count per line.
    ///
    /// Samples that come with a segment above the requested ones are left out.
    fn put(&self, tile: &Tile, worker: &Worker, output: &mut Output<'_>) -> usize {
        let Output { samples, z, sums } = output;
        if let Some((samples, sums)) = sums {
            let mut rest = &worker.sums[..];
            for item in &tile.items {
                let (own, behind) = rest.split_at(item.samples);
                let first = (item.beam - self.lines.start) * *samples + item.first_sample;
                sums[first..first + own.len()].copy_from_slice(own);
                rest = behind;
            }
        }
        let (mut from, mut count) = (0, 0);
        for item in &tile.items {
            let above = self.adaptive.start.saturating_sub(item.first_sample);
            let above = usize::from(!tile.by_das) * above.min(item.samples);
            let sub_lines = self.sub_lines();
            let of_item = self.outputs(item);
            let first = self.beamformer.line_samples(item.first_sample + above);
            let own = from + first - of_item.start..from + of_item.len();
            let own = &worker.z[own.start * sub_lines..own.end * sub_lines];
            for sub_line in 0..sub_lines {
                let line = (item.beam - self.lines.start) * sub_lines + sub_line;
                let first = line * *samples + first;
                let own = own.iter().skip(sub_line).step_by(sub_lines);
                for (z, &own) in z[first..].iter_mut().zip(own) {
                    *z = own;
                }
            }
            from += of_item.len();
            count += item.samples - above;
        }
        count
    }
}

impl Worker {
    fn new(sizes: Sizes, set: InstructionSet) -> Result<Self> {
        Ok(Worker {
            memory: memory(set, sizes)?,
            scratch: Vec::new(),
            aligned: Vec::new(),
            z: Vec::new(),
            sums: Vec::new(),
        })
    }
}

/// Locks the mutex, also after a panic of another thread.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Checks that the lines have the shape, row by row.
fn in_order(
    z: ArrayViewMut2<'_, Complex<f32>>,
    (beams, samples): (usize, usize),
) -> Result<&mut [Complex<f32>]> {
    let shape = z.dim();
    let z = z.into_slice().filter(|_| shape == (beams, samples));
    z.ok_or_else(|| {
        Error::Data(format!(
            "the lines have shape {shape:?}; expected ({beams}, {samples}), row by row"
        ))
    })
}

/// Checks that the time window is not longer than the record.
pub(super) fn check_window(parameters: &Parameters, samples: usize) -> Result<()> {
    let temporal_half_window = parameters.temporal_half_window;
    if temporal_half_window < samples {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "temporal_half_window (K) is {temporal_half_window}, but the record has only {samples} samples; give at most {}",
        samples.saturating_sub(1)
    )))
}

/// Names a non-finite sample by beam, sample and element.
fn name_sample(error: bonebeam::Error, beam: usize, elements: usize) -> Error {
    match error {
        bonebeam::Error::NonFinite { index, .. } => Error::Data(format!(
            "aligned sample [beam {beam}, sample {}, element {}] is NaN or infinite",
            index / elements,
            index % elements
        )),
        other => Error::Core(other),
    }
}
