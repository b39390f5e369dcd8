//! Lines → image, through the core.

use bonebeam::geometry::Axis;
use bonebeam::image as core;
use bonebeam::simd::{InstructionSet, Task, Vector};
use ndarray::{Array2, ArrayView2};
use rayon::prelude::*;

use crate::files::Lines;
use crate::{Error, Result};

/// An image of isotropic pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Grey levels 0..255, `[row, column]`, row 0 shallowest.
    pub pixels: Array2<f32>,
    /// The lateral position of column 0 (m).
    pub x0: f64,
    /// The depth of row 0 (m).
    pub z0: f64,
    /// The distance from one pixel to the next (m).
    pub pixel: f64,
}

/// Where the pixels of an [`Image`] lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelGrid {
    /// The lateral position of column 0 (m).
    pub x0: f64,
    /// The depth of row 0 (m).
    pub z0: f64,
    /// The distance from one pixel to the next (m).
    pub pixel: f64,
    /// The number of rows.
    pub rows: usize,
    /// The number of columns.
    pub columns: usize,
}

impl PixelGrid {
    /// The smallest grid of a number of pixels that covers a width and a depth range, all in
    /// metres: the pixels are as large as the tighter of the two asks for, the width is centred,
    /// and the first row lies at the shallow end.
    pub fn cover(x: [f64; 2], z: [f64; 2], rows: usize, columns: usize) -> Self {
        let steps = |pixels: usize| pixels.saturating_sub(1).max(1) as f64;
        let across = (x[1] - x[0]) / steps(columns);
        let down = (z[1] - z[0]) / steps(rows);
        let pixel = if across > down { across } else { down };
        PixelGrid {
            x0: (x[0] + x[1] - pixel * steps(columns)) / 2.0,
            z0: z[0],
            pixel,
            rows,
            columns,
        }
    }

    /// The smallest grid of a number of pixels that covers all of the lines.
    ///
    /// # Errors
    /// Beams that are not evenly spaced.
    pub fn of_lines(lines: &Lines, rows: usize, columns: usize) -> Result<Self> {
        let (beams, samples) = (beam_axis(&lines.beam_x)?, sample_axis(lines));
        let ends = |axis: Axis| {
            let last = axis.count.saturating_sub(1) as f64;
            [axis.first, axis.first + last * axis.step]
        };
        Ok(Self::cover(ends(beams), ends(samples), rows, columns))
    }

    fn axis(&self, first: f64, count: usize) -> Axis {
        Axis {
            first,
            step: self.pixel,
            count,
        }
    }
}

/// Envelope, decibels relative to the frame's largest, 0..255, isotropic pixels, and the 3×3
/// median where `median` is set.
///
/// `dynamic_range` is in dB. Pixels outside the data are 0.
///
/// # Errors
/// Beams that are not evenly spaced, and what the core refuses: a NaN or infinite sample, a
/// dynamic range or pixel size that is not positive, fewer than two beams or samples.
pub fn b_mode(lines: &Lines, dynamic_range: f32, grid: &PixelGrid, median: bool) -> Result<Image> {
    let beams = beam_axis(&lines.beam_x)?;
    let z = lines.z.as_standard_layout();
    let z = z.as_slice().unwrap_or_default();
    let mut envelope = vec![0.0; z.len()];
    // Sample by sample: as many beams at a time as a thread likes.
    let samples = lines.z.ncols().max(1);
    z.par_chunks(samples)
        .zip(envelope.par_chunks_mut(samples))
        .try_for_each(|(z, envelope)| core::envelope(z, envelope))?;
    let reference = core::largest(&envelope);
    let mut levels = vec![0.0; z.len()];
    envelope
        .par_chunks(samples)
        .zip(levels.par_chunks_mut(samples))
        .try_for_each(|(envelope, levels)| {
            core::log_compression(envelope, reference, dynamic_range, levels)
        })?;

    let mut pixels = Array2::zeros((grid.rows, grid.columns));
    core::resample(
        &levels,
        beams,
        sample_axis(lines),
        grid.axis(grid.z0, grid.rows),
        grid.axis(grid.x0, grid.columns),
        pixels.as_slice_mut().unwrap_or_default(),
    )?;
    if median {
        pixels = InstructionSet::detect().dispatch(Median(&pixels))?;
    }
    Ok(Image {
        pixels,
        x0: grid.x0,
        z0: grid.z0,
        pixel: grid.pixel,
    })
}

