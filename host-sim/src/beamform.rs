//! Drives the core's beamformer over a frame: as many runs at a time as there are lanes, on all
//! threads.

use crate::instruction_set::{InstructionSet, OverLanes};
use crate::{Error, Result};
use bonebeam::beamform::{Beamformer, DelayedLine, Method, Parameters, Run, Workspace};
use bonebeam::channel::aperture::Active;
use bonebeam::covariance::{Averaging, Forward, ForwardBackward};
use bonebeam::vector::Vector;
use clap::ValueEnum;
use ndarray::{Array2, ArrayView3, Axis};
use num_complex::Complex;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Active elements that fit.
pub const MAX_ELEMENTS: usize = 256;

/// The longest subarray that fits.
pub const MAX_SUBARRAY: usize = 128;

/// The largest temporal half-window `K` that fits.
pub const MAX_TEMPORAL: usize = 31;

/// Which covariance is in use (Eq. 2 or 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Covariance {
    /// `R` of Eq. 2, as in the paper's figures.
    Forward,
    /// `R_FB` of Eq. 3, the product's default.
    #[default]
    ForwardBackward,
}

/// Stack of a worker, bytes: a workspace of up to 80 MB is made there before it moves to the heap.
/// Only what is touched takes memory.
const WORKER_STACK: usize = 256 << 20;

/// A run of one beam's samples with one active set.
#[derive(Clone, Copy)]
struct Piece {
    beam: usize,
    first_sample: usize,
    samples: usize,
    active: Active,
}

/// Beamforms every beam of `x` (`[beam, sample, element]`) with the active set `active(beam,
/// sample)`; returns `z` as `[beam, sample]`, in the input's scale.
///
/// `progress` is called from any thread with the number of output samples just finished. The
/// result does not depend on the number of threads.
///
/// # Errors
/// [`Error::Data`] naming beam, sample and element of a sample that is not finite; [`Error::Usage`]
/// where a size is beyond what is compiled in; [`Error::Core`] for parameters out of range.
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
    let beamformer = Beamformer::new(parameters)?;
    let (beams, samples, elements) = x.dim();
    if parameters.temporal >= samples {
        return Err(Error::Usage(format!(
            "temporal (K) is {}, but the record has only {samples} samples: give at most {}",
            parameters.temporal,
            samples.saturating_sub(1)
        )));
    }
    let x = x.as_standard_layout();
    let lines: Vec<Result<DelayedLine<'_>>> = (0..beams)
        .into_par_iter()
        .map(|beam| {
            let line = x.index_axis(Axis(0), beam);
            let line = line
                .to_slice()
                .expect("one beam of a standard layout is contiguous");
            DelayedLine::new(line, elements).map_err(|error| name_sample(error, beam, elements))
        })
        .collect();
    // The first bad beam is named, whichever thread found one first.
    let lines = lines.into_iter().collect::<Result<Vec<_>>>()?;
    let pieces_of = |beam: usize| {
        let runs = bonebeam::beamform::constant_runs(samples, |sample| active(beam, sample));
        let piece = |(first_sample, samples, active)| Piece {
            beam,
            first_sample,
            samples,
            active,
        };
        runs.map(piece).collect::<Vec<_>>()
    };
    let mut pieces: Vec<Piece> = (0..beams)
        .into_par_iter()
        .flat_map_iter(pieces_of)
        .collect();
    // Lanes share the number of active elements; alike lengths waste least, and the lanes that are
    // left over waste least on the shortest. The longest work comes first, so that threads end alike.
    pieces.par_sort_by_key(|piece| Reverse((piece.active.count, piece.samples)));
    let frame = Frame {
        beamformer,
        covariance,
        lines: &lines,
        pieces: &pieces,
        progress: &progress,
    };
    let outputs = set.dispatch(frame)?;
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

/// A non-finite sample by beam, sample and element.
fn name_sample(error: bonebeam::Error, beam: usize, elements: usize) -> Error {
    match error {
        bonebeam::Error::NonFinite { index, .. } => Error::Data(format!(
            "delayed sample [beam {beam}, sample {}, element {}] is NaN or infinite",
            index / elements,
            index % elements
        )),
        other => Error::Core(other),
    }
}

/// Everything that a frame's beamforming needs.
struct Frame<'a, P> {
    beamformer: Beamformer,
    covariance: Covariance,
    lines: &'a [DelayedLine<'a>],
    pieces: &'a [Piece],
    progress: &'a P,
}

