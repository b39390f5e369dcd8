//! From blocks to a bone map: what the main loop does, for the scan of [`scan`](crate::scan).

use bonebeam::beamform::{AlignedLine, Beamformer, Workspace};
use bonebeam::focus::{
    Compounding, IqDelay, IqLayout, IqParameters, IqReading, IqRecord, IqSamples, ScanLine,
};
use bonebeam::geometry::{Lines, Widths};
use bonebeam::image::{BMode, BModeParameters, Logarithm, PixelGrid, envelope};
use bonebeam::phase_symmetry::{
    External, Kernels, LogGabor, Microfft, Parameters, PhaseSymmetry, StripMemory,
};
use bonebeam::pipeline::DepthGate;
use bonebeam::{Complex, Error, beamform};
use core::ops::Range;

use crate::scan::{
    BEAMFORMER, BEAMS, COLUMNS, DEMODULATION, DYNAMIC_RANGE, ELEMENTS, LENGTH, PIXELS, READING,
    ROWS, SCALES, SCAN, STRIP, STRIPS, SUBAPERTURE, ScanBlock, THRESHOLD, TRANSMIT,
};

/// What can be chosen for the scan without other memory.
#[derive(Clone, Copy)]
pub struct Choice {
    /// The beamformer, of no more than the scan's subaperture and without a time window.
    pub beamformer: beamform::Parameters,
    /// The depths in which it works, with DAS elsewhere; all without it.
    pub gate: Option<DepthGate>,
    /// How I/Q is read between its samples.
    pub reading: IqReading,
}

/// The plan: what follows from the parameters once and for all.
pub struct Plan {
    delay: IqDelay,
    beamformer: Beamformer,
    /// The samples that it makes; the others are DAS.
    adaptive: Range<usize>,
    b_mode: BMode,
    phase_symmetry: PhaseSymmetry,
}

impl Plan {
    /// Works it out.
    ///
    /// # Errors
    /// None: the parameters of [`scan`](crate::scan) are valid.
    pub fn new() -> Result<Self, Error> {
        Self::of(Choice {
            beamformer: BEAMFORMER,
            gate: None,
            reading: READING,
        })
    }

    /// Works out another one.
    ///
    /// # Errors
    /// What the core refuses of the choice.
    pub fn of(choice: Choice) -> Result<Self, Error> {
        let lines = SCAN.parameters().lines;
        let (across, down) = match lines {
            Lines::Even(axis) => (axis, SCAN.depths()),
            _ => {
                return Err(Error::Parameter {
                    name: "lines",
                    value: lines.count() as f64,
                    expected: "evenly spaced lines, for an image",
                });
            }
        };
        Ok(Plan {
            delay: IqDelay::new(IqParameters {
                reading: choice.reading,
                ..IqParameters::of(&SCAN, DEMODULATION)
            })?,
            beamformer: Beamformer::new(choice.beamformer)?,
            adaptive: match choice.gate {
                Some(gate) => gate.samples(&SCAN.depths())?,
                None => 0..LENGTH,
            },
            b_mode: BMode::new(BModeParameters {
                lines: across,
                samples: down,
                grid: PixelGrid::of_lines(&across, &down, ROWS, COLUMNS),
                dynamic_range: DYNAMIC_RANGE,
                logarithm: Logarithm::Exact,
                median: true,
            })?,
            phase_symmetry: PhaseSymmetry::new(&Parameters {
                sizes: STRIPS,
                scales: &SCALES,
                threshold: THRESHOLD,
            })?,
        })
    }
}

/// The memory of a [`Chain`], for a `static`.
pub struct ChainMemory {
    widths: [f32; LENGTH],
    scratch: [f32; LAGS],
    aligned: [Complex<f32>; ELEMENTS * LENGTH],
    line: [Complex<f32>; LENGTH],
    envelopes: [f32; BEAMS * LENGTH],
    image: [f32; PIXELS],
    map: [f32; PIXELS],
    /// The image stage's grey levels and pixels; then phase symmetry's spectrum, filtered image and
    /// denominator.
    work: [f32; WORK],
    strip: StripMemory<ROWS, STRIP>,
    beamformer: Workspace<ELEMENTS, SUBAPERTURE, 0>,
}

const LAGS: usize = IqParameters::of(&SCAN, DEMODULATION).scratch_len(1);
const LEVELS: usize = BEAMS * LENGTH + PIXELS;
const FILTERS: usize = STRIPS.spectrum_len() + STRIPS.filtered_len() + STRIPS.amplitude_len();
const WORK: usize = if LEVELS > FILTERS { LEVELS } else { FILTERS };

impl ChainMemory {
    /// What it takes.
    pub const BYTES: usize = size_of::<Self>();

