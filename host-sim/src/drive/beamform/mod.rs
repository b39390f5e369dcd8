//! Drives the core's beamformer over frames: as many runs at a time as there are lanes, on all
//! threads.

mod memory;
mod pieces;

use crate::{Error, Result};
use bonebeam::beamform::{AlignedLine, Beamformer, Parameters, Run};
use bonebeam::covariance::Covariance;
use bonebeam::geometry::Active;
use bonebeam::simd::InstructionSet;
use ndarray::{Array2, ArrayView3, Axis};
use num_complex::Complex;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard};

use memory::AnyMemory;
pub use memory::Memory;
pub(crate) use memory::Needs;
use pieces::{Piece, runs, stretches};

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
    Plan::new(set, parameters, covariance, largest)?.beamform(x, &runs, &progress)
}

/// Beamforming of many frames: threads and their memory, made once.
pub struct Plan {
    beamformer: Beamformer,
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
            pool,
            memory: memory.into_iter().collect::<Result<_>>()?,
        })
    }

    /// Beamforms a frame: see [`beamform()`].
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
        check_window(self.beamformer.parameters(), x.dim().1)?;
        let (beams, samples, _) = x.dim();
        self.beamform(x, &runs((beams, samples), active), &progress)
    }

    fn beamform(
        &self,
        x: ArrayView3<'_, Complex<f32>>,
        runs: &[Piece],
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Array2<Complex<f32>>> {
        let (beams, samples, elements) = x.dim();
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
        let pieces = stretches(
            runs,
            lanes,
            self.beamformer.parameters().temporal_half_window,
        );
        let outputs = self.threads(&lines, &pieces, progress)?;
        let mut z = vec![Complex::new(0.0, 0.0); beams * samples];
        let mut outputs = outputs.as_slice();
        for piece in &pieces {
            let (values, rest) = outputs.split_at(piece.samples);
            let first = piece.beam * samples + piece.first_sample;
            z[first..first + piece.samples].copy_from_slice(values);
            outputs = rest;
        }
        Ok(Array2::from_shape_vec((beams, samples), z).expect("a value a sample"))
    }

    fn memory(&self, thread: usize) -> MutexGuard<'_, Box<dyn AnyMemory>> {
        self.memory[thread].lock().expect("no thread has panicked")
    }

    /// Each thread takes the next group of pieces as soon as it is done with one.
    fn threads(
        &self,
        lines: &[AlignedLine<'_>],
        pieces: &[Piece],
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Outputs> {
        let lanes = self.memory(0).lanes();
        let groups: Vec<&[Piece]> = pieces
            .chunk_by(|a, b| a.active.count == b.active.count)
            .flat_map(|same| same.chunks(lanes))
            .collect();
        let next = AtomicUsize::new(0);
        let done = self.pool.broadcast(|thread| {
            let mut memory = self.memory(thread.index());
            let mut done = Vec::new();
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(&group) = groups.get(index) else {
                    return done;
                };
                let values = beamform_group(&self.beamformer, &mut **memory, lines, group);
                progress(group.iter().map(|piece| piece.samples).sum());
                done.push((index, values));
            }
        });
        let mut done: Vec<(usize, Result<Outputs>)> = done.into_iter().flatten().collect();
        done.sort_by_key(|(index, _)| *index);
        let mut outputs = Vec::new();
        for (_, group) in done {
            outputs.extend_from_slice(&group?);
        }
        Ok(outputs)
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

/// One group: a piece a lane.
fn beamform_group(
    beamformer: &Beamformer,
    memory: &mut dyn AnyMemory,
    lines: &[AlignedLine<'_>],
    group: &[Piece],
) -> Result<Outputs> {
    let runs: Vec<Run<'_>> = group
        .iter()
        .map(|piece| Run {
            line: lines[piece.beam],
            first_element: piece.active.first,
            first_sample: piece.first_sample,
        })
        .collect();
    let samples = group.iter().map(|piece| piece.samples).sum();
    let mut values = vec![Complex::new(0.0, 0.0); samples];
    let mut rest = values.as_mut_slice();
    let mut z: Vec<&mut [Complex<f32>]> = Vec::with_capacity(group.len());
    for piece in group {
        let (own, others) = rest.split_at_mut(piece.samples);
        z.push(own);
        rest = others;
    }
    memory.runs(beamformer, &runs, group[0].active.count, &mut z)?;
    Ok(values)
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

/// The pieces' samples, one piece after another.
type Outputs = Vec<Complex<f32>>;