/// The pieces' samples, one piece after another.
type Outputs = Vec<Complex<f32>>;

/// Rows of a workspace for windows of up to `2·temporal + 1` samples, whichever the covariance.
const fn window_rows(subarray: usize, temporal: usize) -> usize {
    let (forward, both) = (
        Forward::window_rows(subarray, temporal),
        ForwardBackward::window_rows(subarray, temporal),
    );
    if forward > both { forward } else { both }
}

impl<P: Fn(usize) + Sync> OverLanes for Frame<'_, P> {
    type Output = Result<Outputs>;

    /// Picks the smallest capacities that fit, as a thread's workspace is made for each frame.
    fn run<V: Vector>(self, zero: V) -> Result<Outputs> {
        const SMALL: usize = window_rows(64, 2);
        const MEDIUM: usize = window_rows(64, 10);
        const LARGE: usize = window_rows(MAX_SUBARRAY, MAX_TEMPORAL);
        let largest = self.pieces.first().map_or(0, |piece| piece.active.count);
        if largest > MAX_ELEMENTS {
            return Err(Error::Usage(format!(
                "{largest} active elements, more than the {MAX_ELEMENTS} that fit"
            )));
        }
        let parameters = self.beamformer.parameters();
        let adaptive = parameters.method != Method::Das;
        let subarray = if adaptive {
            self.beamformer.subarray(largest)
        } else {
            1
        };
        let temporal = if adaptive { parameters.temporal } else { 0 };
        match (subarray, temporal) {
            (..=64, ..=2) => self.average::<V, 64, SMALL>(zero),
            (..=64, ..=10) => self.average::<V, 64, MEDIUM>(zero),
            (..=MAX_SUBARRAY, ..=MAX_TEMPORAL) => self.average::<V, MAX_SUBARRAY, LARGE>(zero),
            (..=MAX_SUBARRAY, _) => Err(Error::Usage(format!(
                "temporal (K) is {temporal}, more than the {MAX_TEMPORAL} that fit"
            ))),
            _ => Err(Error::Usage(format!(
                "the subarray has {subarray} elements, more than the {MAX_SUBARRAY} that fit"
            ))),
        }
    }
}

impl<P: Fn(usize) + Sync> Frame<'_, P> {
    fn average<V: Vector, const L: usize, const ROWS: usize>(&self, zero: V) -> Result<Outputs> {
        match self.covariance {
            Covariance::Forward => self.threads::<Forward, V, L, ROWS>(zero),
            Covariance::ForwardBackward => self.threads::<ForwardBackward, V, L, ROWS>(zero),
        }
    }

    fn threads<A, V, const L: usize, const ROWS: usize>(&self, zero: V) -> Result<Outputs>
    where
        A: Averaging<V>,
        V: Vector,
    {
        let groups: Vec<&[Piece]> = self
            .pieces
            .chunk_by(|a, b| a.active.count == b.active.count)
            .flat_map(|same| same.chunks(V::LANES))
            .collect();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(rayon::current_num_threads())
            .stack_size(WORKER_STACK)
            .build()
            .map_err(|e| Error::Data(format!("cannot start the worker threads: {e}")))?;
        // One workspace a thread, which takes the next group as soon as it is done with one.
        let next = AtomicUsize::new(0);
        let work = || {
            let mut workspace = Box::new(Workspace::<A, V, MAX_ELEMENTS, L, ROWS>::over(zero));
            let mut done = Vec::new();
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(group) = groups.get(index) else {
                    return done;
                };
                done.push((index, self.group(&mut workspace, group)));
            }
        };
        let mut done: Vec<(usize, Result<Outputs>)> =
            pool.broadcast(|_| work()).into_iter().flatten().collect();
        done.sort_by_key(|(index, _)| *index);
        let mut outputs = Vec::new();
        for (_, group) in done {
            outputs.extend_from_slice(&group?);
        }
        Ok(outputs)
    }

    /// One group: a piece a lane.
    fn group<A, V, const L: usize, const ROWS: usize>(
        &self,
        workspace: &mut Workspace<A, V, MAX_ELEMENTS, L, ROWS>,
        group: &[Piece],
    ) -> Result<Outputs>
    where
        A: Averaging<V>,
        V: Vector,
    {
        let runs: Vec<Run<'_>> = group
            .iter()
            .map(|piece| Run {
                line: self.lines[piece.beam],
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
        self.beamformer
            .runs(workspace, &runs, group[0].active.count, &mut z)?;
        (self.progress)(samples);
        Ok(values)
    }
}