/// The 3×3 median of an image.
struct Median<'a>(&'a Array2<f32>);

impl Task for Median<'_> {
    type Output = Result<Array2<f32>>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let Median(pixels) = self;
        let mut filtered = Array2::zeros(pixels.dim());
        core::median(
            zero,
            pixels.as_slice().unwrap_or_default(),
            pixels.ncols(),
            filtered.as_slice_mut().unwrap_or_default(),
        )?;
        Ok(filtered)
    }
}

/// An image bilinearly resampled to another size; corner pixels stay corner pixels.
///
/// # Errors
/// A side of fewer than two pixels, before or after; a NaN or infinite pixel.
pub fn resize(image: ArrayView2<f32>, rows: usize, columns: usize) -> Result<Array2<f32>> {
    if image.nrows() < 2 || image.ncols() < 2 {
        return Err(Error::Data(format!(
            "an image of {}x{} cannot be resized, both sides must be at least 2",
            image.nrows(),
            image.ncols()
        )));
    }
    if rows < 2 || columns < 2 {
        return Err(Error::Usage(format!(
            "an image cannot be resized to {rows}x{columns}, both sides must be at least 2"
        )));
    }
    // The resampler's data are [beam][sample], which is an image's transpose.
    let transposed = image.t().as_standard_layout().into_owned();
    let axis = |step: f64, count: usize| Axis {
        first: 0.0,
        step,
        count,
    };
    let step = |from: usize, to: usize| from.saturating_sub(1) as f64 / (to - 1) as f64;
    let mut resized = Array2::zeros((rows, columns));
    core::resample(
        transposed.as_slice().unwrap_or_default(),
        axis(1.0, image.ncols()),
        axis(1.0, image.nrows()),
        axis(step(image.nrows(), rows).max(f64::MIN_POSITIVE), rows),
        axis(step(image.ncols(), columns).max(f64::MIN_POSITIVE), columns),
        resized.as_slice_mut().unwrap_or_default(),
    )?;
    Ok(resized)
}

/// Tells before a long computation whether an image can be made of lines at these positions.
///
/// # Errors
/// As [`b_mode`] about the beams.
pub fn check_beams(beam_x: &[f64]) -> Result<()> {
    beam_axis(beam_x).map(drop)
}

/// The axis of evenly spaced beams.
///
/// # Errors
/// Fewer than two positions, or one that is off the even grid through the first and the last
/// by more than a hundredth of the spacing.
fn beam_axis(beam_x: &[f64]) -> Result<Axis> {
    let (&[first, .., last], intervals) = (beam_x, beam_x.len().saturating_sub(1)) else {
        return Err(Error::Data(format!(
            "an image needs at least 2 beams, the lines have {}",
            beam_x.len()
        )));
    };
    let step = (last - first) / intervals as f64;
    if !step.is_finite() || step <= 0.0 {
        return Err(Error::Data(format!(
            "an image needs beams from left to right: the first lies at {first} m, the last at \
             {last} m"
        )));
    }
    for (beam, &x) in beam_x.iter().enumerate() {
        let expected = first + beam as f64 * step;
        if (x - expected).abs() > 0.01 * step {
            return Err(Error::Data(format!(
                "an image needs evenly spaced beams: beam {beam} lies at {x} m, expected {expected} m"
            )));
        }
    }
    Ok(Axis {
        first,
        step,
        count: beam_x.len(),
    })
}

/// The depths of the samples: half the two-way time times the speed of sound.
fn sample_axis(lines: &Lines) -> Axis {
    Axis {
        first: lines.c * lines.t0 / 2.0,
        step: lines.c / lines.fs / 2.0,
        count: lines.z.ncols(),
    }
}
