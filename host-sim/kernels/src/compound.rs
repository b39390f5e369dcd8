//! Many transmits compounded into lines, each record upsampled once.

use std::ops::Range;

use bonebeam::dispatch;
use bonebeam::pipeline::Block;
use bonebeam::prelude::stages::*;
use num_complex::Complex;
use rayon::prelude::*;

use crate::Result;

/// Number of elements that a thread adds together.
///
/// The elements share one read of the transmits' parts of the positions, which exceed any cache; their records fit in
/// the second-level cache.
const TOGETHER: usize = 2;

/// Some lines of compounded transmits: the mean of their real parts.
pub struct Compounded<'a> {
    delay: &'a Delay,
    upsampled: Upsampled<'a>,
    scan: Scan<'a>,
    transmits: &'a [Transmit<'a>],
    lines: Range<usize>,
    /// Bound of the parts of all aligned samples, whose working scale is that of the frame.
    largest: f32,
    /// Position at which each line leaves the array, in elements.
    centres: Vec<f64>,
    /// Values, `[element, line, value]`.
    ///
    /// Values of samples at which an element is not active are incomplete.
    values: Vec<f32>,
}

impl<'a> Compounded<'a> {
    /// The lines `lines` of `scan`.
    ///
    /// The samples were checked, as `[transmit, element, sample]`, with a bound of their aligned samples.
    pub fn new(
        set: InstructionSet,
        (delay, scan): (&'a Delay, Scan<'a>),
        transmits: &'a [Transmit<'a>],
        (rf, largest): (&[f32], f32),
        lines: Range<usize>,
    ) -> Result<Self> {
        let mut compounded = Compounded {
            delay,
            upsampled: Upsampled::new(delay)?,
            scan,
            transmits,
            centres: lines
                .clone()
                .map(|line| scan.aperture_centre(line))
                .collect(),
            lines,
            largest,
            values: Vec::new(),
        };
        compounded.values = dispatch!(set, zero => compounded.values(zero, rf))?;
        Ok(compounded)
    }

    /// The scan.
    pub fn scan(&self) -> &Scan<'a> {
        &self.scan
    }

    /// A block of aligned samples of one of the lines.
    pub fn align<'x>(
        &self,
        set: InstructionSet,
        block: Block,
        scratch: &mut Vec<f32>,
        x: &'x mut [Complex<f32>],
    ) -> Result<AlignedLine<'x>> {
        dispatch!(set, zero => self.analytic(zero, block, scratch, x))?;
        let line = AlignedLine::new(x, self.scan.elements())?;
        let line = line.of_line(block.first, self.scan.samples())?;
        Ok(line.of_largest(self.largest)?)
    }

    fn active(&self, line: usize, sample: usize) -> Range<usize> {
        let centre = self.centres[line - self.lines.start];
        range(self.scan.active_at(centre, sample))
    }

    fn line(&self, transmit: usize, line: usize) -> ScanLine<'_> {
        ScanLine::of(
            &self.scan,
            line,
            self.transmits[transmit],
            Compounding::Replace,
        )
    }

    /// First sample at which an element is active in a line, if any.
    fn first(&self, line: usize, element: usize) -> Option<usize> {
        let inactive = |sample| !self.active(line, sample).contains(&element);
        let last = self.scan.samples() - 1;
        if inactive(last) {
            return None;
        }
        // Once active, it stays so.
        let (mut low, mut high) = (0, last);
        while low < high {
            let middle = (low + high) / 2;
            if inactive(middle) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        Some(low)
    }

    /// Real parts of all elements: the mean over the transmits, added in their order.
    fn values<V: Vector>(&self, zero: V, rf: &[f32]) -> Result<Vec<f32>> {
        let upsampled = &self.upsampled;
        let p = self.delay.parameters();
        let (lines, length) = (self.lines.len(), upsampled.line_len());
        let of_lines = lines * length;
        if lines == 0 {
            return Ok(Vec::new());
        }
        // All elements share them.
        let mut centres = vec![0; self.transmits.len() * of_lines];
        let positions = centres.par_chunks_exact_mut(length).enumerate();
        positions.try_for_each(|(k, positions)| {
            upsampled.centre(
                &self.line(k / lines, self.lines.start + k % lines),
                positions,
            )
        })?;
        let mut values = vec![0.0; p.elements * of_lines];
        let scale = 1.0 / self.transmits.len() as f32;
        let of_elements = values.par_chunks_mut(TOGETHER * of_lines);
        let record_len = upsampled.record_len();
        let memory = || {
            (
                vec![0; TOGETHER * of_lines],
                vec![0.0; upsampled.need().real],
                vec![0.0; TOGETHER * record_len],
            )
        };
        let of_elements = of_elements.enumerate();
        of_elements.try_for_each_init(
            memory,
            |(receive_delays, scratch, records), (group, values)| {
                let elements = group * TOGETHER..p.elements.min((group + 1) * TOGETHER);
                // [element, line], as the lags and the values.
                let mut first = Vec::with_capacity(elements.len() * lines);
                for element in elements.clone() {
                    first.extend(self.lines.clone().map(|line| self.first(line, element)));
                }
                for (k, receive_delays) in receive_delays.chunks_exact_mut(length).enumerate() {
                    if first.get(k).is_some_and(Option::is_some) {
                        let (line, element) =
                            (self.lines.start + k % lines, elements.start + k / lines);
                        upsampled.receive_delays(
                            zero,
                            &self.line(0, line),
                            element,
                            receive_delays,
                        )?;
                    }
                }
                for (transmit, centres) in centres.chunks_exact(of_lines).enumerate() {
                    for (element, record) in
                        elements.clone().zip(records.chunks_exact_mut(record_len))
                    {
                        let row = (transmit * p.elements + element) * p.record_samples;
                        let samples = &rf[row..row + p.record_samples];
                        upsampled.record(zero, samples, scratch, record)?;
                    }
                    for (line, centre) in centres.chunks_exact(length).enumerate() {
                        for (element, record) in records.chunks_exact(record_len).enumerate() {
                            let own = element * lines + line;
                            let Some(&Some(first)) = first.get(own) else {
                                continue;
                            };
                            let contribution = Contribution {
                                record,
                                centre: &centre[first..],
                                receive_delays: &receive_delays[own * length..][first..length],
                            };
                            let values = &mut values[own * length..][first..length];
                            upsampled.add(zero, &contribution, values)?;
                        }
                    }
                }
                for value in values {
                    *value *= scale;
                }
                Ok::<(), bonebeam::Error>(())
            },
        )?;
        Ok(values)
    }

    /// The analytic samples of a block.
    fn analytic<V: Vector>(
        &self,
        zero: V,
        block: Block,
        scratch: &mut Vec<f32>,
        x: &mut [Complex<f32>],
    ) -> Result<()> {
        let p = self.delay.parameters();
        let length = self.upsampled.line_len();
        let own_length = self.upsampled.block_len(x.len() / p.elements);
        let stage_len = p.need(V::LANES).real;
        scratch.resize(stage_len, 0.0);
        let mut own = Vec::with_capacity(block.active.count * own_length);
        for element in range(block.active) {
            let row = element * self.lines.len() + block.line - self.lines.start;
            let row = &self.values[row * length..(row + 1) * length];
            let end = length.min(block.first + own_length);
            own.extend_from_slice(&row[block.first..end]);
            own.resize(own.len() + own_length - (end - block.first), 0.0);
        }
        let line = ScanLine {
            active: block.active,
            ..self.line(0, block.line)
        };
        self.upsampled.analytic(zero, &line, &own, scratch, x)?;
        // What is not active is not complete.
        for (sample, row) in x.chunks_exact_mut(p.elements).enumerate() {
            let active = self.active(block.line, block.first + sample);
            row[..active.start].fill(Complex::ZERO);
            row[active.end..].fill(Complex::ZERO);
        }
        Ok(())
    }
}

fn range(active: Active) -> Range<usize> {
    active.first..active.first + active.count
}