    /// All zero.
    pub const fn new() -> Self {
        ChainMemory {
            widths: [0.0; LENGTH],
            scratch: [0.0; LAGS],
            aligned: [Complex::new(0.0, 0.0); ELEMENTS * LENGTH],
            line: [Complex::new(0.0, 0.0); LENGTH],
            envelopes: [0.0; BEAMS * LENGTH],
            image: [0.0; PIXELS],
            map: [0.0; PIXELS],
            work: [0.0; WORK],
            strip: StripMemory::new(),
            beamformer: Workspace::new(),
        }
    }
}

impl Default for ChainMemory {
    fn default() -> Self {
        Self::new()
    }
}

/// A plan at work on blocks: a line at a time, then image and map.
pub struct Chain<'m> {
    plan: &'m Plan,
    widths: Widths<'m>,
    scratch: &'m mut [f32],
    aligned: &'m mut [Complex<f32>],
    line: &'m mut [Complex<f32>],
    envelopes: &'m mut [f32],
    image: &'m mut [f32],
    map: &'m mut [f32],
    work: &'m mut [f32],
    strip: &'m mut StripMemory<ROWS, STRIP>,
    beamformer: &'m mut Workspace<ELEMENTS, SUBAPERTURE, 0>,
}

impl<'m> Chain<'m> {
    /// A chain that has seen no block.
    ///
    /// # Errors
    /// None: the sizes follow from the scan.
    pub fn new(plan: &'m Plan, memory: &'m mut ChainMemory) -> Result<Self, Error> {
        memory.envelopes.fill(0.0);
        Ok(Chain {
            plan,
            widths: Widths::new(&SCAN, &mut memory.widths)?,
            scratch: &mut memory.scratch,
            aligned: &mut memory.aligned,
            line: &mut memory.line,
            envelopes: &mut memory.envelopes,
            image: &mut memory.image,
            map: &mut memory.map,
            work: &mut memory.work,
            strip: &mut memory.strip,
            beamformer: &mut memory.beamformer,
        })
    }

    /// Focuses a line's block, which is free afterwards.
    ///
    /// # Errors
    /// None: any samples will do.
    pub fn focus(&mut self, line: usize, block: &ScanBlock) -> Result<(), Error> {
        let samples = IqSamples::Counts(block.samples.as_flattened(), 1.0);
        let record = IqRecord::new(samples, IqLayout::Interleaved, ELEMENTS)?;
        let line = ScanLine::of(&SCAN, line, TRANSMIT, Compounding::Replace);
        let delay = &self.plan.delay;
        delay.line(0.0f32, &line, &record, self.scratch, self.aligned)
    }

    /// Beamforms the line that was focused, and keeps its envelope for the image.
    ///
    /// # Errors
    /// [`Error::Capacity`] for a line that the scan does not have.
    pub fn beamform(&mut self, line: usize) -> Result<(), Error> {
        let Some(envelopes) = self.envelopes.chunks_exact_mut(LENGTH).nth(line) else {
            return Err(Error::Capacity {
                name: "line",
                actual: line,
                capacity: BEAMS - 1,
            });
        };
        let foot = Widths::foot(&SCAN, line);
        let active = |sample| self.widths.active(foot, sample);
        let x = AlignedLine::new(self.aligned, ELEMENTS)?;
        let mut workspace = self.beamformer.view();
        let beamformer = &self.plan.beamformer;
        match self.plan.adaptive.clone() {
            all if all == (0..LENGTH) => beamformer.line(&mut workspace, x, active, self.line)?,
            adaptive => {
                beamformer.line_within(&mut workspace, x, active, adaptive, self.line)?;
            }
        }
        envelope(self.line, envelopes)
    }

    /// The image of the lines, row-major, 0 to 255.
    ///
    /// # Errors
    /// None: lines are finite.
    pub fn image(&mut self) -> Result<&[f32], Error> {
        let work = self.work.split_at_mut(LEVELS).0;
        let b_mode = &self.plan.b_mode;
        b_mode.image(0.0f32, self.envelopes, work, self.image)?;
        Ok(self.image)
    }

    /// The bone map of the last image, row-major, 0 to below 1.
    ///
    /// # Errors
    /// None: images are finite.
    pub fn map(&mut self) -> Result<&[f32], Error> {
        let (mut spectrum, rest) = self.work.split_at_mut(STRIPS.spectrum_len());
        let (mut filtered, rest) = rest.split_at_mut(STRIPS.filtered_len());
        let mut amplitude = rest.split_at_mut(STRIPS.amplitude_len()).0;
        self.plan.phase_symmetry.run(
            &Kernels {
                fft: &Microfft,
                gains: &LogGabor::fixed(),
            },
            &mut External {
                image: &mut &*self.image,
                spectrum: &mut spectrum,
                filtered: &mut filtered,
                amplitude: &mut amplitude,
                symmetry: &mut &mut *self.map,
            },
            &mut self.strip.slices(),
            &mut |_| {},
        )?;
        Ok(self.map)
    }
}
