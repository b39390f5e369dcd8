//! Drives the core's beamformer over frames: as many runs at a time as there are lanes, on all
//! threads.

mod memory;
mod pieces;

use crate::{Error, Result};
use bonebeam::beamform::{AlignedLine, Beamformer, Method, Parameters, Run};
use bonebeam::covariance::Covariance;
use bonebeam::geometry::Active;
use bonebeam::simd::InstructionSet;
use ndarray::{Array2, ArrayView3, ArrayViewMut2, Axis};
use num_complex::Complex;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use memory::AnyMemory;
pub use memory::Memory;
pub use memory::Needs;
use pieces::{Piece, adaptive_runs, other_runs, runs, stretches};

/// Beamforms every beam of `x` (`[beam, sample, element]`) with the active set `active(beam,
/// sample)`; returns `z` as `[beam, sample]`, in the input's scale.
///
/// `progress` is called from any thread with the number of output samples just finished. The
/// result does not depend on the number of threads.
///
/// # Errors
/// [`Error::Data`] naming beam, sample and element of a sample that is not finite; [`Error::Usage`]
/// where the sizes take more memory than is allowed; [`Error::Core`] for parameters out of range.
pub fn beamform(
    x: ArrayView3<'_, Complex<f32>>,
    active: impl Fn(usize, usize) -> Active + Sync,
    parameters: Parameters,
    covariance: Covariance,
    progress: impl Fn(usize) + Sync,
) -> Result<Array2<Complex<f32>>> {
    let set = InstructionSet::detect();
    beamform_with(set, x, active, parameters, covariance, progress)
}

/// As [`beamform`] for the samples `adaptive` of every beam; the others are DAS of their active elements.
///
/// # Errors
/// As [`beamform`].
pub fn beamform_within(
    x: ArrayView3<'_, Complex<f32>>,
    active: impl Fn(usize, usize) -> Active + Sync,
    adaptive: Range<usize>,
    parameters: Parameters,
    covariance: Covariance,
    progress: impl Fn(usize) + Sync,
) -> Result<Array2<Complex<f32>>> {
    let (_, samples, elements) = x.dim();
    if adaptive == (0..samples) {
        return beamform(x, active, parameters, covariance, progress);
    }
    let set = InstructionSet::detect();
    let plan = Plan::new(set, parameters, covariance, elements)?;
    plan.within(adaptive)?.run(x, active, progress)
}

/// As [`beamform`], with an instruction set of choice: the result does not depend on it.
///
/// # Errors
/// As [`beamform`].
pub fn beamform_with(
    set: InstructionSet,
    x: ArrayView3<'_, Complex<f32>>,
    active: impl Fn(usize, usize) -> Active + Sync,
    parameters: Parameters,
    covariance: Covariance,
    progress: impl Fn(usize) + Sync,
) -> Result<Array2<Complex<f32>>> {
    check_window(&parameters, x.dim().1)?;
    let (beams, samples, _) = x.dim();
    let runs = runs((beams, samples), active);
    let largest = runs.first().map_or(0, |run| run.active.count);
    let plan = Plan::new(set, parameters, covariance, largest)?;
    let mut z = Array2::zeros((beams, samples));
    plan.beamform(&plan.beamformer, x, &runs, &progress, z.view_mut())?;
    Ok(z)
}

/// Beamforming of many frames: threads and their memory, made once.
pub struct Plan {
    beamformer: Beamformer,
    /// The samples that it makes, and DAS for the others; none where it makes all.
    gate: Option<(Range<usize>, Beamformer)>,
    pool: ThreadPool,
    /// One a thread.
    memory: Vec<Mutex<Box<dyn AnyMemory>>>,
}

