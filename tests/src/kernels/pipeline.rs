//! A line of a pipeline: delay stage and beamformer in blocks.

use std::vec;
use std::vec::Vec;

use bonebeam::beamform::Parameters;
use bonebeam::pipeline::Block;
use bonebeam::prelude::stages::*;

use super::beamform;
use crate::draw::Draw;
use crate::kernel::Kernel;

/// One line.
#[derive(Clone, Debug)]
pub struct Line {
    /// The scan, of [`LINES`] lines.
    pub scan: ScanParameters<'static>,
    /// The interpolation of I/Q; `None` for RF.
    pub iq: Option<IqInterpolation>,
    /// The beamformer.
    pub beamformer: Parameters,
    /// The depths that are adaptive.
    pub gate: Option<DepthGate>,
    /// The line's index.
    pub line: usize,
    /// The transmits, each with the same record.
    pub transmits: Vec<TransmitLaw<'static>>,
    /// `[element][sample]`; the real parts are the RF.
    pub samples: Vec<Complex<f32>>,
    /// Samples of a block in the second way.
    pub block: usize,
}

/// The way by the delay stage and then the beamformer.
const STAGES: usize = usize::MAX;

/// Lines of the scan.
pub const LINES: usize = 3;

impl Line {
    /// The input of I/Q; `None` for RF.
    pub fn input(&self) -> Option<IqInput> {
        let interpolation = self.iq?;
        Some(IqInput {
            demodulation_frequency: 5e6,
            interpolation: Some(interpolation),
        })
    }

    /// Calls `work` with the record of I/Q, in counts for fixed point.
    ///
    /// # Errors
    /// Those of the core and of `work`.
    pub fn with_iq<T>(
        &self,
        work: impl FnOnce(&Record<'_>) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let part = |part: f32| (part * 300.0) as i16;
        let counts = self.samples.iter().map(|x| [part(x.re), part(x.im)]);
        let counts: Vec<_> = counts.collect();
        let samples = match self.iq {
            Some(IqInterpolation::LinearFixed) => IqSamples::Counts(&counts, 0.25),
            _ => IqSamples::Float(&self.samples),
        };
        let elements = self.scan.array.elements();
        work(&Record::iq(samples, IqLayout::Planar, elements)?)
    }

    /// Calls `work` with the record of RF.
    ///
    /// # Errors
    /// Those of the core and of `work`.
    pub fn with_rf<T>(
        &self,
        work: impl FnOnce(&Record<'_>) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let rf: Vec<f32> = self.samples.iter().map(|x| x.re).collect();
        work(&Record::new(&rf, self.scan.array.elements())?)
    }

    /// The transmits of any line, each with the same record.
    pub fn transmits<'r, R>(
        &self,
        record: &'r R,
    ) -> impl Iterator<Item = (Transmit<'r>, &'r R)> + Clone {
        let laws = self.transmits.iter();
        laws.map(move |&law| (Transmit::new(law, 0.0), record))
    }

    /// Calls `work` with the pipeline and the record.
    fn with<W: Work>(&self, work: W) -> Result<W::Output, Error> {
        let scan = Scan::new(self.scan)?;
        match self.input() {
            Some(input) => self.with_iq(|record| {
                let pipeline = LinePipeline::of_iq(scan, input, self.beamformer)?;
                work.run(self, &self.gated(pipeline)?, record)
            }),
            None => self.with_rf(|record| {
                let pipeline = LinePipeline::new(scan, self.beamformer)?;
                work.run(self, &self.gated(pipeline)?, record)
            }),
        }
    }

    /// The pipeline of frames, with the gate.
    pub fn gated_frame<'a, D: Stage>(
        &self,
        pipeline: Pipeline<'a, D>,
        directions: &'a mut Vec<Complex<f32>>,
    ) -> Result<Pipeline<'a, D>, Error> {
        directions.resize(pipeline.lines().directions_len(), Complex::ZERO);
        pipeline.lines().directions(directions)?;
        let pipeline = pipeline.with_directions(directions)?;
        match self.gate {
            None => Ok(pipeline),
            Some(gate) => pipeline.with_gate(gate),
        }
    }

    fn gated<'a, D: Stage>(
        &self,
        pipeline: LinePipeline<'a, D>,
    ) -> Result<LinePipeline<'a, D>, Error> {
        match self.gate {
            None => Ok(pipeline),
            Some(gate) => pipeline.with_gate(gate),
        }
    }

    /// Samples of a line.
    pub fn samples(&self) -> usize {
        Scan::new(self.scan).map_or(0, |scan| scan.samples())
    }
}

/// What is done with a pipeline of either input.
trait Work {
    type Output;

    fn run<'r, D: Stage>(
        self,
        line: &Line,
        pipeline: &LinePipeline<'_, D>,
        record: &'r Record<'r>,
    ) -> Result<Self::Output, Error>;
}

/// The parameters are valid.
struct Checked;

impl Work for Checked {
    type Output = ();

    fn run<'r, D: Stage>(
        self,
        _: &Line,
        _: &LinePipeline<'_, D>,
        _: &'r Record<'r>,
    ) -> Result<(), Error> {
        Ok(())
    }
}

/// The memory of a pipeline over lanes, in blocks.
struct Needs {
    lanes: usize,
    way: usize,
}

impl Work for Needs {
    type Output = [Need; 2];

