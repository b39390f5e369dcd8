//! Memory of a frame.

use super::{Input, Parameters, coherence_map, even};
use crate::Error;
use crate::beamform::{self, ShortLagCoherence};
use crate::delay::{DelayParameters, IqParameters};
use crate::error::attempt;
use crate::geometry::{Scan, SteeringTable};
use crate::image::DepthInterpolation;
use crate::memory::Need;
use crate::phase_symmetry;
use crate::surface::{self, Settings};

/// Division of a frame's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct FrameLayout {
    /// Samples of a line.
    pub(super) samples: usize,
    /// Samples that its beamformer computes.
    pub(super) line_samples: usize,
    /// Memory of the image's interpolation of lines.
    pub(super) interpolation: Need,
    pub(super) sub_lines: usize,
    /// Samples of all lines.
    pub(super) envelopes: usize,
    /// The delay stage and the aligned samples of a line.
    pub(super) line: Need,
    pub(super) beamformer: beamform::Sizes,
    /// Grey levels of all lines, and the pixels before the median.
    pub(super) b_mode: usize,
    /// The image's size and the strip height.
    pub(super) strips: phase_symmetry::Sizes,
}

impl Parameters<'_> {
    /// Memory of a [`Frame`](super::Frame) with lines by vectors of `lanes` lanes, for a `static`:
    ///
    /// ```
    /// use bonebeam::prelude::*;
    ///
    /// const PARAMETERS: Parameters = Parameters::EXAMPLE;
    /// const NEED: Need = valid!(PARAMETERS.need(Input::Rf, 1));
    /// static MEMORY: Memory<{ NEED.real }, { NEED.complex }> = Memory::new();
    /// ```
    ///
    /// # Errors
    /// As [`Parameters::check`]. The compiler then refuses the constant; [`Error::words`] says why.
    pub const fn need(&self, input: Input, lanes: usize) -> Result<Need, Error> {
        attempt!(self.check(input));
        let parts = attempt!(self.parts(input, 1));
        Ok(parts.need_over(attempt!(self.parts(input, lanes)).line))
    }

    /// The parts with the delay stage's memory for vectors.
    pub(super) const fn parts(&self, input: Input, lanes: usize) -> Result<FrameLayout, Error> {
        let (scan, delay) = match input {
            Input::Rf => {
                let scan = attempt!(Scan::new(self.scan));
                let samples = self.buffered(&scan);
                (scan, DelayParameters::of(&scan).block_need(lanes, samples))
            }
            Input::Iq => {
                let scan = attempt!(Scan::of_iq(self.scan));
                // The same for every frequency.
                (scan, IqParameters::of(&scan, 0.0).need(lanes))
            }
        };
        Ok(self.parts_of(&scan, delay))
    }

    /// Parameters of a surface [`Detector`](crate::surface::Detector) for these lines.
    ///
    /// They are for the surface of a whole frame: [`Frame::surface`](super::Frame::surface).
    ///
    /// # Errors
    /// As [`Scan::new`]; [`Error::Parameter`] for lines that are not evenly spaced.
    pub const fn surface(&self, settings: Settings) -> Result<surface::Parameters, Error> {
        // For I/Q the samples are at the same depths.
        let scan = attempt!(Scan::of_iq(self.scan));
        let lines = attempt!(even(&self.scan.lines));
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
        Ok(attempt!(self.parts(Input::Iq, 1)).coherence_len(coherence))
    }

    /// Length of the directions of all sub-lines; 0 for lines alone.
    ///
    /// For [`Pipeline::with_directions`].
    ///
    /// # Errors
    /// As [`Scan::new`].
    ///
    /// [`Pipeline::with_directions`]: super::Pipeline::with_directions
    pub const fn directions_len(&self) -> Result<usize, Error> {
        let scan = attempt!(Scan::of_iq(self.scan));
        Ok(directions_len(&scan, &self.beamformer))
    }

    /// Aligned samples in memory at a time.
    const fn buffered(&self, scan: &Scan<'_>) -> usize {
        let half_window = self.beamformer.temporal_half_window;
        buffered(scan.samples(), half_window, self.block)
    }

    const fn parts_of(&self, scan: &Scan<'_>, delay: Need) -> FrameLayout {
        let elements = scan.elements();
        let envelopes = scan.lines().saturating_mul(scan.samples());
        let strips = self.strips();
        let sub_lines = self.beamformer.sub_lines;
        let line_samples = self.beamformer.line_samples(scan.samples());
        let step = self.beamformer.depth_step;
        let interpolation = DepthInterpolation::need_of(line_samples, step, sub_lines);
        let before_median = if self.median { strips.image_len() } else { 0 };
        FrameLayout {
            samples: scan.samples(),
            line_samples,
            interpolation,
            sub_lines,
            envelopes,
            line: delay.and(Need::new(0, elements.saturating_mul(self.buffered(scan)))),
            beamformer: self.beamformer.sizes(elements),
            b_mode: envelopes.saturating_add(before_median),
            strips,
        }
    }

    /// The image's size and the strip height, as phase symmetry has them.
    pub(super) const fn strips(&self) -> phase_symmetry::Sizes {
        phase_symmetry::Sizes::new(self.rows, self.columns, self.strip)
    }
}

impl FrameLayout {
    /// [`FrameLayout::need`], or that of lines by vectors, whose workspace is apart.
    pub(super) const fn need_over(self, line: Need) -> Need {
        let beamformer = beamform::Sizes {
            covariance: self.beamformer.covariance,
            elements: 0,
            subaperture: 0,
            temporal_half_window: 0,
            sub_lines: 0,
        };
        let of_lines = FrameLayout {
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
        let kept = Need::real(lines.saturating_add(images));
        let line = Need::new(0, self.line_samples.saturating_mul(self.sub_lines));
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

/// Length of the directions of all sub-lines; 0 for lines alone.
pub(super) const fn directions_len(scan: &Scan<'_>, beamformer: &beamform::Parameters) -> usize {
    let samples = beamformer.line_samples(scan.samples());
    match beamformer.sub_lines {
        sub_lines @ 2.. => SteeringTable::need(scan.lines(), samples, sub_lines).complex,
        _ => 0,
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
