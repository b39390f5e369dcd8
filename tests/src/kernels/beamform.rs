//! The beamformers: lines of one direction or several, by any method.

use std::vec;
use std::vec::Vec;

use bonebeam::beamform::{Parameter, Parameters, constant_segments};
use bonebeam::geometry::Lines as Positions;
use bonebeam::prelude::stages::*;
use core::ops::Range;

use crate::draw::Draw;
use crate::kernel::Kernel;

/// Lines whose apertures grow alike.
#[derive(Clone, Debug)]
pub struct Lines {
    /// The parameters of the beamformer.
    pub parameters: Parameters,
    /// Elements of the array.
    pub elements: usize,
    /// Samples `[sample][element]` of each line, and the first active element.
    pub lines: Vec<(Vec<Complex<f32>>, usize)>,
    /// The number of active elements at each sample of the longest line.
    pub counts: Vec<usize>,
    /// The sample from which the aperture is one element further.
    pub turn: usize,
    /// The samples that are adaptive; the others are DAS.
    pub within: Range<usize>,
    /// Samples that come at a time, in the last way.
    pub block: usize,
}

/// The way by segments over lanes.
const SEGMENTS: usize = usize::MAX;

/// Parameters of any values.
pub fn parameters(draw: &mut impl Draw, wild: bool) -> Parameters {
    let mut number = |row: &Parameter| match (wild, row.whole) {
        (true, _) => draw.number(true, [row.range.least, row.range.most]),
        (false, true) => draw.number(false, [row.range.least, 9.0]).floor(),
        (false, false) => draw.number(false, [row.range.least + 1e-3, 1.0]),
    };
    let mut values = Parameters::TABLE.map(|row| number(&row));
    if !wild && draw.flag() {
        values.copy_from_slice(&Parameters::DEFAULT.values());
    }
    let method = draw.one_of(&Method::EXAMPLES);
    let mut parameters = Parameters {
        method: match method.parameter() {
            Some(row) if draw.flag() => {
                let [least, most] = [row.range.least, if row.whole { 9.0 } else { 1.0 }];
                let argument = draw.number(wild, [least, most]);
                method.with_argument(if row.whole {
                    argument.floor()
                } else {
                    argument
                })
            }
            _ => method,
        },
        postfilter: draw.one_of(&Postfilter::EXAMPLES),
        apodization: draw.one_of(&Apodization::EXAMPLES),
        ..Parameters::DEFAULT
    };
    for (row, value) in Parameters::TABLE.iter().zip(values) {
        parameters.set(row.name, value).expect("a row's name");
    }
    parameters
}

/// Aligned samples that stress the arithmetic, `[sample][element]`.
pub fn snapshots(draw: &mut impl Draw, samples: usize, elements: usize) -> Vec<Complex<f32>> {
    let kind = draw.byte() % 16;
    let [turn, other] = [(); 2].map(|()| draw.number(false, [-3.2, 3.2]) as f32);
    let hot = draw.below(samples * elements);
    let loud = draw.below(samples + 1);
    let noise = draw.samples(2 * samples * elements);
    let turned = |angle: f32| Complex::new(angle.cos(), angle.sin());
    let wave = |angle: f32, element: usize| turned(angle * element as f32);
    let at = |index: usize| {
        let (n, m) = (index / elements, index % elements);
        let noise = Complex::new(noise[2 * index], noise[2 * index + 1]);
        let echo = if n < loud { 1.0 } else { 0.0 };
        match kind {
            0 => Complex::ZERO,
            1 => Complex::from(noise.re),
            2 => Complex::new(1.0, -1.0),
            3 => wave(turn, m),
            4 => wave(turn, m) + wave(other, m) * 0.5,
            5 => wave(turn, m) + wave(-turn, m),
            6 => wave(core::f32::consts::PI, m),
            7 if index == hot => Complex::new(3e30, -2e30),
            7 => Complex::ZERO,
            8 => noise * echo,
            9 => noise * if n < loud { 1.0 } else { 1e-3 },
            10 => noise * if n < loud { 1.0 } else { 1e-20 },
            11 => Complex::new(f32::MAX, -f32::MAX),
            12 => wave(turn, m) * 10f32.powf(m as f32 / -6.0),
            13 => wave(turn * (m + n) as f32, m) * (1 + n) as f32,
            _ => noise,
        }
    };
    let finite = |part: f32| if part.is_finite() { part } else { 1.0 };
    (0..samples * elements)
        .map(at)
        .map(|x| Complex::new(finite(x.re), finite(x.im)))
        .collect()
}

