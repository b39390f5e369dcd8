//! From the RF or the I/Q of transmits to lines, an image, a bone map and the bone surface, in fixed memory.
//!
//! A [`Pipeline`] is a plan: validated parameters and the tables that follow from them. It works in no
//! memory of its own, so that it can be shared between threads. A [`Frame`] is a plan with memory: RF or
//! I/Q goes in line by line, an image and a bone map come out. [`Parameters::need`] is its memory, known when the
//! program is compiled; [`Pipeline::need`] is the same at run time.
//!
//! A [`DepthGate`] bounds the depths in which the beamformer works: elsewhere is DAS.
//!
//! A line is worked out in blocks ([`Parameters::block`]), so that the memory for it does not grow with
//! it. The bits are the same for all blocks.
//!
//! Each stage can be used by itself: [`LinePipeline`] delays and beamforms lines,
//! [`BMode`] makes images of them, [`PhaseSymmetry`] bone maps of images, a
//! [`Detector`](crate::surface::Detector) finds the surface in grey levels of lines.

mod block;
mod cuts;
mod depth_gate;
mod frame;
mod line;
mod memory;

pub use block::Block;
pub use depth_gate::DepthGate;
pub use frame::Frame;
pub use line::{IqInput, LinePipeline};

use crate::Error;
use crate::beamform;
use crate::covariance::Covariance;
use crate::delay::{Delay, IqDelay, Stage};
use crate::geometry::{Axis, Lines, Scan, ScanParameters};
use crate::image::{BMode, BModeParameters, DepthInterpolation, Logarithm, PixelGrid};
use crate::memory::Need;
use crate::phase_symmetry::{self, PhaseSymmetry};
pub(crate) use memory::Parts;

/// What a [`Pipeline`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters<'a> {
    /// The geometry. An image needs evenly spaced lines.
    pub scan: ScanParameters<'a>,
    /// The beamformer.
    pub beamformer: beamform::Parameters,
    /// Rows of the image, pixels: the whole scan on the smallest grid of isotropic pixels that covers
    /// it. Phase symmetry takes 64, 128, 256, 512 or 1024.
    pub rows: usize,
    /// Columns of the image, likewise.
    pub columns: usize,
    /// How far below the largest envelope black is, dB.
    pub dynamic_range: f32,
    /// Whether the image goes through the 3×3 median.
    pub median: bool,
    /// Phase symmetry: the characteristic radii `r₀` of the filters, cycles per pixel.
    pub scales: &'a [f64],
    /// Phase symmetry: the noise threshold `T_n`, in grey levels.
    pub threshold: f32,
    /// Phase symmetry by [`Pipeline::phase_symmetry`]: how many rows or columns are worked on at a time. It changes
    /// memory and time, never the map. A [`Frame`] has all in one memory, whatever the strips.
    pub strip: usize,
    /// How many samples of a line are focused and beamformed at a time: as many as the time window at least, the
    /// whole line at most. It changes memory and time, never the line.
    pub block: usize,
}

/// The plan of all stages.
///
/// ```
/// # use bonebeam::Error;
/// use bonebeam::beamform;
/// use bonebeam::geometry::{Array, Axis, Depth, Lines, ScanParameters};
/// use bonebeam::pipeline::{Parameters, Pipeline};
///
/// let pipeline = Pipeline::new(Parameters {
///     scan: ScanParameters {
///         array: Array::Linear { elements: 16, pitch: 0.3e-3 },
///         lines: Lines::Even(Axis::centred(64, 0.1e-3)),
///         sound_speed: 1540.0,
///         centre_frequency: 5e6,
///         sampling_rate: 20e6,
///         record_samples: 512,
///         output_rate: 20e6,
///         start: Depth::Metres(4e-3),
///         end: Depth::Metres(12e-3),
///         f_number: 1.5,
///         min_elements: 8,
///     },
///     beamformer: beamform::Parameters::default(),
///     rows: 64,
///     columns: 64,
///     dynamic_range: 50.0,
///     median: true,
///     scales: &[0.125, 0.0625],
///     threshold: 10.0,
///     strip: 8,
///     block: 64,
/// })?;
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
    parts: Parts,
}

