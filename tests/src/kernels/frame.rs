//! Frames of a pipeline: lines, image, bone map and coherence.

use std::vec;
use std::vec::Vec;

use bonebeam::phase_symmetry::Kernels;
use bonebeam::pipeline::{Block, Frame as Core};
use bonebeam::prelude::stages::*;
use bonebeam::surface::grey;

use super::pipeline::{LINES, Line};
use crate::draw::Draw;
use crate::kernel::Kernel;

/// A frame whose lines have the same record.
#[derive(Clone, Debug)]
pub struct Frame {
    /// One of its lines.
    pub line: Line,
    /// The pooling of sub-lines.
    pub pooling: Pooling,
}

/// The way by lines of vectors.
const LANES: usize = 1;
/// The way in blocks.
const BLOCKS: usize = 2;
/// The way with the coherence of whole aligned lines.
const ALIGNED: usize = 3;

/// Rows and columns of the image.
pub const SIDE: usize = 64;

/// Runs a block with the pipeline and its record, by the kind of samples.
macro_rules! with_pipeline {
    ($frame:expr, $way:expr, ($pipeline:ident, $record:ident) => $body:expr) => {{
        let (line, parameters) = (&$frame.line, $frame.parameters($way));
        let directions = &mut Vec::new();
        match line.input() {
            Some(input) => line.with_iq(|$record| {
                let pipeline = Pipeline::of_iq(parameters, input)?;
                let $pipeline = &line.gated_frame(pipeline, directions)?;
                $body
            }),
            None => line.with_rf(|$record| {
                let $pipeline = &line.gated_frame(Pipeline::new(parameters)?, directions)?;
                $body
            }),
        }
    }};
}

impl Frame {
    /// The parameters of a way; the others by default.
    pub fn parameters(&self, way: usize) -> Parameters<'static> {
        Parameters {
            scan: self.line.scan,
            beamformer: self.line.beamformer,
            rows: SIDE,
            columns: SIDE,
            dynamic_range: 50.0,
            median: true,
            scales: &[0.125],
            threshold: 3.0,
            strip: 8,
            block: if way == BLOCKS {
                self.line.block
            } else {
                usize::MAX
            },
        }
    }

    fn coherence(&self) -> ShortLagCoherence {
        ShortLagCoherence {
            temporal_half_window: self.line.block.min(self.line.samples() - 1),
        }
    }

    /// Numbers of the lines, one after the other; the image, the map and the coherence follow.
    pub fn of_lines(&self) -> usize {
        2 * LINES * self.line.numbers()
    }

    fn need_of<D: Stage>(&self, pipeline: &Pipeline<'_, D>, lanes: usize, way: usize) -> [Need; 2] {
        let coherence = Need::real(pipeline.coherence_len(self.coherence()));
        if way != LANES {
            return [pipeline.need(1).and(coherence), Need::default()];
        }
        let strips = pipeline.phase_symmetry().sizes();
        let beamformer = pipeline.lines().beamformer();
        let vectors = Need::new(strips.gains_len(), strips.line_len());
        let numbers = Need::real(strips.strip_len() + strips.sums_len());
        [
            numbers.and(pipeline.need(lanes)).and(coherence),
            vectors.and(beamformer.sizes(self.line.scan.array.elements()).need()),
        ]
    }

    fn compute<'r, V: Vector, D: Stage>(
        &self,
        (zero, way): (V, usize),
        (pipeline, record): (&Pipeline<'_, D>, &'r Record<'r>),
        (mut numbers, mut vectors): (Scratch<'_>, Scratch<'_, V>),
        out: &mut [f32],
    ) -> Result<(), Error> {
        let coherence = numbers.take(Need::real(pipeline.coherence_len(self.coherence())))?;
        let (sizes, over) = (pipeline.phase_symmetry().sizes(), usize::from(way == LANES));
        let of_strips =
            vectors.take(Need::new(over * sizes.gains_len(), over * sizes.line_len()))?;
        let mut strips = StripSlices {
            strip: numbers.take(Need::real(over * sizes.strip_len()))?.real,
            sums: numbers.take(Need::real(over * sizes.sums_len()))?.real,
            line: of_strips.complex,
            gains: of_strips.real,
        };
        let frame = Core::new(pipeline, numbers)?.with_pooling(self.pooling);
        let mut frame = frame.with_coherence(self.coherence(), coherence.real)?;
        let (lines, rest) = out.split_at_mut(self.of_lines());
        let sizes = pipeline
            .lines()
            .beamformer()
            .sizes(self.line.scan.array.elements());
        let mut workspace = match way {
            LANES => Some(Workspace::new(zero, sizes, vectors)?),
            _ => None,
        };
        for (line, out) in lines.chunks_exact_mut(2 * self.line.numbers()).enumerate() {
            let transmits = self.line.transmits(record);
            let z = match &mut workspace {
                Some(workspace) => frame.line_over(workspace, line, transmits)?,
                None => frame.line(line, transmits)?,
            };
            let (pairs, _) = out.as_chunks_mut::<2>();
            pairs
                .iter_mut()
                .zip(z)
                .for_each(|(out, z)| *out = [z.re, z.im]);
        }
        let (image, rest) = rest.split_at_mut(SIDE * SIDE);
        image.copy_from_slice(frame.image()?);
        let (map, levels) = rest.split_at_mut(SIDE * SIDE);
        let (fft, gains) = (&LaneFft::new(), &LogGabor::fixed());
        map.copy_from_slice(match way {
            LANES => frame.bone_map_over(&Kernels::new(fft, gains), &mut strips, &mut |_| {})?,
            _ => frame.bone_map()?,
        });
        let coherence = frame.coherence().unwrap_or_default();
        levels
            .iter_mut()
            .zip(coherence)
            .for_each(|(out, level)| *out = f32::from(*level));
        Ok(())
    }

    /// The coherence of whole aligned lines, by the stages alone.
    fn aligned<'r, D: Stage>(
        &self,
        (pipeline, record): (&Pipeline<'_, D>, &'r Record<'r>),
    ) -> Result<Vec<f32>, Error> {
        let (lines, scan) = (pipeline.lines(), pipeline.lines().scan());
        let need = lines.need(1, usize::MAX);
        let mut scratch = vec![f32::NAN; need.real];
        let mut x = vec![Complex::ZERO; need.complex];
        let mut all = Vec::new();
        for line in 0..LINES {
            let (block, transmits) = (Block::of_line(scan, line), self.line.transmits(record));
            let x = lines.align(0.0f32, block, transmits, &mut scratch, &mut x)?;
            let real = &mut vec![f32::NAN; self.coherence().need().real];
            let memory = Scratch::new(real, &mut []);
            let mut shares = vec![f32::NAN; scan.samples()];
            let active = |sample| scan.active(line, sample);
            self.coherence().line(x, active, memory, &mut shares)?;
            shares.iter_mut().for_each(|share| *share *= 255.0);
            let mut levels = vec![0; shares.len()];
            grey(&shares, &mut levels)?;
            all.extend(levels.into_iter().map(f32::from));
        }
        Ok(all)
    }
}

