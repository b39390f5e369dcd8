//! Channel data to lines, image, bone map and bone surface, in fixed memory.
//!
//! A [`Pipeline`] is a plan: validated parameters and their tables. It has no memory to work in, so threads can
//! share it. A [`Frame`] is a plan with memory: RF or I/Q enters line by line, and an image and a bone map come
//! out. Its memory is [`Parameters::need`] at compile time, or [`Pipeline::need`] at run time.
//!
//! A [`DepthGate`] limits the depths of the beamformer. Other depths are DAS.
//!
//! A line is computed in blocks ([`Parameters::block`]), so that its memory does not grow with its length. The bits do
//! not depend on the block length.
//!
//! Each stage can be used alone: [`LinePipeline`] delays and beamforms lines, [`BMode`] makes images of lines,
//! [`PhaseSymmetry`] bone maps of images, and a [`Detector`](crate::surface::Detector) finds the surface in grey
//! levels of lines.

mod block;
mod coherence;
mod coherence_map;
mod cuts;
mod depth_gate;
mod frame;
mod lanes;
mod line;
mod memory;
mod output;

pub use block::Block;
pub use depth_gate::DepthGate;
pub use frame::Frame;
pub use line::{IqInput, LinePipeline};

use crate::beamform::{self, ShortLagCoherence};
use crate::delay::{Delay, DelayParameters, IqDelay, Stage};
use crate::error::{at_least_one, attempt, check_length};
use crate::geometry::{Axis, Lines, Scan, ScanParameters, SteeringTable};
use crate::image::{BMode, BModeParameters, DepthInterpolation, Logarithm, PixelGrid};
use crate::memory::Need;
use crate::phase_symmetry::{self, PhaseSymmetry};
use crate::{Complex, Error};
pub(crate) use memory::FrameLayout;

/// Parameters of a [`Pipeline`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters<'a> {
    /// The geometry. An image needs evenly spaced lines.
    pub scan: ScanParameters<'a>,
    /// The beamformer.
    pub beamformer: beamform::Parameters,
    /// Rows of the image, pixels.
    ///
    /// The image is the smallest grid of isotropic pixels that covers the scan. Phase symmetry accepts 64, 128,
    /// 256, 512 or 1024 rows.
    pub rows: usize,
    /// Columns of the image, pixels; the same sizes as for the rows.
    pub columns: usize,
    /// Level of black below the largest envelope, dB.
    pub dynamic_range: f32,
    /// Whether a 3×3 median filters the image.
    pub median: bool,
    /// Phase symmetry: centre frequencies `r₀` of the filters, cycles per pixel.
    pub scales: &'a [f64],
    /// Phase symmetry: noise threshold `T_n`, in grey levels.
    pub threshold: f32,
    /// Phase symmetry: rows or columns of a strip of [`Pipeline::phase_symmetry`].
    ///
    /// The number changes memory and time, never the map. A [`Frame`] has the whole image in one memory, for any strip.
    pub strip: usize,
    /// Number of samples of a line that are aligned and beamformed at a time.
    ///
    /// At least the time window, at most the whole line. The number changes memory and time, never the line.
    pub block: usize,
}

impl Parameters<'_> {
    /// A small pipeline for examples.
    ///
    /// It has [`ScanParameters::EXAMPLE`], an image of 64 × 64 pixels and one scale.
    pub const EXAMPLE: Parameters<'static> = Parameters {
        scan: ScanParameters::EXAMPLE,
        beamformer: beamform::Parameters::DEFAULT,
        rows: 64,
        columns: 64,
        dynamic_range: 50.0,
        median: true,
        scales: &[0.125],
        threshold: 10.0,
        strip: 8,
        block: 64,
    };

    /// Checks all values; a `const` can call it, and [`Parameters::need`] does.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::Capacity`], naming the parameter that is out of range: as [`Scan::new`] or, for
    /// I/Q, [`Scan::of_iq`]; [`DelayParameters::check`] of RF; [`beamform::Parameters::check`]; [`BModeParameters::check`];
    /// [`phase_symmetry::Parameters::check`]; for lines that are not evenly spaced, for `min_elements` beyond the
    /// array's, and for a block of 0 samples.
    pub const fn check(&self, input: Input) -> Result<(), Error> {
        let scan = match input {
            Input::Rf => {
                let scan = attempt!(Scan::new(self.scan));
                attempt!(DelayParameters::of(&scan).check());
                scan
            }
            Input::Iq => attempt!(Scan::of_iq(self.scan)),
        };
        attempt!(self.beamformer.check());
        attempt!(attempt!(self.b_mode(&scan)).check());
        attempt!(self.phase_symmetry().check());
        self.check_own()
    }

    /// Checks what no stage checks.
    const fn check_own(&self) -> Result<(), Error> {
        attempt!(even(&self.scan.lines));
        if self.scan.min_elements > self.scan.array.elements() {
            let value = self.scan.min_elements as f64;
            let expected = "at most the number of elements";
            return Err(Error::parameter("min_elements", value, expected));
        }
        at_least_one("block", self.block)
    }

    /// The image, from evenly spaced lines.
    const fn b_mode(&self, scan: &Scan<'_>) -> Result<BModeParameters, Error> {
        let (lines, samples) = (attempt!(even(&self.scan.lines)), scan.depths());
        Ok(BModeParameters {
            lines,
            samples,
            grid: PixelGrid::of_lines(&lines, &samples, self.rows, self.columns),
            dynamic_range: self.dynamic_range,
            logarithm: Logarithm::Exact,
            median: self.median,
        })
    }

    const fn phase_symmetry(&self) -> phase_symmetry::Parameters<'_> {
        phase_symmetry::Parameters {
            sizes: self.strips(),
            scales: self.scales,
            threshold: self.threshold,
        }
    }
}

