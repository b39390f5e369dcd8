//! From records of transmits to a beamformed line, block by block.

use super::cuts::Cuts;
use super::memory::{buffered, directions_len};
use super::output::Output;
use super::{Block, DepthGate};
use crate::beamform::{
    AlignedLine, Beamformer, LineBlock, Parameters, SUB_LINES, Sizes, View, Workspace, with_view,
};
use crate::covariance::Averaging;
use crate::delay::stage::{Outputs, Rest};
use crate::delay::{
    Compounding, Delay, DelayParameters, IqDelay, IqInterpolation, IqParameters, Record, ScanLine,
    Stage,
};
use crate::error::{check_length, none};
use crate::geometry::{Active, DepthStep, Scan, Steering, SteeringTable, Transmit};
use crate::memory::{Need, Scratch};
use crate::simd::Vector;
use crate::{Complex, Error};
use core::num::NonZeroUsize;
use core::ops::Range;

/// Lines of a scan: its delay stage, apertures and beamformer, validated.
///
/// From RF ([`LinePipeline::new`]) or from I/Q ([`LinePipeline::of_iq`]). It has no memory to work in, so threads
/// can share it. [`LinePipeline::line`] computes a line. [`LinePipeline::align`] is the first half, for programs
/// that beamform many lines at once ([`Beamformer::segments`]).
///
/// ```
/// use bonebeam::prelude::stages::*;
/// use bonebeam::beamform::Parameters;
/// use bonebeam::pipeline::Block;
///
/// # const PARAMETERS: ScanParameters = ScanParameters::EXAMPLE;
/// let lines = LinePipeline::new(Scan::new(PARAMETERS)?, Parameters::DEFAULT)?;
/// let need = lines.need(1, usize::MAX);
/// let mut scratch = vec![0.0; need.real];
/// let mut aligned = vec![Complex::new(0.0, 0.0); need.complex];
/// let rf = vec![0.0; 16 * 512];
/// let record = Record::new(&rf, 16)?;
/// // Two plane waves, compounded.
/// let plane = |angle| (Transmit::new(TransmitLaw::Plane { angle }, 0.0), &record);
/// let block = Block::of_line(lines.scan(), 0);
/// lines.align(0.0f32, block, [plane(-0.1), plane(0.1)], &mut scratch, &mut aligned)?;
/// assert_eq!(aligned[0], Complex::new(0.0, 0.0));
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LinePipeline<'a, D = Delay> {
    scan: Scan<'a>,
    delay: D,
    beamformer: Beamformer,
    /// The samples that the beamformer computes; the others are DAS.
    adaptive: Range<usize>,
}

/// Demodulation and interpolation of I/Q. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IqInput {
    /// Demodulation frequency of the records, Hz.
    pub demodulation_frequency: f64,
    /// Interpolation of the records; by default that of [`IqParameters::of`].
    pub interpolation: Option<IqInterpolation>,
}

impl<'a> LinePipeline<'a> {
    /// Lines of `scan` from RF, by a beamformer.
    ///
    /// # Errors
    /// As [`Delay::new`] and [`Beamformer::new`].
    pub fn new(scan: Scan<'a>, beamformer: Parameters) -> Result<Self, Error> {
        let delay = Delay::new(DelayParameters::of(&scan))?;
        Self::of(delay, scan, beamformer)
    }
}

impl<'a> LinePipeline<'a, &'a Delay> {
    /// Lines of `scan` from RF, with a delay stage elsewhere: see [`Pipeline::by`].
    ///
    /// # Errors
    /// [`Error::Parameter`] if the stage does not match the scan; as [`Beamformer::new`].
    ///
    /// [`Pipeline::by`]: super::Pipeline::by
    pub fn by(delay: &'a Delay, scan: Scan<'a>, beamformer: Parameters) -> Result<Self, Error> {
        let expected = DelayParameters::of(&scan);
        let p = delay.parameters();
        let numbers = |p: &DelayParameters| {
            [
                ("delay stage's sound_speed", p.sound_speed),
                ("delay stage's sampling_rate", p.sampling_rate),
                ("delay stage's centre_frequency", p.centre_frequency),
                ("delay stage's output_rate", p.output_rate),
                ("delay stage's output_start", p.output_start),
                ("delay stage's output_samples", p.output_samples as f64),
                ("delay stage's elements", p.elements as f64),
                ("delay stage's record_samples", p.record_samples as f64),
                ("delay stage's hilbert_taps", p.hilbert_taps as f64),
            ]
        };
        for ((name, value), (_, expected)) in numbers(p).into_iter().zip(numbers(&expected)) {
            if value != expected {
                let expected = "that of the scan";
                return Err(Error::parameter(name, value, expected));
            }
        }
        Self::of(delay, scan, beamformer)
    }
}