impl Plan {
    /// For frames whose beams have up to `largest` active elements, on as many threads as the rayon
    /// pool has in which this is called.
    ///
    /// # Errors
    /// [`Error::Usage`] where the sizes take more memory than is allowed; [`Error::Core`] for parameters
    /// out of range.
    pub fn new(
        set: InstructionSet,
        parameters: Parameters,
        covariance: Covariance,
        largest: usize,
    ) -> Result<Self> {
        let beamformer = Beamformer::new(parameters)?;
        let needs = Needs {
            covariance,
            sizes: beamformer.sizes(largest),
        };
        let pool = ThreadPoolBuilder::new()
            .num_threads(rayon::current_num_threads())
            .build()
            .map_err(|e| Error::Data(format!("cannot start the worker threads: {e}")))?;
        let memory = pool.broadcast(|_| needs.memory(set).map(Mutex::new));
        Ok(Plan {
            beamformer,
            gate: None,
            pool,
            memory: memory.into_iter().collect::<Result<_>>()?,
        })
    }

    /// The same plan, whose beamformer makes the samples `adaptive` of every beam; the others are DAS of their
    /// active elements.
    ///
    /// # Errors
    /// None: DAS has no parameter out of range.
    pub fn within(mut self, adaptive: Range<usize>) -> Result<Self> {
        let das = Beamformer::new(Parameters {
            method: Method::Das,
            ..*self.beamformer.parameters()
        })?;
        self.gate = Some((adaptive, das));
        Ok(self)
    }

    /// Beamforms a frame: see [`beamform()`]. Behind a gate `progress` may hear of a few samples twice.
    ///
    /// # Errors
    /// [`Error::Data`] naming beam, sample and element of a sample that is not finite;
    /// [`Error::Core`] where there are more active elements than planned for.
    pub fn run(
        &self,
        x: ArrayView3<'_, Complex<f32>>,
        active: impl Fn(usize, usize) -> Active + Sync,
        progress: impl Fn(usize) + Sync,
    ) -> Result<Array2<Complex<f32>>> {
        let (beams, samples, _) = x.dim();
        let mut z = Array2::zeros((beams, samples));
        self.run_into(x, active, progress, z.view_mut())?;
        Ok(z)
    }

    /// The same into memory of the caller, `z` as `[beam, sample]`.
    ///
    /// # Errors
    /// As [`Plan::run`], and [`Error::Data`] where `z` is not in that order or of another shape. What is
    /// in `z` after one is not said.
    pub fn run_into(
        &self,
        x: ArrayView3<'_, Complex<f32>>,
        active: impl Fn(usize, usize) -> Active + Sync,
        progress: impl Fn(usize) + Sync,
        z: ArrayViewMut2<'_, Complex<f32>>,
    ) -> Result<()> {
        let parameters = self.beamformer.parameters();
        check_window(parameters, x.dim().1)?;
        let (beams, samples, _) = x.dim();
        let Some((within, das)) = &self.gate else {
            let runs = runs((beams, samples), active);
            return self.beamform(&self.beamformer, x, &runs, &progress, z);
        };
        let mut z = z;
        let window = parameters.temporal_half_window;
        let runs = adaptive_runs((beams, samples), &active, within, window);
        self.beamform(&self.beamformer, x, &runs, &progress, z.view_mut())?;
        let runs = other_runs((beams, samples), &active, within);
        self.beamform(das, x, &runs, &progress, z)
    }

    fn beamform(
        &self,
        beamformer: &Beamformer,
        x: ArrayView3<'_, Complex<f32>>,
        runs: &[Piece],
        progress: &(dyn Fn(usize) + Sync),
        z: ArrayViewMut2<'_, Complex<f32>>,
    ) -> Result<()> {
        let (beams, samples, elements) = x.dim();
        let shape = z.dim();
        let z = z.into_slice().filter(|_| shape == (beams, samples));
        let z = z.ok_or_else(|| {
            Error::Data(format!(
                "the lines have shape {shape:?}; expected ({beams}, {samples}), row by row"
            ))
        })?;
        let x = x.as_standard_layout();
        let lines: Vec<Result<AlignedLine<'_>>> = (0..beams)
            .into_par_iter()
            .map(|beam| {
                let line = x.index_axis(Axis(0), beam);
                let line = line
                    .to_slice()
                    .expect("one beam of a standard layout is contiguous");
                AlignedLine::new(line, elements).map_err(|error| name_sample(error, beam, elements))
            })
            .collect();
        // The first bad beam is named, whichever thread found one first.
        let lines = lines.into_iter().collect::<Result<Vec<_>>>()?;
        let lanes = self.memory(0).lanes();
        let pieces = stretches(runs, lanes, beamformer.parameters().temporal_half_window);
        let z = of_pieces(z, &pieces, samples);
        self.threads(beamformer, &lines, &pieces, progress, z)
    }

