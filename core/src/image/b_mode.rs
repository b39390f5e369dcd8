//! B-mode images from envelopes of lines.

use super::{
    Fan, Logarithm, PixelGrid, largest, log_compression, median, resample, scan_conversion,
};
use crate::Error;
use crate::error::{attempt, check_length};
use crate::geometry::Axis;
use crate::memory::Need;
use crate::simd::Vector;

/// Parameters of a [`BMode`] image.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BModeParameters {
    /// Lateral positions of the lines, or the angles of a fan of lines, rad.
    pub lines: Axis,
    /// Depths of the lines' samples.
    pub samples: Axis,
    /// Positions of the pixels; pixels outside the data are 0.
    pub grid: PixelGrid,
    /// Level of black below the largest envelope, dB.
    pub dynamic_range: f32,
    /// Logarithm used for the grey levels.
    pub logarithm: Logarithm,
    /// Whether a 3×3 median filters the pixels.
    pub median: bool,
}

/// B-mode image from envelopes of lines.
///
/// The steps are decibels below the largest envelope, grey levels 0..255, isotropic pixels, and an optional 3×3
/// median.
///
/// ```
/// use bonebeam::geometry::Axis;
/// use bonebeam::image::{BMode, BModeParameters, Logarithm, PixelGrid};
///
/// let (lines, samples) = (Axis::centred(2, 1e-3), Axis { first: 0.0, step: 0.5e-3, count: 3 });
/// let b_mode = BMode::new(BModeParameters {
///     lines,
///     samples,
///     grid: PixelGrid::of_lines(&lines, &samples, 3, 3),
///     dynamic_range: 40.0,
///     logarithm: Logarithm::Exact,
///     median: false,
/// })?;
/// let envelopes = [1.0, 0.1, 0.0, 1.0, 0.1, 0.0];
/// let (mut work, mut image) = ([0.0; 6], [0.0; 9]);
/// b_mode.image(0.0f32, &envelopes, &mut work, &mut image)?;
/// assert_eq!(image[..3], [255.0; 3]);
/// assert_eq!(image[3..6], [127.5; 3]); // −20 dB of 40
/// assert_eq!(image[6..], [0.0; 3]);
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BMode {
    parameters: BModeParameters,
    fan: Option<Fan>,
}

impl BModeParameters {
    /// Checks all values; a `const` can call it.
    ///
    /// # Errors
    /// As [`BMode::new`].
    pub const fn check(&self) -> Result<(), Error> {
        let (rows, columns) = (self.grid.row_axis(), self.grid.column_axis());
        attempt!(resample::check_axes(
            &self.lines,
            &self.samples,
            &rows,
            &columns
        ));
        log_compression::check_range(self.dynamic_range)
    }
}

impl BMode {
    /// Validates the parameters.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an axis that is not finite, whose step is not positive, or a data
    /// axis of fewer than 2 positions, and for a dynamic range that is not positive.
    pub fn new(parameters: BModeParameters) -> Result<Self, Error> {
        parameters.check()?;
        Ok(BMode {
            parameters,
            fan: None,
        })
    }

    /// A B-mode image of lines that fan out; `lines` of the parameters are angles.
    ///
    /// # Errors
    /// As [`BMode::new`], and [`Error::Parameter`] for a fan that is not finite or has a negative radius.
    pub fn of_fan(parameters: BModeParameters, fan: Fan) -> Result<Self, Error> {
        fan.check()?;
        Ok(BMode {
            fan: Some(fan),
            ..Self::new(parameters)?
        })
    }

    /// The parameters.
    pub fn parameters(&self) -> &BModeParameters {
        &self.parameters
    }

    /// Length of all lines' envelopes, `[line][sample]`.
    pub fn envelopes_len(&self) -> usize {
        let BModeParameters { lines, samples, .. } = &self.parameters;
        lines.count.saturating_mul(samples.count)
    }

    /// Scratch of [`BMode::image`], real numbers.
    ///
    /// It holds the grey levels of all lines and, with the median, the unfiltered pixels.
    pub fn need(&self) -> Need {
        Need::real(self.envelopes_len()).and(self.pixels_need())
    }

    /// Scratch of [`BMode::pixels`], real numbers.
    ///
    /// The number of pixels with the median, else 0.
    pub fn pixels_need(&self) -> Need {
        let BModeParameters { grid, median, .. } = &self.parameters;
        Need::real(if *median { grid.pixels() } else { 0 })
    }