impl<'a> LinePipeline<'a, IqDelay> {
    /// Lines of `scan` from I/Q, by a beamformer.
    ///
    /// # Errors
    /// As [`IqDelay::new`] and [`Beamformer::new`].
    pub fn of_iq(scan: Scan<'a>, iq: IqInput, beamformer: Parameters) -> Result<Self, Error> {
        let parameters = IqParameters::of(&scan, iq.demodulation_frequency);
        let interpolation = iq.interpolation.unwrap_or(parameters.interpolation);
        let delay = IqDelay::new(IqParameters {
            interpolation,
            ..parameters
        })?;
        Self::of(delay, scan, beamformer)
    }
}

impl<'a, D: Stage> LinePipeline<'a, D> {
    fn of(delay: D, scan: Scan<'a>, beamformer: Parameters) -> Result<Self, Error> {
        Ok(LinePipeline {
            delay,
            beamformer: Beamformer::new(beamformer)?,
            adaptive: 0..scan.samples(),
            scan,
        })
    }

    /// The same lines, with the beamformer within `gate` only, and DAS elsewhere.
    ///
    /// # Errors
    /// As [`DepthGate::samples`].
    pub fn with_gate(self, gate: DepthGate) -> Result<Self, Error> {
        Ok(LinePipeline {
            adaptive: gate.samples(&self.scan.depths())?,
            ..self
        })
    }