impl Lines {
    /// Samples of a line.
    pub fn samples(&self, line: usize) -> usize {
        self.lines[line].0.len() / self.elements
    }

    /// The active elements of a line's sample.
    pub fn active(&self, line: usize, sample: usize) -> Active {
        Active::new(
            self.lines[line].1 + usize::from(sample >= self.turn),
            self.counts[sample],
        )
    }

    /// The directions of a line's sub-lines, in their memory.
    ///
    /// # Errors
    /// The core's.
    pub fn directions(&self, line: usize) -> Result<Vec<Complex<f32>>, Error> {
        let (samples, elements) = (self.counts.len(), self.elements);
        let scan = Scan::new(ScanParameters {
            array: Array::linear(elements, 0.3e-3),
            lines: Positions::Even(Axis::centred(elements.max(2), 0.3e-3)),
            record_samples: 4096,
            start: Depth::Seconds(6e-6),
            end: Depth::Seconds(6e-6 + (samples - 1) as f64 / 20e6),
            ..ScanParameters::EXAMPLE
        })?;
        let sub_lines = self.parameters.sub_lines;
        let mut memory = vec![Complex::ZERO; Steering::need(scan.samples(), sub_lines).complex];
        Steering::new(&scan, line % scan.lines(), sub_lines, &mut memory)?;
        Ok(memory)
    }

    /// Numbers of a line's result.
    fn outputs(&self, line: usize) -> usize {
        self.parameters.line_samples(self.samples(line)) * self.parameters.sub_lines
    }

    /// The result cut into that of each line.
    pub fn cut<'z, T>(&self, mut z: &'z mut [T]) -> Vec<&'z mut [T]> {
        let lines = 0..self.lines.len();
        let of_line = |line| z.split_off_mut(..self.outputs(line));
        lines.map_while(of_line).collect()
    }

    /// The samples of a line.
    pub(super) fn aligned(&self, line: usize) -> Result<AlignedLine<'_>, Error> {
        AlignedLine::new(&self.lines[line].0, self.elements)
    }

    fn of_way<V: Vector>(
        &self,
        zero: V,
        way: usize,
        memory: Scratch<'_, V>,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let beamformer = Beamformer::new(self.parameters)?;
        let mut workspace = Workspace::new(zero, self.sizes(), memory)?;
        let mut z = self.cut(z);
        let lines = 0..self.lines.len();
        let directions: Vec<_> = lines
            .clone()
            .map(|line| self.directions(line))
            .collect::<Result<_, _>>()?;
        let steering: Vec<_> = directions
            .iter()
            .map(|of| Steering::of(of, self.parameters.sub_lines))
            .collect();
        if way == SEGMENTS {
            let lines: Vec<usize> = lines.collect();
            let groups = lines
                .chunks(V::LANES)
                .zip(z.chunks_mut(V::LANES))
                .zip(steering.chunks(V::LANES));
            for ((lines, z), steering) in groups {
                self.segments(&mut workspace, lines, steering, z)?;
            }
            return Ok(());
        }
        for line in lines {
            let (x, active, z) = (self.aligned(line)?, |n| self.active(line, n), &mut *z[line]);
            let samples = self.samples(line);
            let within = || self.within.clone();
            match (way, self.parameters.sub_lines) {
                (0, 1) if within() == (0..self.counts.len()) => {
                    beamformer.line(&mut workspace, x, active, z)?
                }
                (0, 1) => beamformer.line_within(&mut workspace, x, active, within(), z)?,
                (0, _) => beamformer.sub_lines(&mut workspace, (x, steering[line]), active, z)?,
                (block, _) => {
                    let all = &self.lines[line].0;
                    let parts = all.iter().map(|x| x.re.abs().max(x.im.abs()));
                    let largest = parts.fold(0.0, f32::max);
                    let (mut done, half_window) = (0, self.parameters.temporal_half_window);
                    for end in (block..samples + block).step_by(block) {
                        let (first, end) = (done - half_window.min(done), end.min(samples));
                        let x = &all[first * self.elements..end * self.elements];
                        let x = AlignedLine::new(x, self.elements)?.of_line(first, samples)?;
                        let x = x.of_largest(largest)?;
                        done = beamformer.partial_line(
                            &mut workspace,
                            x,
                            done,
                            (active, within()),
                            z,
                        )?;
                        assert!(
                            done <= end && end <= done + 3 * half_window,
                            "the rest of {done} at {end}"
                        );
                    }
                    assert_eq!(done, samples);
                }
            }
        }
        Ok(())
    }

    /// A line for each lane, by segments of constant aperture.
    fn segments<V: Vector>(
        &self,
        workspace: &mut Workspace<'_, V>,
        lines: &[usize],
        steering: &[Steering<'_>],
        z: &mut [&mut [Complex<f32>]],
    ) -> Result<(), Error> {
        let beamformer = Beamformer::new(self.parameters)?;
        for (first, count, set) in
            constant_segments(self.counts.len(), |n| self.active(lines[0], n))
        {
            let mut segments = Vec::new();
            for &line in lines {
                let first_sample = first.min(self.samples(line));
                let first_element = self.active(line, first).first;
                segments.push(Segment::new(
                    self.aligned(line)?,
                    first_element,
                    first_sample,
                ));
            }
            let mut out: Vec<_> = Vec::new();
            for (&line, z) in lines.iter().zip(&mut *z) {
                let outputs = |n: usize| {
                    self.parameters.line_samples(n.min(self.samples(line)))
                        * self.parameters.sub_lines
                };
                out.push(&mut z[outputs(first)..outputs(first + count)]);
            }
            match self.parameters.sub_lines {
                1 => beamformer.segments(workspace, &segments, set.count, &mut out)?,
                _ => {
                    let lines = SteeredSegments::new(&segments, steering);
                    beamformer.sub_line_segments(workspace, lines, set.count, &mut out)?;
                }
            }
        }
        Ok(())
    }
    /// The sizes for the largest adaptive aperture.
    fn sizes(&self) -> bonebeam::beamform::Sizes {
        let adaptive = self
            .counts
            .iter()
            .enumerate()
            .filter(|(n, _)| self.within.contains(n));
        let most = adaptive.map(|(_, &count)| count).max().unwrap_or(0);
        Beamformer::new(self.parameters)
            .map_or(Default::default(), |beamformer| beamformer.sizes(most))
    }
}