/// Kind of records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Input {
    /// RF.
    Rf,
    /// I/Q.
    Iq,
}

/// The plan of all stages.
///
/// ```
/// use bonebeam::prelude::*;
///
/// let pipeline = Pipeline::new(Parameters::EXAMPLE)?;
/// assert_eq!(pipeline.lines().scan().samples(), 208);
/// assert_eq!(pipeline.b_mode().parameters().grid.z0, 4e-3);
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pipeline<'a, D = Delay> {
    lines: LinePipeline<'a, D>,
    interpolation: DepthInterpolation,
    b_mode: BMode,
    phase_symmetry: PhaseSymmetry,
    parts: FrameLayout,
    /// Directions of sub-lines, if there are any.
    directions: Option<SteeringTable<'a>>,
    /// Samples of a line that are beamformed at a time.
    block: usize,
}

impl<'a> Pipeline<'a> {
    /// A pipeline of RF: validates the parameters and computes the tables.
    ///
    /// # Errors
    /// As [`Parameters::check`] and [`LinePipeline::new`].
    pub fn new(parameters: Parameters<'a>) -> Result<Self, Error> {
        let scan = Scan::new(parameters.scan)?;
        parameters.check_own()?;
        let lines = LinePipeline::new(scan, parameters.beamformer)?;
        Self::of_lines(lines, parameters, parameters.parts(Input::Rf, 1)?)
    }
}

