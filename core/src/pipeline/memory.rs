//! The memory of a frame.

use super::line::buffered;
use super::{LineLengths, Parameters};
use crate::delay::{DelayParameters, IqParameters};
use crate::geometry::Scan;
use crate::phase_symmetry::{self, LogGabor};
use crate::{Complex, Error};

/// The sizes that follow from [`Parameters`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sizes {
    /// Active elements that a beamformer's workspace must hold, M.
    pub elements: usize,
    /// The longest subaperture, up to full fours, L.
    pub subaperture: usize,
    /// The temporal half-window, K.
    pub temporal_half_window: usize,
    /// Length of [`MemoryView::real`].
    pub real: usize,
    /// Length of [`MemoryView::complex`].
    pub complex: usize,
    pub(super) parts: Parts,
}

/// How the memory is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Parts {
    /// The envelopes of all lines.
    pub(super) envelopes: usize,
    /// The aperture's width at each sample.
    pub(super) widths: usize,
    pub(super) pixels: usize,
    /// What a line is worked out in.
    pub(super) line: LineLengths,
    /// Grey levels of all lines, and the pixels before the median.
    pub(super) b_mode: usize,
    pub(super) spectrum: usize,
    pub(super) strip: usize,
    /// The longer side of the image.
    pub(super) side: usize,
    pub(super) samples: usize,
}

impl Parameters<'_> {
    /// The sizes of a frame's memory, so that those of statics follow from a `const`:
    ///
    /// ```
    /// # use bonebeam::beamform;
    /// # use bonebeam::geometry::{Array, Axis, Depth, Lines, ScanParameters};
    /// use bonebeam::pipeline::{Memory, Parameters, Sizes};
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
    /// const SIZES: Sizes = match PARAMETERS.sizes() {
    ///     Ok(sizes) => sizes,
    ///     Err(_) => panic!("the scan is not valid"),
    /// };
    /// static MEMORY: Memory<{ SIZES.real }, { SIZES.complex }> = Memory::new();
    /// assert_eq!((SIZES.elements, SIZES.subaperture, SIZES.temporal_half_window), (16, 8, 1));
    /// ```
    ///
    /// # Errors
    /// As [`Scan::new`].
    pub const fn sizes(&self) -> Result<Sizes, Error> {
        match Scan::new(self.scan) {
            Ok(scan) => {
                let delay = DelayParameters::of(&scan);
                let scratch = delay.block_scratch_len(1, self.buffered(&scan));
                Ok(self.sizes_of(&scan, scratch))
            }
            Err(error) => Err(error),
        }
    }

    /// The sizes of a frame's memory where the records are I/Q.
    ///
    /// # Errors
    /// As [`Scan::of_iq`].
    pub const fn sizes_of_iq(&self) -> Result<Sizes, Error> {
        match Scan::of_iq(self.scan) {
            Ok(scan) => {
                // The same for every frequency.
                let scratch = IqParameters::of(&scan, 0.0).scratch_len(1);
                Ok(self.sizes_of(&scan, scratch))
            }
            Err(error) => Err(error),
        }
    }

    /// Aligned samples in memory at a time.
    const fn buffered(&self, scan: &Scan<'_>) -> usize {
        let half_window = self.beamformer.temporal_half_window;
        buffered(scan.samples(), half_window, self.block)
    }

    const fn sizes_of(&self, scan: &Scan<'_>, scratch: usize) -> Sizes {
        let elements = scan.elements();
        let strips = self.strips();
        let pixels = self.rows.saturating_mul(self.columns);
        let envelopes = scan.lines().saturating_mul(scan.samples());
        let before_median = if self.median { pixels } else { 0 };
        let parts = Parts {
            envelopes,
            widths: scan.samples(),
            pixels,
            line: LineLengths {
                scratch,
                aligned: elements.saturating_mul(self.buffered(scan)),
            },
            b_mode: envelopes.saturating_add(before_median),
            spectrum: strips.spectrum_len(),
            strip: strips.strip_len(),
            side: strips.line_len(),
            samples: scan.samples(),
        };
        // The cast rounds down.
        let subaperture = (self.beamformer.subaperture_ratio * elements as f64) as usize;
        let fours = larger(subaperture, 1).div_ceil(4);
        let line = parts.line.aligned.saturating_add(parts.samples);
        Sizes {
            elements,
            subaperture: fours.saturating_mul(4),
            temporal_half_window: self.beamformer.temporal_half_window,
            real: parts.kept().saturating_add(parts.work()),
            complex: larger(line, strips.line_len()),
            parts,
        }
    }
}

impl Parameters<'_> {
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
    /// What is kept: apertures; from one stage to the next envelopes, image and map.
    const fn kept(&self) -> usize {
        let images = self.pixels.saturating_mul(2);
        let lines = self.envelopes.saturating_add(self.widths);
        lines.saturating_add(images)
    }

    /// What the stages work in, one after the other.
    const fn work(&self) -> usize {
        larger(larger(self.line.scratch, self.b_mode), self.bone_map())
    }

    /// Phase symmetry's spectrum, filtered image, denominator, two strips and gains.
    const fn bone_map(&self) -> usize {
        let images = self.pixels.saturating_mul(3);
        let strips = self.strip.saturating_mul(2);
        let whole = self.spectrum.saturating_add(images);
        whole.saturating_add(strips).saturating_add(self.side)
    }
}

const fn larger(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

/// The memory of a [`Frame`](super::Frame), for a `static`: `REAL` and `COMPLEX` are those of
/// [`Parameters::sizes`] or [`Parameters::sizes_of_iq`].
pub struct Memory<const REAL: usize, const COMPLEX: usize> {
    real: [f32; REAL],
    complex: [Complex<f32>; COMPLEX],
}

/// The memory of a [`Frame`](super::Frame), borrowed: from a [`Memory`], or from slices of sizes that
/// are known only at run time. Contents are irrelevant.
pub struct MemoryView<'m> {
    /// [`Sizes::real`] numbers.
    pub real: &'m mut [f32],
    /// [`Sizes::complex`] numbers.
    pub complex: &'m mut [Complex<f32>],
    /// The filters of phase symmetry: [`LogGabor::fixed`], or [`LogGabor::new`] where flash is slow.
    pub filters: LogGabor<'m>,
}

impl<const REAL: usize, const COMPLEX: usize> Memory<REAL, COMPLEX> {
    /// What it takes, bytes.
    pub const BYTES: usize = size_of::<Self>();

    /// All zero.
    pub const fn new() -> Self {
        Memory {
            real: [0.0; REAL],
            complex: [Complex::new(0.0, 0.0); COMPLEX],
        }
    }

    /// The slices for [`Frame::new`](super::Frame::new), with the filters' constants where they are.
    pub fn view(&mut self) -> MemoryView<'_> {
        MemoryView {
            real: &mut self.real,
            complex: &mut self.complex,
            filters: LogGabor::fixed(),
        }
    }
}

impl<const REAL: usize, const COMPLEX: usize> Default for Memory<REAL, COMPLEX> {
    fn default() -> Self {
        Self::new()
    }
}
