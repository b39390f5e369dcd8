//! Memory of a frame.

use super::{Parameters, coherence_map, even};
use crate::Error;
use crate::beamform::{self, ShortLagCoherence};
use crate::delay::{DelayParameters, IqParameters};
use crate::geometry::{Scan, SteeringTable};
use crate::image::DepthInterpolation;
use crate::memory::Need;
use crate::phase_symmetry;
use crate::surface::{self, Settings};

/// Division of a frame's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct Parts {
    /// Samples of a line.
    pub(super) samples: usize,
    /// Samples that its beamformer computes.
    pub(super) line_samples: usize,
    /// Memory of the image's interpolation of lines.
    pub(super) interpolation: Need,
    /// Sub-lines of a line.
    pub(super) sub_lines: usize,
    /// The directions of all sub-lines, if there are any.
    pub(super) steering: usize,
    /// Samples of all lines.
    pub(super) envelopes: usize,
    /// The delay stage and the aligned samples of a line.
    pub(super) line: Need,
    /// The beamformer.
    pub(super) beamformer: beamform::Sizes,
    /// Grey levels of all lines, and the pixels before the median.
    pub(super) b_mode: usize,
    /// The image's size and the strip height.
    pub(super) strips: phase_symmetry::Sizes,
}

impl Parameters<'_> {
    /// Memory of a [`Frame`](super::Frame) of RF, for a `static`:
    ///
    /// ```
    /// # use bonebeam::beamform;
    /// # use bonebeam::geometry::{Array, Axis, Depth, Lines, ScanParameters};
    /// use bonebeam::memory::{Memory, Need};
    /// use bonebeam::pipeline::Parameters;
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
    /// #   beamformer: beamform::Parameters {
    /// #       temporal_half_window: 1,
    /// #       ..beamform::Parameters::DEFAULT
    /// #   },
    /// #   rows: 64,
    /// #   columns: 64,
    /// #   dynamic_range: 50.0,
    /// #   median: true,
    /// #   scales: &[0.125],
    /// #   threshold: 10.0,
    /// #   strip: 8,
    /// #   block: usize::MAX,
    /// };
    /// const NEED: Need = match PARAMETERS.need() {
    ///     Ok(need) => need,
    ///     Err(_) => panic!("the scan is not valid"),
    /// };
    /// static MEMORY: Memory<{ NEED.real }, { NEED.complex }> = Memory::new();
    /// ```
    ///
    /// # Errors
    /// As [`Scan::new`].
    pub const fn need(&self) -> Result<Need, Error> {
        match self.parts() {
            Ok(parts) => Ok(parts.need()),
            Err(error) => Err(error),
        }
    }

    /// Memory of a frame of I/Q.
    ///
    /// # Errors
    /// As [`Scan::of_iq`].
    pub const fn need_of_iq(&self) -> Result<Need, Error> {
        match self.parts_of_iq() {
            Ok(parts) => Ok(parts.need()),
            Err(error) => Err(error),
        }
    }

    /// Memory of a frame of RF with lines by vectors, for a `static`.
    ///
    /// The vectors have `lanes` lanes: see [`Pipeline::need_over`].
    ///
    /// # Errors
    /// As [`Scan::new`].
    ///
    /// [`Pipeline::need_over`]: super::Pipeline::need_over
    pub const fn need_over(&self, lanes: usize) -> Result<Need, Error> {
        match (self.parts(), self.parts_over(lanes)) {
            (Ok(parts), Ok(over)) => Ok(parts.need_over(over.line)),
            (Err(error), _) | (_, Err(error)) => Err(error),
        }
    }

    /// [`Parameters::need_over`] of a frame of I/Q.
    ///
    /// # Errors
    /// As [`Scan::of_iq`].
    pub const fn need_over_of_iq(&self, lanes: usize) -> Result<Need, Error> {
        match (self.parts_of_iq(), self.parts_of_iq_over(lanes)) {
            (Ok(parts), Ok(over)) => Ok(parts.need_over(over.line)),
            (Err(error), _) | (_, Err(error)) => Err(error),
        }
    }

    pub(super) const fn parts(&self) -> Result<Parts, Error> {
        self.parts_over(1)
    }

    pub(super) const fn parts_of_iq(&self) -> Result<Parts, Error> {
        self.parts_of_iq_over(1)
    }

    /// The parts with the delay stage's memory for vectors.
    const fn parts_over(&self, lanes: usize) -> Result<Parts, Error> {
        match Scan::new(self.scan) {
            Ok(scan) => {
                let delay = DelayParameters::of(&scan);
                let scratch = delay.block_need(lanes, self.buffered(&scan));
                Ok(self.parts_of(&scan, scratch))
            }
            Err(error) => Err(error),
        }
    }

    const fn parts_of_iq_over(&self, lanes: usize) -> Result<Parts, Error> {
        match Scan::of_iq(self.scan) {
            Ok(scan) => {
                // The same for every frequency.
                let scratch = IqParameters::of(&scan, 0.0).need(lanes);
                Ok(self.parts_of(&scan, scratch))
            }
            Err(error) => Err(error),
        }
    }

    /// Parameters of a surface [`Detector`](crate::surface::Detector) for these lines.
    ///
    /// They are for the surface of a whole frame: [`Frame::surface`](super::Frame::surface).
    ///
    /// # Errors
    /// As [`Scan::new`]; [`Error::Parameter`] for lines that are not evenly spaced.
    pub const fn surface(&self, settings: Settings) -> Result<surface::Parameters, Error> {
        // For I/Q the samples are at the same depths.
        let scan = match Scan::of_iq(self.scan) {
            Ok(scan) => scan,
            Err(error) => return Err(error),
        };
        let lines = match even(&self.scan.lines) {
            Ok(lines) => lines,
            Err(error) => return Err(error),
        };
        Ok(surface::Parameters {
            samples: scan.depths(),
            spacing: lines.step,
            settings,
            latency: lines.count.saturating_sub(1),
        })
    }

    /// Length of the memory of [`Frame::with_coherence`](super::Frame::with_coherence).
    ///
    /// `2·(2K + 1)` numbers for a time window of `2K + 1` samples, and a byte for each sample of all lines and one.
    ///
    /// # Errors
    /// As [`Scan::new`].
    pub const fn coherence_len(&self, coherence: ShortLagCoherence) -> Result<usize, Error> {
        // A frame of RF has as many samples.
        match self.parts_of_iq() {
            Ok(parts) => Ok(parts.coherence_len(coherence)),
            Err(error) => Err(error),
        }
    }

    /// Aligned samples in memory at a time.
    const fn buffered(&self, scan: &Scan<'_>) -> usize {
        let half_window = self.beamformer.temporal_half_window;
        buffered(scan.samples(), half_window, self.block)
    }

    const fn parts_of(&self, scan: &Scan<'_>, delay: Need) -> Parts {
        let elements = scan.elements();
        let envelopes = scan.lines().saturating_mul(scan.samples());
        let strips = self.strips();
        let sub_lines = self.beamformer.sub_lines;
        let line_samples = self.beamformer.line_samples(scan.samples());
        let step = self.beamformer.depth_step;
        let interpolation = DepthInterpolation::need_of(line_samples, step, sub_lines);
        let steering = SteeringTable::need(scan.lines(), line_samples, sub_lines).complex;
        let before_median = if self.median { strips.image_len() } else { 0 };
        Parts {
            samples: scan.samples(),
            line_samples,
            interpolation,
            sub_lines,
            steering: if sub_lines > 1 { steering } else { 0 },
            envelopes,
            line: delay.and(Need {
                real: 0,
                complex: elements.saturating_mul(self.buffered(scan)),
            }),
            beamformer: self.beamformer.sizes(elements),
            b_mode: envelopes.saturating_add(before_median),
            strips,
        }
    }

    /// The image's size and the strip height, as phase symmetry has them.
    pub(super) const fn strips(&self) -> phase_symmetry::Sizes {
        phase_symmetry::Sizes {
            rows: self.rows,
            columns: self.columns,
            strip: self.strip,
        }
    }
}