impl<'a> Pipeline<'a, &'a Delay> {
    /// A pipeline of RF with a delay stage elsewhere, such as a constant in flash.
    ///
    /// The filters of the stage are not computed again, and the plan is small.
    ///
    /// ```
    /// use bonebeam::prelude::stages::*;
    ///
    /// const PARAMETERS: Parameters = Parameters::EXAMPLE;
    /// const SCAN: Scan = valid!(Scan::new(PARAMETERS.scan));
    /// static DELAY: Delay = valid!(Delay::new(DelayParameters::of(&SCAN)));
    /// let pipeline = Pipeline::by(&DELAY, PARAMETERS)?;
    /// assert!(size_of_val(&pipeline) < 2000 && size_of_val(&DELAY) > 10_000);
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Pipeline::new`]; [`Error::Parameter`] if the stage does not match the scan.
    pub fn by(delay: &'a Delay, parameters: Parameters<'a>) -> Result<Self, Error> {
        let scan = Scan::new(parameters.scan)?;
        parameters.check_own()?;
        let lines = LinePipeline::by(delay, scan, parameters.beamformer)?;
        Self::of_lines(lines, parameters, parameters.parts(Input::Rf, 1)?)
    }
}

impl<'a> Pipeline<'a, IqDelay> {
    /// A pipeline of I/Q.
    ///
    /// ```
    /// use bonebeam::prelude::*;
    ///
    /// let parameters = Parameters {
    ///     scan: ScanParameters {
    ///         sampling_rate: 10e6,
    ///         record_samples: 256,
    ///         output_rate: 10e6,
    ///         ..ScanParameters::EXAMPLE
    ///     },
    ///     ..Parameters::EXAMPLE
    /// };
    /// let iq = IqInput { demodulation_frequency: 5e6, interpolation: None };
    /// let pipeline = Pipeline::of_iq(parameters, iq)?;
    /// assert_eq!(pipeline.lines().scan().samples(), 104);
    /// assert_eq!(pipeline.need(1), parameters.need(Input::Iq, 1)?);
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Pipeline::new`], with [`Scan::of_iq`] and [`LinePipeline::of_iq`].
    pub fn of_iq(parameters: Parameters<'a>, iq: IqInput) -> Result<Self, Error> {
        let scan = Scan::of_iq(parameters.scan)?;
        parameters.check_own()?;
        let lines = LinePipeline::of_iq(scan, iq, parameters.beamformer)?;
        Self::of_lines(lines, parameters, parameters.parts(Input::Iq, 1)?)
    }
}

impl<'a, D: Stage> Pipeline<'a, D> {
    fn of_lines(
        of_scan: LinePipeline<'a, D>,
        parameters: Parameters<'a>,
        parts: FrameLayout,
    ) -> Result<Self, Error> {
        let b_mode = parameters.b_mode(of_scan.scan())?;
        let step = of_scan.beamformer().parameters().depth_step;
        Ok(Pipeline {
            interpolation: DepthInterpolation::of(of_scan.scan(), step)?,
            lines: of_scan,
            b_mode: BMode::new(b_mode)?,
            phase_symmetry: PhaseSymmetry::new(&parameters.phase_symmetry())?,
            parts,
            directions: None,
            block: parameters.block,
        })
    }

    /// The same plan, with the directions of its sub-lines.
    ///
    /// [`LinePipeline::directions`] computes them. They are kept for each plan, in memory or in flash: frames of
    /// several plans that share one memory compute none anew.
    ///
    /// ```
    /// use bonebeam::{beamform, prelude::*};
    ///
    /// const PARAMETERS: Parameters = Parameters {
    ///     beamformer: beamform::Parameters { sub_lines: 2, ..beamform::Parameters::DEFAULT },
    ///     ..Parameters::EXAMPLE
    /// };
    /// let mut directions = [Complex::new(0.0, 0.0); valid!(PARAMETERS.directions_len())];
    /// let pipeline = Pipeline::new(PARAMETERS)?;
    /// pipeline.lines().directions(&mut directions)?;
    /// let pipeline = pipeline.with_directions(&directions)?;
    /// # let need = pipeline.need(1);
    /// # let (mut real, mut complex) = (vec![0.0; need.real], vec![Complex::new(0.0, 0.0); need.complex]);
    /// let frame = Frame::new(&pipeline, Scratch::new(&mut real, &mut complex))?;
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Length`] unless they have [`Parameters::directions_len`] numbers.
    pub fn with_directions(self, directions: &'a [Complex<f32>]) -> Result<Self, Error> {
        let length = self.lines.directions_len();
        check_length("directions", directions.len(), length)?;
        let p = self.lines.beamformer().parameters();
        let of = (p.sub_lines, p.depth_step);
        Ok(Pipeline {
            directions: match length {
                0 => None,
                _ => Some(SteeringTable::of(self.lines.scan(), of, directions)?),
            },
            ..self
        })
    }

    /// The same plan, with the beamformer within `gate` only, and DAS elsewhere.
    ///
    /// # Errors
    /// As [`DepthGate::samples`].
    pub fn with_gate(self, gate: DepthGate) -> Result<Self, Error> {
        Ok(Pipeline {
            lines: self.lines.with_gate(gate)?,
            ..self
        })
    }

    /// Plan of the lines, from RF or I/Q.
    pub fn lines(&self) -> &LinePipeline<'a, D> {
        &self.lines
    }

    /// Plan of the envelopes at all samples, from lines with a depth step.
    pub fn interpolation(&self) -> &DepthInterpolation {
        &self.interpolation
    }

    /// Plan of the image, from envelopes.
    pub fn b_mode(&self) -> &BMode {
        &self.b_mode
    }

    /// Plan of the bone map, from the image.
    pub fn phase_symmetry(&self) -> &PhaseSymmetry {
        &self.phase_symmetry
    }

    /// Memory of a [`Frame`], with lines by vectors of `lanes` lanes.
    ///
    /// `lanes` is 1, or the number of lanes of [`Frame::line_over`].
    ///
    /// The beamformer's workspace of [`Frame::line_over`] is not included.
    pub fn need(&self, lanes: usize) -> Need {
        let line = self.lines.need(lanes, self.block);
        self.parts.need_over(line)
    }

    /// Length of the memory of [`Frame::with_coherence`]: [`Parameters::coherence_len`].
    pub fn coherence_len(&self, coherence: ShortLagCoherence) -> usize {
        self.parts.coherence_len(coherence)
    }
}

const fn even(lines: &Lines) -> Result<Axis, Error> {
    match *lines {
        Lines::Even(axis) => Ok(axis),
        _ => Err(Error::parameter(
            "lines",
            lines.count() as f64,
            "evenly spaced lines, for an image",
        )),
    }
}