    fn memory(&self, thread: usize) -> MutexGuard<'_, Box<dyn AnyMemory>> {
        self.memory[thread].lock().expect("no thread has panicked")
    }

    /// Each thread takes the next group of pieces as soon as it is done with one; `z` is the memory of
    /// each piece.
    fn threads(
        &self,
        beamformer: &Beamformer,
        lines: &[AlignedLine<'_>],
        pieces: &[Piece],
        progress: &(dyn Fn(usize) + Sync),
        z: Vec<&mut [Complex<f32>]>,
    ) -> Result<()> {
        let lanes = self.memory(0).lanes();
        let mut z = z.into_iter();
        let groups = pieces
            .chunk_by(|a, b| a.active.count == b.active.count)
            .flat_map(|same| same.chunks(lanes))
            .map(|group| (group, z.by_ref().take(group.len()).collect()));
        let groups: Vec<Group<'_, '_>> = groups.collect();
        let groups = Mutex::new(groups.into_iter().enumerate());
        let failed = self.pool.broadcast(|thread| {
            let mut memory = self.memory(thread.index());
            loop {
                let next = groups.lock().unwrap_or_else(PoisonError::into_inner).next();
                let (index, (group, mut z)) = next?;
                let done = beamform_group(beamformer, &mut **memory, lines, group, &mut z);
                if let Err(error) = done {
                    return Some((index, error));
                }
                progress(group.iter().map(|piece| piece.samples).sum());
            }
        });
        // The first of them: which threads there were does not matter.
        let first = failed.into_iter().flatten().min_by_key(|(index, _)| *index);
        first.map_or(Ok(()), |(_, error)| Err(error))
    }
}

/// The time window is not beyond the record.
fn check_window(parameters: &Parameters, samples: usize) -> Result<()> {
    let temporal_half_window = parameters.temporal_half_window;
    if temporal_half_window < samples {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "temporal_half_window (K) is {temporal_half_window}, but the record has only {samples} samples: give at most {}",
        samples.saturating_sub(1)
    )))
}

/// Pieces of one number of active elements, at most one a lane, and where their outputs go.
type Group<'p, 'z> = (&'p [Piece], Vec<&'z mut [Complex<f32>]>);

/// The memory of each piece's outputs, of lines `z` [beam][sample] in which no sample is in two pieces.
fn of_pieces<'z>(
    mut z: &'z mut [Complex<f32>],
    pieces: &[Piece],
    samples: usize,
) -> Vec<&'z mut [Complex<f32>]> {
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_unstable_by_key(|&k| (pieces[k].beam, pieces[k].first_sample));
    let mut memory: Vec<&mut [Complex<f32>]> = pieces.iter().map(|_| &mut [][..]).collect();
    let mut first = 0;
    for k in order {
        let piece = pieces[k];
        let begin = piece.beam * samples + piece.first_sample;
        let (own, rest) = z[begin - first..].split_at_mut(piece.samples);
        memory[k] = own;
        z = rest;
        first = begin + piece.samples;
    }
    memory
}

/// One group: a piece a lane.
fn beamform_group(
    beamformer: &Beamformer,
    memory: &mut dyn AnyMemory,
    lines: &[AlignedLine<'_>],
    group: &[Piece],
    z: &mut [&mut [Complex<f32>]],
) -> Result<()> {
    let runs: Vec<Run<'_>> = group
        .iter()
        .map(|piece| Run {
            line: lines[piece.beam],
            first_element: piece.active.first,
            first_sample: piece.first_sample,
        })
        .collect();
    Ok(memory.runs(beamformer, &runs, group[0].active.count, z)?)
}

/// A non-finite sample by beam, sample and element.
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