impl Parts {
    /// [`Parts::need`], or that of lines by vectors, whose workspace is apart.
    pub(super) const fn need_over(self, line: Need) -> Need {
        let beamformer = beamform::Sizes {
            covariance: self.beamformer.covariance,
            elements: 0,
            subaperture: 0,
            temporal_half_window: 0,
            sub_lines: 0,
        };
        let of_lines = Parts {
            line,
            beamformer,
            ..self
        };
        of_lines.need().or(self.need())
    }

    pub(super) const fn need(&self) -> Need {
        // Apertures; envelopes, image and map, which pass from stage to stage.
        let images = self.strips.image_len().saturating_mul(2);
        let lines = self.envelopes.saturating_add(self.samples);
        let kept = Need {
            real: lines.saturating_add(images),
            complex: self.steering,
        };
        let line = Need {
            real: 0,
            complex: self.line_samples.saturating_mul(self.sub_lines),
        };
        let beamformed = self.line.and(self.beamformer.need());
        let line = line.and(beamformed.or(self.interpolation));
        let work = line.or(Need::real(self.b_mode)).or(self.strips.map_need());
        kept.and(work.or(Need::real(self.grey())))
    }

    pub(super) const fn coherence_len(&self, coherence: ShortLagCoherence) -> usize {
        coherence_map::len(coherence, self.samples, self.envelopes)
    }

    /// Grey levels of a line as real numbers, and of all as integers of eight bits.
    const fn grey(&self) -> usize {
        self.samples.saturating_add(self.envelopes.div_ceil(4))
    }
}

/// Number of aligned samples in memory for an output block of `block` samples, of `2K + 1` at least.
pub(super) const fn buffered(samples: usize, half_window: usize, block: usize) -> usize {
    let margins = half_window.saturating_mul(2);
    let window = margins.saturating_add(1);
    let outputs = if block < window { window } else { block };
    let buffered = outputs.saturating_add(margins);
    if buffered < samples {
        buffered
    } else {
        samples
    }
}
