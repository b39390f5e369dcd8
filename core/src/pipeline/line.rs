//! From the RF of transmits to a beamformed line.

use super::DepthGate;
use crate::beamform::{AlignedLine, Beamformer, Parameters, WorkspaceView};
use crate::covariance::Averaging;
use crate::error::check_length;
use crate::focus::{Compounding, Delay, DelayParameters, Record, ScanLine};
use crate::geometry::{Active, Scan, Transmit};
use crate::simd::Vector;
use crate::{Complex, Error};
use core::ops::Range;

/// The lines of a scan: its delay stage, its apertures and its beamformer, all validated.
///
/// Holds no memory to work in, so that threads can share it. [`LinePipeline::line`] is the whole way;
/// [`LinePipeline::align`] is the first half, for who beamforms many lines at once.
///
/// ```
/// # use bonebeam::geometry::{Array, Axis, Depth, Lines, ScanParameters};
/// use bonebeam::Complex;
/// use bonebeam::beamform::Parameters;
/// use bonebeam::focus::Record;
/// use bonebeam::geometry::{Scan, Transmit, TransmitLaw};
/// use bonebeam::pipeline::LinePipeline;
///
/// # const PARAMETERS: ScanParameters = ScanParameters {
/// #     array: Array::linear(16, 0.3e-3),
/// #     lines: Lines::Even(Axis::centred(64, 0.1e-3)),
/// #     sound_speed: 1540.0,
/// #     centre_frequency: 5e6,
/// #     sampling_rate: 20e6,
/// #     record_samples: 512,
/// #     output_rate: 20e6,
/// #     start: Depth::Metres(4e-3),
/// #     end: Depth::Metres(12e-3),
/// #     f_number: 1.5,
/// #     min_elements: 8,
/// # };
/// let lines = LinePipeline::new(Scan::new(PARAMETERS)?, Parameters::DEFAULT)?;
/// let mut scratch = vec![0.0; lines.scratch_len(1)];
/// let mut aligned = vec![Complex::new(0.0, 0.0); lines.aligned_len()];
/// let rf = vec![0.0; 16 * 512];
/// let record = Record::new(&rf, 16)?;
/// // Two plane waves, compounded.
/// let plane = |angle| (Transmit::new(TransmitLaw::Plane { angle }, 0.0), &record);
/// lines.align(0.0f32, 0, [plane(-0.1), plane(0.1)], &mut scratch, &mut aligned)?;
/// assert_eq!(aligned[0], Complex::new(0.0, 0.0));
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LinePipeline<'a> {
    scan: Scan<'a>,
    delay: Delay,
    beamformer: Beamformer,
    /// The samples that the beamformer makes; the others are DAS.
    adaptive: Range<usize>,
}

/// What a line is worked out in.
pub struct LineMemory<'m> {
    /// For the delay stage: [`LinePipeline::scratch_len`] of one lane.
    pub scratch: &'m mut [f32],
    /// For the aligned samples: [`LinePipeline::aligned_len`].
    pub aligned: &'m mut [Complex<f32>],
}

impl<'a> LinePipeline<'a> {
    /// The lines of `scan`, by a beamformer.
    ///
    /// # Errors
    /// As [`Delay::new`] and [`Beamformer::new`].
    pub fn new(scan: Scan<'a>, beamformer: Parameters) -> Result<Self, Error> {
        Ok(LinePipeline {
            delay: Delay::new(DelayParameters::of(&scan))?,
            beamformer: Beamformer::new(beamformer)?,
            adaptive: 0..scan.samples(),
            scan,
        })
    }

    /// The same lines, by the beamformer within `gate` only, and by DAS elsewhere.
    ///
    /// # Errors
    /// As [`DepthGate::samples`].
    pub fn with_gate(self, gate: DepthGate) -> Result<Self, Error> {
        Ok(LinePipeline {
            adaptive: gate.samples(&self.scan.depths())?,
            ..self
        })
    }

    /// The samples of a line that the beamformer makes: all without a gate.
    pub fn adaptive(&self) -> Range<usize> {
        self.adaptive.clone()
    }

    /// The scan.
    pub fn scan(&self) -> &Scan<'a> {
        &self.scan
    }

    /// The delay stage.
    pub fn delay(&self) -> &Delay {
        &self.delay
    }

    /// The beamformer.
    pub fn beamformer(&self) -> &Beamformer {
        &self.beamformer
    }

    /// Length of the delay stage's scratch slice for vectors of so many lanes.
    pub fn scratch_len(&self, lanes: usize) -> usize {
        self.delay.parameters().scratch_len(lanes)
    }

    /// Length of a line's aligned samples, `[sample][element]`.
    pub fn aligned_len(&self) -> usize {
        self.scan.samples() * self.scan.elements()
    }

    /// The aligned analytic samples of a line, `[sample][element]`: the mean over its transmits, added
    /// up in their order.
    ///
    /// `zero`: any vector of the instruction set to compute with. Memory as [`Delay::line`].
    ///
    /// # Errors
    /// [`Error::Parameter`] for no transmits; as [`Delay::line`], with `out` perhaps changed where it
    /// is not the first transmit that is refused.
    pub fn align<'r, V: Vector>(
        &self,
        zero: V,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>)>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let mut count = 0;
        let mut compounding = Compounding::Replace;
        for (transmit, record) in transmits {
            let scan_line = ScanLine::of(&self.scan, line, transmit, compounding);
            self.delay.line(zero, &scan_line, record, scratch, out)?;
            compounding = Compounding::Add;
            count += 1;
        }
        match count {
            0 => Err(Error::Parameter {
                name: "transmits",
                value: 0.0,
                expected: "at least 1",
            }),
            1 => Ok(()),
            _ => {
                let scale = 1.0 / count as f32;
                for value in out {
                    *value *= scale;
                }
                Ok(())
            }
        }
    }

    /// A beamformed line: [`LinePipeline::align`], then [`Beamformer::line`], or
    /// [`Beamformer::line_within`] the gate.
    ///
    /// # Errors
    /// As those two; [`Error::Length`] where `z` is not as long as the line.
    pub fn line<'r, A: Averaging<f32>>(
        &self,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>)>,
        memory: LineMemory<'_>,
        workspace: &mut WorkspaceView<'_, A>,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let active = |sample| self.scan.active(line, sample);
        self.line_with(line, transmits, memory, workspace, active, z)
    }

    /// [`LinePipeline::line`] with the active sets from elsewhere.
    pub(super) fn line_with<'r, A: Averaging<f32>>(
        &self,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>)>,
        memory: LineMemory<'_>,
        workspace: &mut WorkspaceView<'_, A>,
        active: impl Fn(usize) -> Active,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        check_length("z", z.len(), self.scan.samples())?;
        let LineMemory { scratch, aligned } = memory;
        self.align(0.0f32, line, transmits, scratch, aligned)?;
        let x = AlignedLine::new(aligned, self.scan.elements())?;
        if self.adaptive == (0..self.scan.samples()) {
            return self.beamformer.line(workspace, x, active, z);
        }
        let adaptive = self.adaptive.clone();
        self.beamformer
            .line_within(workspace, x, active, adaptive, z)
    }
}
