//! The core's beamformer in the sections: one beam per lane, one thread.

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
use ndarray::{Array2, Array3, ArrayView2};
use num_complex::Complex;
use std::hint::black_box;
use std::time::Duration;

use super::timing::{fastest, side_by_side};
use crate::Result;
use bonebeam_drive::beamform::{AnyMemory, memory};

/// A beamformer of lines whose elements are all active, one in each lane.
pub struct Core<'x> {
    beamformer: Beamformer,
    memory: Box<dyn AnyMemory>,
    elements: usize,
    segments: Vec<Segment<'x>>,
    directions: Vec<Complex<f32>>,
}

impl<'x> Core<'x> {
    /// A beamformer of `lines [beam, sample, element]`, in the lanes of `set`.
    ///
    /// Sub-lines have the directions of [`steered`].
    pub fn new(
        set: InstructionSet,
        parameters: Parameters,
        lines: &'x Array3<Complex<f32>>,
    ) -> Result<Self> {
        let beamformer = Beamformer::new(parameters)?;
        let (_, samples, elements) = lines.dim();
        let segment = |line: ArrayView2<'x, Complex<f32>>| {
            let line = line.to_slice().expect("a standard layout");
            Ok(Segment::new(AlignedLine::new(line, elements)?, 0, 0))
        };
        Ok(Core {
            beamformer,
            memory: memory(set, beamformer.sizes(elements))?,
            elements,
            segments: lines.outer_iter().map(segment).collect::<Result<_>>()?,
            directions: steered(samples, parameters.sub_lines),
        })
    }

    pub fn method(&self) -> Method {
        self.beamformer.parameters().method
    }

    /// Beamforms all lines into `z`, `[beam, sample]` or `[beam, sample and sub-line]`.
    pub fn run(&mut self, z: &mut Array2<Complex<f32>>) -> Result<()> {
        let (lanes, elements) = (self.memory.lanes(), self.elements);
        let sub_lines = self.beamformer.parameters().sub_lines;
        let steering = vec![Steering::of(&self.directions, sub_lines); lanes];
        let rows = z.outer_iter_mut();
        let mut rows: Vec<&mut [Complex<f32>]> = rows
            .map(|row| row.into_slice().expect("a standard layout"))
            .collect();
        for (segments, z) in self.segments.chunks(lanes).zip(rows.chunks_mut(lanes)) {
            let beamformer = &self.beamformer;
            if sub_lines > 1 {
                let lines = SteeredSegments::new(segments, &steering[..segments.len()]);
                self.memory.sub_lines(beamformer, lines, elements, z)?;
            } else {
                self.memory.segments(beamformer, segments, elements, z)?;
            }
        }
        Ok(())
    }

    /// Seconds of a run into `z`, the fastest within `budget`.
    pub fn seconds(&mut self, z: &mut Array2<Complex<f32>>, budget: Duration) -> Result<f64> {
        self.run(z)?;
        Ok(fastest(budget, || drop(black_box(self.run(z)))))
    }

    /// Seconds of a run into `z`, and of another beamformer's into `of_other`, in turn.
    pub fn beside(
        &mut self,
        other: &mut Core<'_>,
        [z, of_other]: [&mut Array2<Complex<f32>>; 2],
        budget: Duration,
    ) -> Result<[f64; 2]> {
        self.run(z)?;
        other.run(of_other)?;
        let mut ours = || drop(black_box(self.run(z)));
        let mut others = || drop(black_box(other.run(of_other)));
        Ok(side_by_side(budget, [&mut ours, &mut others]))
    }
}

/// Half of the phase from element to element of the outermost sub-lines, rad.
const OUTERMOST: f32 = 0.05;

/// Even directions of sub-lines, the same for all `samples`: `e^{js/2}` and `e^{−jφ_c}`, which is 1.
fn steered(samples: usize, sub_lines: usize) -> Vec<Complex<f32>> {
    let direction = |k: usize| {
        let part = (2 * k + 1) as f32 / sub_lines as f32 - 1.0;
        [
            Complex::from_polar(1.0, OUTERMOST * part),
            Complex::new(1.0, 0.0),
        ]
    };
    let of_sample = (0..sub_lines).flat_map(direction);
    let all = of_sample.cycle().take(2 * samples * sub_lines);
    all.collect()
}