impl Kernel for Lines {
    type Number = Complex<f32>;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let wild = draw.once_in(8);
        let (elements, samples) = (draw.size(20, 72), draw.size(14, 40));
        let mut parameters = parameters(draw, wild);
        parameters.temporal_half_window %= samples + 1;
        if draw.once_in(4) {
            parameters.sub_lines = draw.one_of(&[2, 4, 8, 16]);
        }
        parameters.covariance = draw.one_of(&[Covariance::Forward, Covariance::ForwardBackward]);
        // An aperture that may be empty at first, and grows.
        let (most, steps) = (draw.below(elements + 1), 1 + draw.below(samples));
        let empty = draw.below(steps + 1) * usize::from(draw.flag());
        let all = draw.once_in(4);
        let count = |n: usize| match (all, n / steps) {
            (true, _) => elements,
            (false, _) if n < empty => 0,
            (false, step) => most.min(1 + (step + 1) * most / 3),
        };
        let counts: Vec<usize> = (0..samples).map(count).collect();
        let widest = counts.iter().copied().max().unwrap_or(0);
        let room = (elements - widest).max(1);
        let turn = if room + widest > elements {
            samples
        } else {
            draw.below(samples + 1)
        };
        let lines = (0..draw.size(3, 20)).map(|_| {
            let samples = samples - draw.below(3).min(samples - 1);
            let first = draw.below(room);
            (snapshots(draw, samples, elements), first)
        });
        let lines = lines.collect();
        let within = match draw.flag() && parameters.sub_lines == 1 {
            true => {
                let first = draw.below(samples);
                first..first + draw.below(samples + 4)
            }
            false => 0..samples,
        };
        Beamformer::new(parameters)?;
        let block = 1 + draw.below(samples);
        Ok(Lines {
            parameters,
            elements,
            lines,
            counts,
            turn,
            within,
            block,
        })
    }

    fn need(&self, _: usize, _: usize) -> [Need; 2] {
        [Need::default(), self.sizes().need()]
    }

    fn numbers(&self) -> usize {
        (0..self.lines.len()).map(|line| self.outputs(line)).sum()
    }

    fn run<V: Vector>(
        &self,
        zero: V,
        way: usize,
        (_, memory): (Scratch<'_>, Scratch<'_, V>),
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        self.of_way(zero, way, memory, z)
    }

    fn is_one_call(&self, way: usize) -> bool {
        way == 0 && self.lines.len() == 1
    }

    fn ways(&self) -> Vec<usize> {
        let gated = self.within != (0..self.counts.len());
        let mut ways = vec![];
        if !gated {
            ways.push(SEGMENTS);
        }
        if self.parameters.sub_lines == 1 {
            ways.push(self.block);
        }
        ways
    }
}