    fn run<'r, D: Stage>(
        self,
        line: &Line,
        pipeline: &LinePipeline<'_, D>,
        _: &'r Record<'r>,
    ) -> Result<[Need; 2], Error> {
        let sizes = pipeline.beamformer().sizes(line.scan.array.elements());
        let numbers = match self.way {
            0 | STAGES => pipeline.need(self.lanes, usize::MAX),
            block => pipeline.need(self.lanes, block),
        };
        Ok([numbers, sizes.need()])
    }
}

/// The line itself.
struct Compute<'a, V> {
    way: usize,
    zero: V,
    numbers: Scratch<'a>,
    vectors: Scratch<'a, V>,
    z: &'a mut [Complex<f32>],
}

impl<V: Vector> Work for Compute<'_, V> {
    type Output = ();

    fn run<'r, D: Stage>(
        self,
        line: &Line,
        pipeline: &LinePipeline<'_, D>,
        record: &'r Record<'r>,
    ) -> Result<(), Error> {
        let sizes = pipeline.beamformer().sizes(line.scan.array.elements());
        let mut workspace = Workspace::new(self.zero, sizes, self.vectors)?;
        let transmits = line.transmits(record);
        let sub_lines = line.beamformer.sub_lines;
        if self.way == STAGES {
            let (scan, Scratch { real, complex }) = (pipeline.scan(), self.numbers);
            let block = Block::of_line(scan, line.line);
            let x = pipeline.align(self.zero, block, transmits, real, complex)?;
            let active = |sample| scan.active(line.line, sample);
            return pipeline.beamformer().line_within(
                &mut workspace,
                x,
                active,
                pipeline.adaptive(),
                self.z,
            );
        }
        if sub_lines == 1 {
            return pipeline.line(line.line, transmits, self.numbers, &mut workspace, self.z);
        }
        let mut directions =
            vec![Complex::ZERO; Steering::need(pipeline.scan().samples(), sub_lines).complex];
        let steering = Steering::new(pipeline.scan(), line.line, sub_lines, &mut directions)?;
        pipeline.sub_lines(
            line.line,
            transmits,
            self.numbers,
            &mut workspace,
            (steering, self.z),
        )
    }
}

impl Kernel for Line {
    type Number = Complex<f32>;

    // With less memory, blocks are shorter.
    const EXACT: bool = false;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let (elements, record_samples) = (draw.size(10, 32), draw.size(80, 300));
        let mut at = |usual| draw.number(false, usual);
        let (pitch, sound_speed, start) = (at([1e-5, 1e-3]), at([300.0, 4000.0]), at([0.0, 2e-3]));
        // Up to 60 samples at 20 MHz.
        let length = at([0.1, 60.0]) * sound_speed / 40e6;
        let scan = ScanParameters {
            array: Array::linear(elements, pitch),
            lines: Lines::Even(Axis::centred(LINES, pitch)),
            sound_speed,
            record_samples,
            start: Depth::Metres(start),
            end: Depth::Metres(start + length),
            f_number: at([0.5, 4.0]),
            min_elements: 1,
            ..ScanParameters::EXAMPLE
        };
        let from = at([0.0, 1.1]);
        let gate = [from, from + at([0.0, 0.5])].map(|share| start + share * length);
        let laws = [
            TransmitLaw::Focused,
            TransmitLaw::Plane {
                angle: at([-1.0, 1.0]),
            },
        ];
        let mut beamformer = beamform::parameters(draw, false);
        beamformer.temporal_half_window %= 12;
        beamformer.sub_lines = if draw.byte() < 64 { 4 } else { 1 };
        let interpolations = [
            IqInterpolation::Linear,
            IqInterpolation::Cubic,
            IqInterpolation::Sinc,
            IqInterpolation::LinearFixed,
        ];
        let mut line = Line {
            scan,
            iq: if draw.flag() {
                Some(draw.one_of(&interpolations))
            } else {
                None
            },
            beamformer: Parameters {
                covariance: draw.one_of(&[Covariance::Forward, Covariance::ForwardBackward]),
                ..beamformer
            },
            gate: draw.flag().then_some(DepthGate {
                from: gate[0],
                to: gate[1],
            }),
            line: draw.below(LINES),
            transmits: (0..1 + draw.below(2)).map(|_| draw.one_of(&laws)).collect(),
            samples: Vec::new(),
            block: 1 + draw.below(60),
        };
        // Parts of a line may be next to nothing, or everything very loud.
        let faint = draw.one_of(&[1.0, 1.0, 1e-18, 1e-21, 1e-30]);
        let after = draw.below(record_samples + 1);
        let parts = draw.record(2 * elements * record_samples);
        let pairs = parts.as_chunks::<2>().0.iter().enumerate();
        let scale = |n: usize| {
            if n % record_samples < after {
                1.0
            } else {
                faint
            }
        };
        line.samples = pairs
            .map(|(n, &[re, im])| Complex::new(re, im) * scale(n))
            .collect();
        line.with(Checked)?;
        Ok(line)
    }

    fn need(&self, lanes: usize, way: usize) -> [Need; 2] {
        self.with(Needs { lanes, way }).unwrap_or_default()
    }

    fn numbers(&self) -> usize {
        self.beamformer.line_samples(self.samples()) * self.beamformer.sub_lines
    }

    fn run<V: Vector>(
        &self,
        zero: V,
        way: usize,
        (numbers, vectors): (Scratch<'_>, Scratch<'_, V>),
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        self.with(Compute {
            way,
            zero,
            numbers,
            vectors,
            z,
        })
    }

    fn ways(&self) -> Vec<usize> {
        match self.beamformer.sub_lines {
            1 => vec![self.block, STAGES],
            _ => vec![self.block],
        }
    }
}