    /// The same lines, with the delay stage by reference.
    pub fn by_reference(&self) -> LinePipeline<'_, &D> {
        LinePipeline {
            scan: self.scan,
            delay: &self.delay,
            beamformer: self.beamformer,
            adaptive: self.adaptive.clone(),
        }
    }

    /// Samples of a line that the beamformer computes; all without a gate.
    pub fn adaptive(&self) -> Range<usize> {
        self.adaptive.clone()
    }

    /// The scan.
    pub fn scan(&self) -> &Scan<'a> {
        &self.scan
    }

    /// The delay stage.
    pub fn delay(&self) -> &D {
        &self.delay
    }

    /// The beamformer.
    pub fn beamformer(&self) -> &Beamformer {
        &self.beamformer
    }

    /// The samples of a line that the records of a transmit hold.
    ///
    /// For the element at the line's beginning; others hold a little less. Other samples are black: above the
    /// record's first sample, below its last, and all of a line without active elements. A wrong `t0` or `end` shows
    /// here, at set-up.
    ///
    /// ```
    /// use bonebeam::geometry::{Scan, ScanParameters, Transmit, TransmitLaw};
    /// use bonebeam::{beamform::Parameters, pipeline::LinePipeline};
    ///
    /// let lines = LinePipeline::new(Scan::new(ScanParameters::EXAMPLE)?, Parameters::DEFAULT)?;
    /// let at = |t0| lines.recorded(32, &Transmit::new(TransmitLaw::Focused, t0));
    /// assert_eq!(at(0.0)?, 0..208); // all
    /// assert_eq!(at(1.0)?, 208..208); // t0 in microseconds
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for an impossible transmit, or a line outside the scan.
    pub fn recorded(&self, line: usize, transmit: &Transmit<'_>) -> Result<Range<usize>, Error> {
        crate::delay::flight::recorded(&self.scan, line, transmit)
    }

    /// Number of computed samples of a line, with its [depth step](Parameters::depth_step).
    pub fn line_samples(&self) -> usize {
        self.beamformer.line_samples(self.scan.samples())
    }

    /// Memory for lines in blocks of `block` samples, by vectors of `lanes`.
    ///
    /// Real numbers for the delay stage, complex numbers for the aligned samples. A block is at least as long as
    /// the time window. The beamformer's workspace is separate.
    pub fn need(&self, lanes: usize, block: usize) -> Need {
        let half_window = self.beamformer.parameters().temporal_half_window;
        let buffered = buffered(self.scan.samples(), half_window, block);
        self.delay
            .need(lanes, buffered)
            .and(Need::new(0, buffered * self.scan.elements()))
    }

    /// Computes aligned analytic samples of a line, `[sample][element]`.
    ///
    /// The length of `out` sets their number. They are the mean over the line's transmits, added in their order.
    /// Samples that the beamformer does not read ([`Parameters::depth_step`] without a time window) are 0. Returns
    /// the samples for the beamformer. Their working scale is that of the records, the same for all blocks of a
    /// line.
    ///
    /// `zero`: any vector of the instruction set to compute with. `scratch`:
    /// the real numbers of [`LinePipeline::need`] at least, contents irrelevant.
    ///
    /// # Errors
    /// [`Error::Parameter`] for no transmits; [`Error::Capacity`] for a block that ends behind the line; as
    /// [`Stage::line`]. `out` may be changed if a transmit after the first is refused.
    pub fn align<'r, 'x, V: Vector>(
        &self,
        zero: V,
        block: Block,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>)>,
        scratch: &mut [f32],
        out: &'x mut [Complex<f32>],
    ) -> Result<AlignedLine<'x>, Error> {
        let Some(elements) = NonZeroUsize::new(self.scan.elements()) else {
            return Err(none("elements"));
        };
        let block_of = (block, self.wanted(), Rest::Zero);
        let largest = self.compound(zero, block_of, transmits, scratch, out)?;
        let whole = (block.first, self.scan.samples());
        Ok(AlignedLine::block(out, elements, whole, largest))
    }

    /// Distance between aligned samples for the beamformer; time windows read all.
    fn wanted(&self) -> DepthStep {
        let parameters = self.beamformer.parameters();
        match parameters.temporal_half_window {
            0 => parameters.step(),
            _ => DepthStep::ONE,
        }
    }

    /// The last sample whose time window reads one before `end`.
    fn deepest(&self, end: usize) -> usize {
        let half_window = self.beamformer.parameters().temporal_half_window;
        let behind = end.saturating_add(half_window).min(self.scan.samples());
        behind.saturating_sub(1)
    }

    /// Aligns every `step`-th sample of a line within a block; returns a bound of their magnitudes.
    fn compound<'r, V: Vector>(
        &self,
        zero: V,
        (block, step, rest): (Block, DepthStep, Rest),
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>)>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<f32, Error> {
        let samples = out.len() / self.scan.elements().max(1);
        let actual = scratch.len();
        let expected = self.delay.need(V::LANES, samples).real;
        let Some(scratch) = scratch.get_mut(..expected) else {
            return Err(Error::length("scratch", actual, expected));
        };
        let mut count = 0;
        let mut largest = 0.0;
        let mut compounding = Compounding::Replace;
        let mut transmits = transmits.into_iter();
        let mut next = transmits.next();
        while let Some((transmit, record)) = next {
            next = transmits.next();
            let line = ScanLine {
                transmit,
                ray: self.scan.ray(block.line),
                array: self.scan.parameters().array,
                // Silence is not delayed: it is 0, or adds nothing.
                active: block.active.within(record.received()),
                compounding,
            };
            let wanted = Outputs {
                first: block.first,
                step,
                // All numbers must be finite if another transmit is added, and silent elements are read.
                rest: match next.is_some() || record.is_part() {
                    true => Rest::Zero,
                    false => rest,
                },
            };
            self.delay
                .block_of(zero, &line, record, wanted, scratch, out)?;
            let of_record = record.largest_aligned();
            if of_record > largest {
                largest = of_record;
            }
            compounding = Compounding::Add;
            count += 1;
        }
        match count {
            0 => return Err(none("transmits")),
            1 => {}
            _ => {
                let scale = 1.0 / count as f32;
                for value in out {
                    *value *= scale;
                }
            }
        }
        Ok(largest)
    }

    /// Computes a beamformed line, block by block.
    ///
    /// [`LinePipeline::align`], then [`Beamformer::line`], or [`Beamformer::line_within`] the gate, in blocks as
    /// long as the memory allows. All transmits are read once for each block.
    ///
    /// The beamformer's working scale is that of the records, so that it is the same for all blocks. Samples 300 dB
    /// below the records are at the end of the floats' range.
    ///
    /// # Errors
    /// As these two; [`Error::Length`] unless `z` has [`LinePipeline::line_samples`] numbers, and the memory one of
    /// [`LinePipeline::need`]. `z` may be changed in part.
    pub fn line<'r, V: Vector>(
        &self,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>), IntoIter: Clone>,
        scratch: Scratch<'_>,
        workspace: &mut Workspace<'_, V>,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let active = |sample| self.scan.active(line, sample);
        let output = Output::new(None, z);
        self.line_with(line, transmits, scratch, workspace, (active, output))
    }

    /// Computes the sub-lines of a line: `z[n·N + k]` is sample `n` in direction `k`.
    ///
    /// As [`LinePipeline::line`], with [`Beamformer::sub_lines`]; `steering` has the directions.
    ///
    /// # Errors
    /// As these two.
    pub fn sub_lines<'r, V: Vector>(
        &self,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>), IntoIter: Clone>,
        scratch: Scratch<'_>,
        workspace: &mut Workspace<'_, V>,
        (steering, z): (Steering<'_>, &mut [Complex<f32>]),
    ) -> Result<(), Error> {
        let active = |sample| self.scan.active(line, sample);
        let output = Output::new(Some(steering), z);
        self.line_with(line, transmits, scratch, workspace, (active, output))
    }

    /// Length of the directions of all sub-lines; 0 for lines alone.
    pub fn directions_len(&self) -> usize {
        directions_len(&self.scan, self.beamformer.parameters())
    }

    /// Computes the directions of all sub-lines.
    ///
    /// In memory of [`LinePipeline::directions_len`], once for a scan: [`Steering::new`] has the cost.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn directions<'m>(
        &self,
        memory: &'m mut [Complex<f32>],
    ) -> Result<SteeringTable<'m>, Error> {
        let p = self.beamformer.parameters();
        // Lines alone have none.
        let sub_lines = if p.sub_lines > 1 { p.sub_lines } else { 0 };
        SteeringTable::of_step(&self.scan, (sub_lines, p.depth_step), memory)
    }

    /// [`LinePipeline::line`] to an output.
    #[inline(always)]
    fn line_with<'r, V: Vector>(
        &self,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>), IntoIter: Clone>,
        scratch: Scratch<'_>,
        workspace: &mut Workspace<'_, V>,
        by: (impl Fn(usize) -> Active, Output<'_>),
    ) -> Result<(), Error> {
        let sizes = workspace.sizes();
        with_view!(workspace, view => self.blocks(line, transmits, scratch, (view, sizes), by))
    }

    /// A line, block by block.
    pub(super) fn blocks<'r, A: Averaging<V>, V: Vector>(
        &self,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>), IntoIter: Clone>,
        scratch: Scratch<'_>,
        (view, sizes): (&mut View<'_, A, V>, Sizes),
        (active, output): (impl Fn(usize) -> Active, Output<'_>),
    ) -> Result<(), Error> {
        let samples = self.scan.samples();
        let Output {
            steering,
            z,
            mut coherence,
        } = output;
        // Numbers of a sample.
        let count = match steering {
            None => 1,
            Some(_) => self.beamformer.parameters().sub_lines,
        };
        let outputs = self.line_samples();
        check_length("z", z.len(), outputs.saturating_mul(count))?;
        let Some(elements) = NonZeroUsize::new(self.scan.elements()) else {
            return Ok(());
        };
        let Scratch {
            real: scratch,
            complex: aligned,
        } = scratch;
        let half_window = self.beamformer.parameters().temporal_half_window;
        let block = self.block(aligned.len(), elements)?;
        let step = self.beamformer.parameters().step();
        // Coherence is that of every sample.
        let wanted = coherence.as_ref().map_or(self.wanted(), |_| DepthStep::ONE);
        let transmits = transmits.into_iter();
        let mut buffered = 0..0;
        for own in Cuts::new(samples, half_window, block, &active) {
            let needed = own.start.saturating_sub(half_window)
                ..own.end.saturating_add(half_window).min(samples);
            // Samples that the block before read as well move to the front.
            let kept = (buffered.end - needed.start) * elements.get();
            let from = (needed.start - buffered.start) * elements.get();
            if let Some(before) = aligned.get_mut(..from + kept)
                && from <= before.len()
            {
                before.copy_within(from.., 0);
            }
            let x = aligned.get_mut(..needed.len() * elements.get());
            let x = x.unwrap_or_default();
            let new = x.get_mut(kept..).unwrap_or_default();
            // Deeper sets contain shallower ones: take that of the last sample with a time window here.
            let block = Block {
                line,
                first: buffered.end,
                active: active(self.deepest(needed.end)),
            };
            let block = (block, wanted, Rest::Undefined);
            let largest = self.compound(view.zero, block, transmits.clone(), scratch, new)?;
            let x = AlignedLine::block(x, elements, (needed.start, samples), largest);
            let outputs = step.outputs_of(own.clone());
            let out = z.get_mut(outputs.start * count..outputs.end * count);
            let out = out.unwrap_or_default();
            let within = |sample: usize| sample.max(own.start).min(own.end) - own.start;
            let adaptive = within(self.adaptive.start)..within(self.adaptive.end);
            let block = LineBlock {
                line: x,
                first: own.start,
                samples: own.len(),
                active: &active,
                adaptive,
            };
            match steering {
                Some(steering) if SUB_LINES => {
                    let block = (&block, steering);
                    self.beamformer.sub_line_block(view, sizes, block, out)?;
                }
                _ => self.beamformer.block(view, sizes, &block, out)?,
            }
            if let Some(coherence) = &mut coherence {
                coherence.block(x, &active);
            }
            buffered = needed;
        }
        Ok(())
    }

    /// Number of samples of a block in the given memory for aligned samples.
    fn block(&self, aligned: usize, elements: NonZeroUsize) -> Result<usize, Error> {
        let samples = self.scan.samples();
        let half_window = self.beamformer.parameters().temporal_half_window;
        let capacity = aligned / elements;
        if capacity >= samples {
            return Ok(samples);
        }
        let fewest = buffered(samples, half_window, 0);
        if capacity < fewest {
            return Err(Error::length(
                "memory for aligned samples",
                aligned,
                fewest * elements.get(),
            ));
        }
        Ok(capacity - 2 * half_window)
    }
}