    /// Computes the image of all lines' envelopes, row-major `[row][column]`.
    ///
    /// `zero`: any vector of the instruction set to compute with; the pixels do not depend on it.
    /// `work`: [`BMode::need`] values, contents irrelevant.
    ///
    /// # Errors
    /// [`Error::Length`]; [`Error::NonFinite`] or [`Error::Parameter`] for an envelope that is not a finite number
    /// of at least 0. `out` is then unchanged.
    pub fn image<V: Vector>(
        &self,
        zero: V,
        envelopes: &[f32],
        work: &mut [f32],
        out: &mut [f32],
    ) -> Result<(), Error> {
        self.image_in_steps(zero, envelopes, work, out, &mut |_| {})
    }

    /// [`BMode::image`] with reports of progress.
    ///
    /// `progress` receives the number of finished steps, from 1. A step has 4096 envelopes or pixels, less than a
    /// million instructions on a Cortex-M7, so that `progress` can reset a watchdog. A fan's pixels are one step.
    ///
    /// # Errors
    /// As [`BMode::image`].
    pub fn image_in_steps<V: Vector>(
        &self,
        zero: V,
        envelopes: &[f32],
        work: &mut [f32],
        out: &mut [f32],
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), Error> {
        let mut done = 0;
        let mut step = || {
            done += 1;
            progress(done);
        };
        check_length("envelopes", envelopes.len(), self.envelopes_len())?;
        check_length("work", work.len(), self.need().real)?;
        let (levels, scratch) = work.split_at_mut(self.envelopes_len());
        let reference = largest(envelopes);
        step();
        self.levels_in_steps(envelopes, reference, levels, &mut step)?;
        self.pixels_in_steps(zero, levels, scratch, out, &mut step)
    }

    /// Computes grey levels of envelopes relative to the frame's `reference`.
    ///
    /// The envelopes are of any number of lines.
    ///
    /// # Errors
    /// As [`log_compression_with()`](super::log_compression_with()).
    pub fn levels(&self, envelopes: &[f32], reference: f32, out: &mut [f32]) -> Result<(), Error> {
        self.levels_in_steps(envelopes, reference, out, &mut || {})
    }

    fn levels_in_steps(
        &self,
        envelopes: &[f32],
        reference: f32,
        out: &mut [f32],
        step: &mut dyn FnMut(),
    ) -> Result<(), Error> {
        let BModeParameters {
            logarithm,
            dynamic_range,
            ..
        } = self.parameters;
        let range = (reference, dynamic_range);
        log_compression::log_compression_in_steps(logarithm, envelopes, range, out, step)
    }

    /// Computes the image of all lines' grey levels, `[line][sample]`.
    ///
    /// `scratch`: [`BMode::pixels_need`] values.
    ///
    /// # Errors
    /// As [`resample()`](super::resample()) and [`median()`](super::median()).
    pub fn pixels<V: Vector>(
        &self,
        zero: V,
        levels: &[f32],
        scratch: &mut [f32],
        out: &mut [f32],
    ) -> Result<(), Error> {
        self.pixels_in_steps(zero, levels, scratch, out, &mut || {})
    }

    fn pixels_in_steps<V: Vector>(
        &self,
        zero: V,
        levels: &[f32],
        scratch: &mut [f32],
        out: &mut [f32],
        step: &mut dyn FnMut(),
    ) -> Result<(), Error> {
        let BModeParameters {
            lines,
            samples,
            grid,
            ..
        } = self.parameters;
        check_length("scratch", scratch.len(), self.pixels_need().real)?;
        check_length("image", out.len(), grid.pixels())?;
        let (rows, columns) = (grid.row_axis(), grid.column_axis());
        let (data, pixels) = ([lines, samples], [rows, columns]);
        let mut to_pixels = |out: &mut [f32]| match self.fan {
            None => resample::resample_in_steps(levels, data, pixels, out, step),
            Some(fan) => {
                scan_conversion::scan_convert(levels, fan, data, pixels, out)?;
                step();
                Ok(())
            }
        };
        if !self.parameters.median {
            return to_pixels(out);
        }
        to_pixels(scratch)?;
        median::median_in_steps(zero, scratch, grid.columns, out, step)
    }
}
