//! Lines → image, through the core.

use bonebeam::geometry::Axis;
use bonebeam::image::{self as core, BMode, BModeParameters, Fan, Logarithm};
use bonebeam::simd::{InstructionSet, Task, Vector};
use ndarray::{Array2, ArrayBase, ArrayView2, Data, Ix2};
use num_complex::Complex;
use rayon::prelude::*;

use bonebeam_files::terminal::short;
use bonebeam_files::{BeamRays, BeamformedLines};

use crate::config;
use crate::{Error, Result};

pub use bonebeam::image::PixelGrid;

/// An image of isotropic pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct BModeImage {
    /// Grey levels 0..255, `[row, column]`, row 0 shallowest.
    pub pixels: Array2<f32>,
    /// The lateral position of column 0 (m).
    pub x0: f64,
    /// The depth of row 0 (m).
    pub z0: f64,
    /// The distance from one pixel to the next (m).
    pub pixel: f64,
}

/// The smallest grid of a number of pixels that covers all of the lines.
///
/// # Errors
/// Beams that are not evenly spaced.
pub fn grid_of_lines(lines: &BeamformedLines, rows: usize, columns: usize) -> Result<PixelGrid> {
    let samples = sample_axis(lines);
    match layout(lines)? {
        Layout::Even(beams) => Ok(PixelGrid::of_lines(&beams, &samples, rows, columns)),
        Layout::Fan { .. } => {
            let [across, depths] = extent(lines);
            Ok(PixelGrid::cover(across, depths, rows, columns))
        }
    }
}

/// The grid of an experiment's picture of lines, of as many pixels as `image` asks for.
///
/// # Errors
/// As [`grid_of_lines`].
pub fn grid_of_picture(lines: &BeamformedLines, image: &config::Image) -> Result<PixelGrid> {
    let [width, height] = extent_of_lines(lines);
    let [rows, columns] = image.sides(width, height);
    grid_of_lines(lines, rows, columns)
}

/// How far lines reach across and down, m.
fn extent_of_lines(lines: &BeamformedLines) -> [f64; 2] {
    let across = lines.beam_x[lines.beam_x.len() - 1] - lines.beam_x[0];
    let samples = sample_axis(lines);
    [across, samples.last() - samples.first]
}

/// Envelope, decibels relative to the frame's largest, 0..255, isotropic pixels, and the 3×3
/// median where `median` is set.
///
/// `dynamic_range` is in dB. Pixels outside the data are 0.
///
/// # Errors
/// Beams that are neither evenly spaced nor an even fan, and what the core refuses: a NaN or infinite sample, a
/// dynamic range or pixel size that is not positive, fewer than two beams or samples.
pub fn b_mode<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    dynamic_range: f32,
    grid: &PixelGrid,
    median: bool,
) -> Result<BModeImage> {
    let parameters = |axis: Axis| BModeParameters {
        lines: axis,
        samples: sample_axis(lines),
        grid: *grid,
        dynamic_range,
        logarithm: Logarithm::Exact,
        median,
    };
    let b_mode = match layout(lines)? {
        Layout::Even(beams) => BMode::new(parameters(beams))?,
        Layout::Fan { fan, angles } => BMode::of_fan(parameters(angles), fan)?,
    };
    Ok(BModeImage {
        pixels: pixels(InstructionSet::detect(), &b_mode, lines.z.view())?,
        x0: grid.x0,
        z0: grid.z0,
        pixel: grid.pixel,
    })
}

/// The pixels of lines `z` [line, sample], by a plan of the core, with the vectors of `set`.
///
/// # Errors
/// What the core refuses: a NaN or infinite sample, another number of lines or samples.
pub fn pixels(
    set: InstructionSet,
    b_mode: &BMode,
    z: ArrayView2<Complex<f32>>,
) -> Result<Array2<f32>> {
    let samples = z.ncols().max(1);
    let z = z.as_standard_layout();
    let z = z.as_slice().unwrap_or_default();
    let mut envelopes = vec![0.0; z.len()];
    // Sample by sample: as many beams at a time as a thread likes.
    z.par_chunks(samples)
        .zip(envelopes.par_chunks_mut(samples))
        .try_for_each(|(z, envelope)| core::envelope(z, envelope))?;
    let reference = core::largest(&envelopes);
    let mut levels = vec![0.0; z.len()];
    envelopes
        .par_chunks(samples)
        .zip(levels.par_chunks_mut(samples))
        .try_for_each(|(envelope, levels)| b_mode.levels(envelope, reference, levels))?;
    let levels = levels.as_slice();
    set.dispatch(Pixels { b_mode, levels })
}

/// The pixels of all lines' grey levels.
struct Pixels<'a> {
    b_mode: &'a BMode,
    levels: &'a [f32],
}

