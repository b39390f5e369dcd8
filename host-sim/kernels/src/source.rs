//! Input of lines: the records of a frame's transmits, and the core's pipeline.

use std::ops::Range;

use bonebeam::dispatch;
use bonebeam::pipeline::Block;
use bonebeam::prelude::stages::*;
use num_complex::Complex;
use rayon::prelude::*;

use crate::{Compounded, Result};

/// Source of the aligned samples of lines.
pub enum LineSource<'a> {
    /// RF.
    Rf(Recorded<'a, Delay>),
    /// I/Q.
    Iq(Recorded<'a, IqDelay>),
    /// RF of compounded transmits, each record upsampled once for some lines.
    Upsampled(Box<Compounded<'a>>),
}

/// The transmits of a frame.
pub struct Recorded<'a, D: Stage> {
    /// The pipeline of a line.
    pub pipeline: LinePipeline<'a, &'a D>,
    /// The transmits.
    pub transmits: &'a [Transmit<'a>],
    /// The record of each transmit.
    pub records: &'a [Record<'a>],
    /// Transmits of a line; its samples are their mean.
    pub of_line: &'a (dyn Fn(usize) -> Range<usize> + Sync),
}

impl<'a> LineSource<'a> {
    fn scan(&self) -> &Scan<'a> {
        match self {
            LineSource::Rf(recorded) => recorded.pipeline.scan(),
            LineSource::Iq(recorded) => recorded.pipeline.scan(),
            LineSource::Upsampled(compounded) => compounded.scan(),
        }
    }

    /// Lines, and output samples of each.
    pub fn shape(&self) -> (usize, usize) {
        (self.scan().lines(), self.scan().samples())
    }

    /// Elements of the array.
    pub fn elements(&self) -> usize {
        self.scan().elements()
    }

    /// A block of a line's aligned samples, `[sample, element]`, that fills `x`.
    ///
    /// It uses the vectors of `set`.
    pub fn align<'x>(
        &self,
        set: InstructionSet,
        block: Block,
        scratch: &mut Vec<f32>,
        x: &'x mut [Complex<f32>],
    ) -> Result<AlignedLine<'x>> {
        match self {
            LineSource::Rf(recorded) => recorded.align(set, block, scratch, x),
            LineSource::Iq(recorded) => recorded.align(set, block, scratch, x),
            LineSource::Upsampled(compounded) => compounded.align(set, block, scratch, x),
        }
    }

    /// Aligned samples of some lines, on all threads.
    ///
    /// `x` is `[line, sample, element]`, with every element that is active at any depth.
    pub fn align_lines(
        &self,
        set: InstructionSet,
        lines: Range<usize>,
        x: &mut [Complex<f32>],
    ) -> Result<()> {
        let scan = self.scan();
        x.par_chunks_exact_mut(scan.samples() * scan.elements())
            .zip(lines)
            .try_for_each_init(Vec::new, |scratch, (x, line)| {
                let block = Block::of_line(scan, line);
                self.align(set, block, scratch, x).map(drop)
            })
    }
}

impl<D: Stage> Recorded<'_, D> {
    fn align<'x>(
        &self,
        set: InstructionSet,
        block: Block,
        scratch: &mut Vec<f32>,
        x: &'x mut [Complex<f32>],
    ) -> Result<AlignedLine<'x>> {
        let pipeline = &self.pipeline;
        let samples = x.len() / pipeline.scan().elements();
        let own = (self.of_line)(block.line);
        let transmits = self.transmits[own.clone()].iter().copied();
        let transmits = transmits.zip(&self.records[own]);
        let line = dispatch!(set, zero => {
            let needed = pipeline.delay().need(zero.lanes().len(), samples).real;
            scratch.resize(scratch.len().max(needed), 0.0);
            pipeline.align(zero, block, transmits, scratch, x)
        });
        Ok(line?)
    }
}
