//! The core's beamformer as the sections use it: a beam a lane, whole lines, one thread.

use bonebeam::beamform::{Beamformer, DelayedLine, Parameters, Run, Workspace};
use bonebeam::covariance::{Averaging, Forward, ForwardBackward};
use bonebeam::vector::Vector;
use ndarray::{Array2, Array3, Axis};
use num_complex::Complex;

use crate::Result;
use crate::beamform::{Covariance, MAX_ELEMENTS};
use crate::instruction_set::{InstructionSet, OverLanes};

/// The capacities that the host's drive has: what has another one is compiled once more.
const SUBARRAY: usize = 64;
const ROWS: usize = {
    let forward = Forward::window_rows(SUBARRAY, 10);
    let both = ForwardBackward::window_rows(SUBARRAY, 10);
    if forward > both { forward } else { both }
};

/// Beamforms all lines into `z [beam, sample]`.
pub type Core<'a> = dyn FnMut(&mut Array2<Complex<f32>>) -> Result<()> + 'a;

/// What gets a beamformer with its memory made; a trait object, since each kind of closure would be
/// compiled for every instruction set.
pub type Then<'a> = dyn FnMut(&mut Core<'_>) -> Result<()> + 'a;

/// Makes a beamformer of `lines [beam, sample, element]`, all elements active, over the lanes of
/// `set`, and hands it to `then`.
///
/// # Errors
/// What the core refuses, and the errors of `then`.
pub fn with_core(
    set: InstructionSet,
    parameters: Parameters,
    covariance: Covariance,
    lines: &Array3<Complex<f32>>,
    then: &mut Then<'_>,
) -> Result<()> {
    set.dispatch(Work {
        parameters,
        covariance,
        lines,
        then,
    })
}

struct Work<'a, 'b> {
    parameters: Parameters,
    covariance: Covariance,
    lines: &'a Array3<Complex<f32>>,
    then: &'a mut Then<'b>,
}

impl OverLanes for Work<'_, '_> {
    type Output = Result<()>;

    fn run<V: Vector>(self, zero: V) -> Result<()> {
        match self.covariance {
            Covariance::Forward => self.whole_lines::<Forward, V>(zero),
            Covariance::ForwardBackward => self.whole_lines::<ForwardBackward, V>(zero),
        }
    }
}

impl Work<'_, '_> {
    fn whole_lines<A: Averaging<V>, V: Vector>(self, zero: V) -> Result<()> {
        let beamformer = Beamformer::new(self.parameters)?;
        let mut workspace = Box::new(Workspace::<A, V, MAX_ELEMENTS, SUBARRAY, ROWS>::over(zero));
        let elements = self.lines.dim().2;
        let mut runs = Vec::new();
        for line in self.lines.axis_iter(Axis(0)) {
            let line = line.to_slice().expect("a standard layout");
            runs.push(Run {
                line: DelayedLine::new(line, elements)?,
                first_element: 0,
                first_sample: 0,
            });
        }
        (self.then)(&mut |z| {
            let mut rows: Vec<&mut [Complex<f32>]> = z
                .outer_iter_mut()
                .map(|row| row.into_slice().expect("a standard layout"))
                .collect();
            for (runs, z) in runs.chunks(V::LANES).zip(rows.chunks_mut(V::LANES)) {
                beamformer.runs(&mut workspace, runs, elements, z)?;
            }
            Ok(())
        })
    }
}