impl Kernel for Frame {
    type Number = f32;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let pooling = draw.one_of(&[Pooling::Largest, Pooling::Rms]);
        let line = Line::draw(draw)?;
        let frame = Frame { line, pooling };
        with_pipeline!(frame, 0, (pipeline, _record) => Ok(pipeline.need(1)))?;
        Ok(frame)
    }

    fn need(&self, lanes: usize, way: usize) -> [Need; 2] {
        let need = with_pipeline!(self, way, (pipeline, _record) => {
            Ok(self.need_of(pipeline, lanes, way))
        });
        need.unwrap_or_default()
    }

    fn numbers(&self) -> usize {
        self.of_lines() + 2 * SIDE * SIDE + LINES * self.line.samples()
    }

    fn run<V: Vector>(
        &self,
        zero: V,
        way: usize,
        memory: (Scratch<'_>, Scratch<'_, V>),
        out: &mut [f32],
    ) -> Result<(), Error> {
        with_pipeline!(self, way, (pipeline, record) => {
            self.compute((zero, way), (pipeline, record), memory, out)
        })?;
        if way == ALIGNED {
            // At every sample, since a depth step leaves samples out.
            let mut whole = self.clone();
            let beamformer = &mut whole.line.beamformer;
            (beamformer.depth_step, beamformer.sub_lines) = (1, 1);
            let levels = with_pipeline!(whole, 0, (pipeline, record) => {
                self.aligned((pipeline, record))
            })?;
            let first = out.len() - levels.len();
            out[first..].copy_from_slice(&levels);
        }
        Ok(())
    }

    fn ways(&self) -> Vec<usize> {
        vec![LANES, BLOCKS, ALIGNED]
    }
}