impl Task for Pixels<'_> {
    type Output = Result<Array2<f32>>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let Pixels { b_mode, levels } = self;
        let grid = b_mode.parameters().grid;
        let mut pixels = Array2::zeros((grid.rows, grid.columns));
        let mut scratch = vec![0.0; b_mode.pixels_need().real];
        let out = pixels.as_slice_mut().unwrap_or_default();
        b_mode.pixels(zero, levels, &mut scratch, out)?;
        Ok(pixels)
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
        [axis(1.0, image.ncols()), axis(1.0, image.nrows())],
        [
            axis(step(image.nrows(), rows).max(f64::MIN_POSITIVE), rows),
            axis(step(image.ncols(), columns).max(f64::MIN_POSITIVE), columns),
        ],
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

/// How the beams of an image lie.
pub(crate) enum Layout {
    /// Straight down, evenly spaced.
    Even(Axis),
    /// From one position, at even angles.
    Fan { fan: Fan, angles: Axis },
}

pub(crate) fn layout<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
) -> Result<Layout> {
    match &lines.rays {
        None => beam_axis(&lines.beam_x).map(Layout::Even),
        Some(rays) => fan(lines, rays),
    }
}

/// From where to where lines reach, across and down, m.
pub fn extent<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
) -> [[f64; 2]; 2] {
    let samples = sample_axis(lines);
    let mut extent = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for (beam, &x) in lines.beam_x.iter().enumerate() {
        let (z, angle) = match &lines.rays {
            None => (0.0, 0.0),
            Some(rays) => (rays.z[beam], rays.angle[beam]),
        };
        for r in [samples.first, samples.last()] {
            let position = [x + r * angle.sin(), z + r * angle.cos()];
            for (range, at) in extent.iter_mut().zip(position) {
                *range = [range[0].min(at), range[1].max(at)];
            }
        }
    }
    extent
}

/// The fan of beams at even angles from one position.
///
/// # Errors
/// Angles that do not ascend evenly, to a hundredth of a step; a beam that begins off the arc through
/// the first and the last by more than a hundredth of what lies between two; an array that is concave.
fn fan<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    rays: &BeamRays,
) -> Result<Layout> {
    let needs = |what: String| {
        Err(Error::Data(format!(
            "an image needs beams straight down, or beams that fan out evenly from one position: {what}"
        )))
    };
    let last = lines.beam_x.len() - 1;
    let (first_angle, last_angle) = (rays.angle[0], rays.angle[last]);
    let step = (last_angle - first_angle) / last.max(1) as f64;
    if step.is_nan() || step <= 0.0 {
        return needs(format!(
            "their angles go from {first_angle} rad to {last_angle} rad"
        ));
    }
    let radius = (lines.beam_x[last] - lines.beam_x[0]) / (last_angle.sin() - first_angle.sin());
    let x = lines.beam_x[0] - radius * first_angle.sin();
    let z = rays.z[0] - radius * first_angle.cos();
    // A sector's radius is 0 but for rounding.
    let deepest = sample_axis(lines).last();
    let tolerance = 0.01 * step * (radius.abs() + deepest);
    if radius < -tolerance {
        return needs("they converge".into());
    }
    for beam in 0..=last {
        let even = first_angle + beam as f64 * step;
        let angle = rays.angle[beam];
        let beside = (lines.beam_x[beam] - x - radius * angle.sin())
            .hypot(rays.z[beam] - z - radius * angle.cos());
        if (angle - even).abs() > 0.01 * step || beside > tolerance {
            return needs(format!(
                "beam {beam} begins at {} m, {} m and goes {angle} rad aside",
                lines.beam_x[beam], rays.z[beam]
            ));
        }
    }
    Ok(Layout::Fan {
        fan: Fan {
            x,
            z,
            radius: radius.max(0.0),
        },
        angles: Axis {
            first: first_angle,
            step,
            count: last + 1,
        },
    })
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
pub(crate) fn sample_axis<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
) -> Axis {
    Axis {
        first: lines.c * lines.t0 / 2.0,
        step: lines.c / lines.fs / 2.0,
        count: lines.z.ncols(),
    }
}

/// The B-mode image over the depths and the width asked for, in square pixels.
///
/// # Errors
/// A depth above the lines, beams that are not evenly spaced.
pub fn image_of<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    parameters: &config::Image,
) -> Result<BModeImage> {
    let depth = |sample: usize| lines.c * (lines.t0 + sample as f64 / lines.fs) / 2.0;
    let [beams, [first, last]] = match lines.rays {
        None => [
            [lines.beam_x[0], lines.beam_x[lines.beam_x.len() - 1]],
            [depth(0), depth(lines.z.ncols() - 1)],
        ],
        Some(_) => extent(lines),
    };
    if let Some(depth) = parameters.depth.filter(|&depth| depth <= first) {
        return Err(Error::Usage(format!(
            "--depth is {} m; expected more than {first} m, where the lines begin",
            short(depth)
        )));
    }
    let bottom = parameters.depth.unwrap_or(last);
    let across = match parameters.width {
        Some(width) => {
            let centre = (beams[0] + beams[1]) / 2.0;
            [centre - width / 2.0, centre + width / 2.0]
        }
        None => beams,
    };
    let [rows, columns] = parameters.sides(across[1] - across[0], bottom - first);
    let grid = PixelGrid::cover(across, [first, bottom], rows, columns);
    b_mode(
        lines,
        parameters.dynamic_range as f32,
        &grid,
        parameters.median,
    )
}
