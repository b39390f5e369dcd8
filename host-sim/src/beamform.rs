//! Drives the core's beamformer over a frame: `W` lanes at a time, on all threads.

use crate::{Error, Result};
use bonebeam::beamform::{Beamformer, DelayedLine, Method, Parameters, Run, Workspace};
use bonebeam::channel::aperture::Active;
use bonebeam::covariance::{Averaging, Forward, ForwardBackward};
use clap::ValueEnum;
use ndarray::{Array2, ArrayView3, Axis};
use num_complex::Complex;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Lanes on the workstation: two AVX2 registers' worth; the bits are those of one lane.
const LANES: usize = 8;

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

/// Stack of a worker, bytes: a workspace of up to 70 MB is made there before it moves to the heap.
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
    let lines = (0..beams)
        .map(|beam| {
            let line = x.index_axis(Axis(0), beam);
            let line = line
                .to_slice()
                .expect("one beam of a standard layout is contiguous");
            DelayedLine::new(line, elements).map_err(|error| name_sample(error, beam, elements))
        })
        .collect::<Result<Vec<_>>>()?;
    let mut pieces = Vec::new();
    for beam in 0..beams {
        let runs = bonebeam::beamform::constant_runs(samples, |sample| active(beam, sample));
        pieces.extend(runs.map(|(first_sample, samples, active)| Piece {
            beam,
            first_sample,
            samples,
            active,
        }));
    }
    // Lanes share the number of active elements; alike lengths waste least.
    pieces.sort_by_key(|piece| (piece.active.count, piece.samples));
    let groups: Vec<&[Piece]> = pieces
        .chunk_by(|a, b| a.active.count == b.active.count)
        .flat_map(|same| same.chunks(LANES))
        .collect();
    let largest = pieces.last().map_or(0, |piece| piece.active.count);
    let frame = Frame {
        beamformer,
        lines: &lines,
        groups: &groups,
        progress: &progress,
    };
    let outputs = frame.dispatch(largest, covariance)?;
    let mut z = Array2::zeros((beams, samples));
    for (group, lanes) in groups.iter().zip(outputs) {
        for (piece, values) in group.iter().zip(lanes) {
            for (i, value) in values.into_iter().enumerate() {
                z[[piece.beam, piece.first_sample + i]] = value;
            }
        }
    }
    Ok(z)
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

struct Frame<'a, P> {
    beamformer: Beamformer,
    lines: &'a [DelayedLine<'a>],
    groups: &'a [&'a [Piece]],
    progress: &'a P,
}

type Outputs = Vec<Vec<Vec<Complex<f32>>>>;

impl<P: Fn(usize) + Sync> Frame<'_, P> {
    /// Picks the smaller of two capacities that fits. Memory that a run does not need is never
    /// touched, and each further capacity would cost a minute of compilation.
    fn dispatch(&self, largest: usize, covariance: Covariance) -> Result<Outputs> {
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
            (..=64, ..=10) => self.average::<64, 21>(covariance),
            (..=MAX_SUBARRAY, ..=MAX_TEMPORAL) => self.average::<MAX_SUBARRAY, 63>(covariance),
            (..=MAX_SUBARRAY, _) => Err(Error::Usage(format!(
                "temporal (K) is {temporal}, more than the {MAX_TEMPORAL} that fit"
            ))),
            _ => Err(Error::Usage(format!(
                "the subarray has {subarray} elements, more than the {MAX_SUBARRAY} that fit"
            ))),
        }
    }

    fn average<const L: usize, const SLOTS: usize>(
        &self,
        covariance: Covariance,
    ) -> Result<Outputs> {
        match covariance {
            Covariance::Forward => self.run::<Forward, L, SLOTS>(),
            Covariance::ForwardBackward => self.run::<ForwardBackward, L, SLOTS>(),
        }
    }

    fn run<A, const L: usize, const SLOTS: usize>(&self) -> Result<Outputs>
    where
        A: Averaging<LANES>,
        A::Scalar: Send,
    {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(rayon::current_num_threads())
            .stack_size(WORKER_STACK)
            .build()
            .map_err(|e| Error::Data(format!("cannot start the worker threads: {e}")))?;
        pool.install(|| {
            self.groups
                .par_iter()
                .map_init(
                    || Box::new(Workspace::<A, MAX_ELEMENTS, L, SLOTS, LANES>::new()),
                    |workspace, group| self.group(workspace, group),
                )
                .collect()
        })
    }

    /// One group: a piece a lane.
    fn group<A, const L: usize, const SLOTS: usize>(
        &self,
        workspace: &mut Workspace<A, MAX_ELEMENTS, L, SLOTS, LANES>,
        group: &[Piece],
    ) -> Result<Vec<Vec<Complex<f32>>>>
    where
        A: Averaging<LANES>,
    {
        let runs: [Run<'_>; LANES] = std::array::from_fn(|lane| {
            // Lanes without a piece repeat the first and put nothing out.
            let piece = group.get(lane).unwrap_or(&group[0]);
            Run {
                line: self.lines[piece.beam],
                first_element: piece.active.first,
                first_sample: piece.first_sample,
            }
        });
        let mut values: Vec<Vec<Complex<f32>>> = group
            .iter()
            .map(|piece| vec![Complex::new(0.0, 0.0); piece.samples])
            .collect();
        let mut rest = values.iter_mut();
        let mut z: [&mut [Complex<f32>]; LANES] =
            std::array::from_fn(|_| rest.next().map_or(&mut [][..], |lane| lane.as_mut_slice()));
        self.beamformer
            .runs(workspace, &runs, group[0].active.count, &mut z)?;
        (self.progress)(group.iter().map(|piece| piece.samples).sum());
        Ok(values)
    }
}