impl<'a> Pipeline<'a> {
    /// A pipeline of RF: validates the parameters and works out the tables.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::Capacity`], naming the parameter that is out of range: as
    /// [`Scan::new`], [`LinePipeline::new`], [`BMode::new`] and [`PhaseSymmetry::new`]; for lines that
    /// are not evenly spaced.
    pub fn new(parameters: Parameters<'a>) -> Result<Self, Error> {
        let scan = Scan::new(parameters.scan)?;
        even(&parameters.scan.lines)?;
        let lines = LinePipeline::new(scan, parameters.beamformer)?;
        Self::of_lines(lines, parameters, parameters.parts()?)
    }
}

impl<'a> Pipeline<'a, &'a Delay> {
    /// A pipeline of RF by a delay stage that lies elsewhere, as a constant does in flash: nothing is left to be
    /// worked out, and the plan is small.
    ///
    /// ```
    /// # use bonebeam::beamform;
    /// # use bonebeam::geometry::{Array, Axis, Depth, Lines, ScanParameters};
    /// use bonebeam::delay::{Delay, DelayParameters};
    /// use bonebeam::geometry::Scan;
    /// use bonebeam::pipeline::{Parameters, Pipeline};
    ///
    /// const PARAMETERS: Parameters = Parameters {
    ///     // …
    /// #   scan: ScanParameters {
    /// #       array: Array::Linear { elements: 16, pitch: 0.3e-3 },
    /// #       lines: Lines::Even(Axis::centred(64, 0.1e-3)),
    /// #       sound_speed: 1540.0,
    /// #       centre_frequency: 5e6,
    /// #       sampling_rate: 20e6,
    /// #       record_samples: 512,
    /// #       output_rate: 20e6,
    /// #       start: Depth::Metres(4e-3),
    /// #       end: Depth::Metres(12e-3),
    /// #       f_number: 1.5,
    /// #       min_elements: 8,
    /// #   },
    /// #   beamformer: beamform::Parameters::DEFAULT,
    /// #   rows: 64,
    /// #   columns: 64,
    /// #   dynamic_range: 50.0,
    /// #   median: true,
    /// #   scales: &[0.125],
    /// #   threshold: 10.0,
    /// #   strip: 8,
    /// #   block: 64,
    /// };
    /// const SCAN: Scan = match Scan::new(PARAMETERS.scan) {
    ///     Ok(scan) => scan,
    ///     Err(_) => panic!("the scan is not valid"),
    /// };
    /// static DELAY: Delay = match Delay::new(DelayParameters::of(&SCAN)) {
    ///     Ok(delay) => delay,
    ///     Err(_) => panic!("the scan is not valid"),
    /// };
    /// let pipeline = Pipeline::by(&DELAY, PARAMETERS)?;
    /// assert!(size_of_val(&pipeline) < 2000 && size_of_val(&DELAY) > 10_000);
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Pipeline::new`]; [`Error::Parameter`] where the stage is not the scan's.
    pub fn by(delay: &'a Delay, parameters: Parameters<'a>) -> Result<Self, Error> {
        let scan = Scan::new(parameters.scan)?;
        even(&parameters.scan.lines)?;
        let lines = LinePipeline::by(delay, scan, parameters.beamformer)?;
        Self::of_lines(lines, parameters, parameters.parts()?)
    }
}

impl<'a> Pipeline<'a, IqDelay> {
    /// A pipeline of I/Q.
    ///
    /// ```
    /// # use bonebeam::Error;
    /// use bonebeam::beamform;
    /// use bonebeam::covariance::Covariance;
    /// use bonebeam::geometry::{Array, Axis, Depth, Lines, ScanParameters};
    /// use bonebeam::pipeline::{IqInput, Parameters, Pipeline};
    ///
    /// let parameters = Parameters {
    ///     scan: ScanParameters {
    ///         array: Array::Linear { elements: 16, pitch: 0.3e-3 },
    ///         lines: Lines::Even(Axis::centred(64, 0.1e-3)),
    ///         sound_speed: 1540.0,
    ///         centre_frequency: 5e6,
    ///         sampling_rate: 10e6,
    ///         record_samples: 256,
    ///         output_rate: 10e6,
    ///         start: Depth::Metres(4e-3),
    ///         end: Depth::Metres(12e-3),
    ///         f_number: 1.5,
    ///         min_elements: 8,
    ///     },
    ///     beamformer: beamform::Parameters::default(),
    ///     rows: 64,
    ///     columns: 64,
    ///     dynamic_range: 50.0,
    ///     median: true,
    ///     scales: &[0.125, 0.0625],
    ///     threshold: 10.0,
    ///     strip: 8,
    ///     block: 32,
    /// };
    /// let iq = IqInput { demodulation_frequency: 5e6, interpolation: None };
    /// let pipeline = Pipeline::of_iq(parameters, iq)?;
    /// assert_eq!(pipeline.lines().scan().samples(), 104);
    /// let covariance = Covariance::ForwardBackward;
    /// assert_eq!(pipeline.need(covariance), parameters.need_of_iq(covariance)?);
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Pipeline::new`], with [`Scan::of_iq`] and [`LinePipeline::of_iq`].
    pub fn of_iq(parameters: Parameters<'a>, iq: IqInput) -> Result<Self, Error> {
        let scan = Scan::of_iq(parameters.scan)?;
        even(&parameters.scan.lines)?;
        let lines = LinePipeline::of_iq(scan, iq, parameters.beamformer)?;
        Self::of_lines(lines, parameters, parameters.parts_of_iq()?)
    }
}

impl<'a, D: Stage> Pipeline<'a, D> {
    fn of_lines(
        of_scan: LinePipeline<'a, D>,
        parameters: Parameters<'a>,
        parts: Parts,
    ) -> Result<Self, Error> {
        let (lines, samples) = (even(&parameters.scan.lines)?, of_scan.scan().depths());
        let (rows, columns) = (parameters.rows, parameters.columns);
        let step = of_scan.beamformer().parameters().depth_step;
        Ok(Pipeline {
            interpolation: DepthInterpolation::of(of_scan.scan(), step)?,
            lines: of_scan,
            b_mode: BMode::new(BModeParameters {
                lines,
                samples,
                grid: PixelGrid::of_lines(&lines, &samples, rows, columns),
                dynamic_range: parameters.dynamic_range,
                logarithm: Logarithm::Exact,
                median: parameters.median,
            })?,
            phase_symmetry: PhaseSymmetry::new(&phase_symmetry::Parameters {
                sizes: parameters.strips(),
                scales: parameters.scales,
                threshold: parameters.threshold,
            })?,
            parts,
        })
    }

    /// The same plan with adaptive beamforming within `gate` only, and DAS elsewhere.
    ///
    /// # Errors
    /// As [`DepthGate::samples`].
    pub fn with_gate(self, gate: DepthGate) -> Result<Self, Error> {
        Ok(Pipeline {
            lines: self.lines.with_gate(gate)?,
            ..self
        })
    }

    /// RF or I/Q → lines.
    pub fn lines(&self) -> &LinePipeline<'a, D> {
        &self.lines
    }

    /// Lines with a depth step → envelopes at all samples.
    pub fn interpolation(&self) -> &DepthInterpolation {
        &self.interpolation
    }

    /// Lines → image.
    pub fn b_mode(&self) -> &BMode {
        &self.b_mode
    }

    /// Image → bone map.
    pub fn phase_symmetry(&self) -> &PhaseSymmetry {
        &self.phase_symmetry
    }

    /// The memory that a [`Frame`] works in, by the averaging of its beamformer.
    pub fn need(&self, covariance: Covariance) -> Need {
        self.parts.need(covariance)
    }
}

const fn even(lines: &Lines) -> Result<Axis, Error> {
    match *lines {
        Lines::Even(axis) => Ok(axis),
        _ => Err(Error::Parameter {
            name: "lines",
            value: lines.count() as f64,
            expected: "evenly spaced lines, for an image",
        }),
    }
}
