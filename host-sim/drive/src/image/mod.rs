//! Lines → image, through the core.

mod lattice;
mod layout;

use bonebeam::geometry::Axis;
use bonebeam::image::{
    self as core, BMode, BModeParameters, DepthInterpolation, Logarithm, Pooling,
};
use bonebeam::simd::InstructionSet;
use bonebeam_kernels::image as kernels;
use ndarray::{Array2, ArrayBase, ArrayView2, Data, Ix2};
use num_complex::Complex;
use rayon::prelude::*;

use bonebeam_files::terminal::short;
use bonebeam_files::{BeamRays, BeamformedLines};

use crate::config::{self, PixelSize, SubLines};
use crate::{Error, Result};
use lattice::Lattice;
pub(crate) use lattice::sample_axis;
pub(crate) use layout::{Layout, layout};
pub use layout::{check_beams, extent};

pub use bonebeam::image::PixelGrid;

/// An image of even pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct BModeImage {
    /// Grey levels 0..255, `[row, column]`, row 0 shallowest.
    pub pixels: Array2<f32>,
    /// The lateral position of column 0 (m).
    pub x0: f64,
    /// The depth of row 0 (m).
    pub z0: f64,
    /// The distances of columns and of rows (m).
    pub pixel: [f64; 2],
    /// Angles of the columns, rad, for an image on a polar grid.
    ///
    /// `z0` is then the depth of row 0 along its beams, and `pixel` the distance of rows, twice.
    pub angles: Option<Axis>,
}

/// The side of square pixels in place of others: the shorter one, m.
pub fn square_side([across, down]: [f64; 2]) -> f64 {
    if across < down { across } else { down }
}

/// Resamples an image to square pixels of the [`square_side`].
///
/// The corner pixels stay. `None` if the pixels are square.
///
/// # Errors
/// As [`resize`].
pub fn squared(image: ArrayView2<f32>, pixel: [f64; 2]) -> Result<Option<Array2<f32>>> {
    if pixel[0] == pixel[1] {
        return Ok(None);
    }
    let side = square_side(pixel);
    // The casts saturate.
    let count =
        |count: usize, own: f64| (count.saturating_sub(1) as f64 * own / side).round() as usize + 1;
    let (rows, columns) = (
        count(image.nrows(), pixel[1]),
        count(image.ncols(), pixel[0]),
    );
    resize(image, rows, columns).map(Some)
}

/// The smallest grid of `rows` × `columns` pixels that covers all lines.
///
/// # Errors
/// Beams that are not evenly spaced.
pub fn grid_of_lines(lines: &BeamformedLines, rows: usize, columns: usize) -> Result<PixelGrid> {
    let samples = sample_axis(lines);
    match layout(lines)? {
        Layout::Even(beams) => Ok(PixelGrid::of_lines(&beams, &samples, rows, columns)),
        Layout::Fan { .. } | Layout::Any(_) => {
            let [across, depths] = extent(lines);
            Ok(PixelGrid::cover(across, depths, rows, columns))
        }
    }
}

/// The grid of an experiment's picture of lines.
///
/// `image` gives the number of pixels.
///
/// # Errors
/// As [`grid_of_lines`].
pub fn grid_of_picture(lines: &BeamformedLines, image: &config::Image) -> Result<PixelGrid> {
    let [width, height] = extent_of_lines(lines);
    let [rows, columns] = image.sides(width, height)?;
    grid_of_lines(lines, rows, columns)
}

/// Extent of lines, across and down, m.
fn extent_of_lines(lines: &BeamformedLines) -> [f64; 2] {
    let across = lines.beam_x[lines.beam_x.len() - 1] - lines.beam_x[0];
    let samples = sample_axis(lines);
    [across, samples.last() - samples.first]
}

/// B-mode image of lines: envelope, decibels, grey levels, square pixels.
///
/// Levels are relative to the frame's largest envelope and span `dynamic_range` dB as 0..255. `median` adds a 3 × 3
/// median. Pixels outside the data are 0.
///
/// # Errors
/// Beams that are not ordered from left to right, or that cross; errors of the core: a NaN or infinite sample, a
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
    let set = InstructionSet::detect();
    let pixels = match layout(lines)? {
        Layout::Even(beams) => pixels(set, &BMode::new(parameters(beams))?, lines.z.view())?,
        Layout::Fan { fan, angles } => {
            let b_mode = BMode::of_fan(parameters(angles), fan)?;
            pixels(set, &b_mode, lines.z.view())?
        }
        Layout::Any(lattice) => {
            let b_mode = BMode::new(parameters(any_axis(&lattice)))?;
            let levels = levels(&b_mode, lines.z.view())?;
            let (rows, columns) = (grid.row_axis(), grid.column_axis());
            let pixels = by_position(rows, columns, |x, z| lattice.at(&levels, [x, z]));
            smoothed(set, pixels, median)?
        }
    };
    Ok(BModeImage {
        pixels,
        x0: grid.x0,
        z0: grid.z0,
        pixel: [grid.pixel; 2],
        angles: None,
    })
}

/// An image of beams that fan out, on a polar grid.
///
/// Columns are at even angles from the first beam's to the last's, rows at even depths along the beams.
///
/// # Errors
/// As [`b_mode`], and beams whose angles do not ascend.
fn polar<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    section: &config::Image,
) -> Result<BModeImage> {
    let lattice = Lattice::new(lines)?;
    let angle = |beam: usize| lattice.rays()[beam].angle();
    let last = lattice.rays().len() - 1;
    if let Some(beam) = (0..last).find(|&beam| angle(beam) >= angle(beam + 1)) {
        return Err(Error::Usage(format!(
            "--grid polar is for beams that fan out; beam {beam} has an angle of {} rad, the next one of {} rad",
            short(angle(beam)),
            short(angle(beam + 1))
        )));
    }
    let samples = sample_axis(lines);
    let bottom = section.bottom(samples.first, samples.last())?;
    let height = bottom - samples.first;
    let [rows, columns] = section.sides(lattice.width(), height)?;
    let steps = |count: usize| (count - 1) as f64;
    let pixel = match section.pixel_size {
        None => height / steps(rows),
        Some(PixelSize::Square(side)) => side,
        Some(PixelSize::Sides(_)) => {
            let message = "--grid polar has the angles of its lines across; expected one --pixel-size, of rows";
            return Err(Error::Usage(message.into()));
        }
    };
    let angles = Axis::new(angle(0), (angle(last) - angle(0)) / steps(columns), columns);
    let depths = Axis::new(samples.first, pixel, rows);
    let b_mode = BMode::new(BModeParameters {
        lines: any_axis(&lattice),
        samples,
        grid: PixelGrid::new([0.0, samples.first], pixel, [rows, columns]),
        dynamic_range: section.dynamic_range as f32,
        logarithm: Logarithm::Exact,
        median: false,
    })?;
    let levels = levels(&b_mode, lines.z.view())?;
    let pixels = by_position(depths, angles, |angle, depth| {
        lattice.at_angle(&levels, angle, depth)
    });
    Ok(BModeImage {
        pixels: smoothed(InstructionSet::detect(), pixels, section.median)?,
        x0: lines.beam_x[0],
        z0: samples.first,
        pixel: [pixel; 2],
        angles: Some(angles),
    })
}

/// A placeholder for a plan's axis of beams, if a lattice finds them.
fn any_axis(lattice: &Lattice) -> Axis {
    Axis::new(0.0, 1.0, lattice.rays().len())
}

/// Pixels of `value` at each position of columns and rows.
fn by_position(rows: Axis, columns: Axis, value: impl Fn(f64, f64) -> f32 + Sync) -> Array2<f32> {
    let mut pixels = Array2::zeros((rows.count, columns.count));
    let own = pixels.as_slice_mut().unwrap_or_default();
    let of_rows = own.par_chunks_mut(columns.count.max(1)).enumerate();
    of_rows.for_each(|(row, pixels)| {
        for (column, pixel) in pixels.iter_mut().enumerate() {
            *pixel = value(columns.position(column), rows.position(row));
        }
    });
    pixels
}

/// The pixels, through the 3 × 3 median if selected.
fn smoothed(set: InstructionSet, pixels: Array2<f32>, median: bool) -> Result<Array2<f32>> {
    match median {
        true => kernels::median(set, pixels.view()),
        false => Ok(pixels),
    }
}

/// Pixels of lines `z` [line, sample], by a plan of the core and vectors of `set`.
///
/// # Errors
/// Errors of the core: a NaN or infinite sample, or another number of lines or samples.
pub fn pixels(
    set: InstructionSet,
    b_mode: &BMode,
    z: ArrayView2<Complex<f32>>,
) -> Result<Array2<f32>> {
    kernels::pixels(set, b_mode, &levels(b_mode, z)?)
}

/// Grey levels of all lines, relative to the largest envelope.
fn levels(b_mode: &BMode, z: ArrayView2<Complex<f32>>) -> Result<Vec<f32>> {
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
    Ok(levels)
}

/// Resamples an image bilinearly to another size.
///
/// Corner pixels stay corner pixels.
///
/// # Errors
/// A side of fewer than two pixels, before or after; a NaN or infinite pixel.
pub fn resize(image: ArrayView2<f32>, rows: usize, columns: usize) -> Result<Array2<f32>> {
    if image.nrows() < 2 || image.ncols() < 2 {
        return Err(Error::Data(format!(
            "an image of {}x{} cannot be resized; both sides must be at least 2",
            image.nrows(),
            image.ncols()
        )));
    }
    if rows < 2 || columns < 2 {
        return Err(Error::Usage(format!(
            "an image cannot be resized to {rows}x{columns}; both sides must be at least 2"
        )));
    }
    // The resampler's data are [beam][sample], which is an image's transpose.
    let transposed = image.t().as_standard_layout().into_owned();
    let axis = |step: f64, count: usize| Axis::new(0.0, step, count);
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

/// Lines with the envelope of their sub-lines, at the middle of these.
///
/// # Errors
/// A sample that is not finite.
pub fn pooled<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    pooling: Pooling,
) -> Result<BeamformedLines> {
    let count = lines.sub_lines;
    // Lines of a recording have every sample.
    let interpolation = DepthInterpolation::new(lines.z.ncols(), 1, 0.0)?;
    let z = pooled_lines(lines.z.view(), (count, pooling), &interpolation)?;
    let middle = |positions: &[f64]| -> Vec<f64> {
        let of_line = |own: &[f64]| own.iter().sum::<f64>() / count as f64;
        positions.chunks(count).map(of_line).collect()
    };
    Ok(BeamformedLines {
        z,
        fs: lines.fs,
        t0: lines.t0,
        beam_x: middle(&lines.beam_x),
        rays: lines.rays.as_ref().map(|rays| BeamRays {
            z: middle(&rays.z),
            angle: middle(&rays.angle),
        }),
        sub_lines: 1,
        c: lines.c,
    })
}

/// Envelopes of lines of `count` sub-lines each, as real numbers [line, sample].
///
/// `z` is [sub-line, computed sample].
///
/// # Errors
/// A sample that is not finite.
pub(super) fn pooled_lines(
    z: ArrayView2<'_, Complex<f32>>,
    (count, pooling): (usize, Pooling),
    interpolation: &DepthInterpolation,
) -> Result<Array2<Complex<f32>>> {
    let of_lines = z.axis_chunks_iter(ndarray::Axis(0), count);
    let mut lines = Array2::zeros((of_lines.len(), interpolation.samples()));
    let mut envelope = vec![0.0; interpolation.samples()];
    let mut scratch = vec![Complex::ZERO; interpolation.need(count).complex];
    for (mut line, sub_lines) in lines.rows_mut().into_iter().zip(of_lines) {
        let by_sample: Vec<_> = sub_lines.t().iter().copied().collect();
        let of_line = (count, pooling);
        interpolation.envelope(&by_sample, of_line, &mut scratch, &mut envelope)?;
        for (z, &envelope) in line.iter_mut().zip(&envelope) {
            *z = Complex::from(envelope);
        }
    }
    Ok(lines)
}

/// Lateral positions and depths of an image of lines, without a polar grid, m.
fn region<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    parameters: &config::Image,
) -> Result<[[f64; 2]; 2]> {
    let depth = |sample: usize| lines.c * (lines.t0 + sample as f64 / lines.fs) / 2.0;
    let [beams, [first, last]] = match lines.rays {
        None => [
            [lines.beam_x[0], lines.beam_x[lines.beam_x.len() - 1]],
            [depth(0), depth(lines.z.ncols() - 1)],
        ],
        Some(_) => extent(lines),
    };
    let bottom = parameters.bottom(first, last)?;
    let across = match parameters.width {
        Some(width) => {
            let centre = (beams[0] + beams[1]) / 2.0;
            [centre - width / 2.0, centre + width / 2.0]
        }
        None => beams,
    };
    Ok([across, [first, bottom]])
}

/// Rows and columns of an image of lines, without a polar grid.
///
/// # Errors
/// As [`image_of`].
pub fn sides_of<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    parameters: &config::Image,
) -> Result<[usize; 2]> {
    let [across, depths] = region(lines, parameters)?;
    parameters.sides(across[1] - across[0], depths[1] - depths[0])
}

/// The B-mode image over the given depths and width, on the given grid.
///
/// The grid has square pixels, or columns at even angles.
///
/// # Errors
/// A depth above the lines, beams that make no image, or more pixels per side than are allowed.
pub fn image_of<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    parameters: &config::Image,
) -> Result<BModeImage> {
    let pooling = match parameters.pooling {
        SubLines::Largest => Some(Pooling::Largest),
        SubLines::Rms => Some(Pooling::Rms),
        SubLines::Each => None,
    };
    if let Some(pooling) = pooling.filter(|_| lines.sub_lines > 1) {
        return image_of(&pooled(lines, pooling)?, parameters);
    }
    if parameters.grid == config::Grid::Polar {
        return polar(lines, parameters);
    }
    let [across, [first, bottom]] = region(lines, parameters)?;
    let [rows, columns] = sides_of(lines, parameters)?;
    let grid = |pixel: f64, [x0, z0]: [f64; 2], [rows, columns]: [usize; 2]| {
        PixelGrid::new([x0, z0], pixel, [rows, columns])
    };
    let centred =
        |pixel: f64, columns: usize| (across[0] + across[1] - pixel * (columns - 1) as f64) / 2.0;
    let grid = match parameters.pixel_size {
        None => PixelGrid::cover(across, [first, bottom], rows, columns),
        Some(PixelSize::Square(pixel)) => {
            grid(pixel, [centred(pixel, columns), first], [rows, columns])
        }
        Some(PixelSize::Sides([wide, high])) => {
            let plan = BModeParameters {
                lines: Axis::new(0.0, 1.0, lines.beam_x.len()),
                samples: sample_axis(lines),
                grid: grid(high, [0.0, first], [rows, columns]),
                dynamic_range: parameters.dynamic_range as f32,
                logarithm: Logarithm::Exact,
                median: false,
            };
            let levels = levels(&BMode::new(plan)?, lines.z.view())?;
            let lattice = Lattice::new(lines)?;
            let x0 = centred(wide, columns);
            let [down, right] = [Axis::new(first, high, rows), Axis::new(x0, wide, columns)];
            let pixels = by_position(down, right, |x, z| lattice.at(&levels, [x, z]));
            return Ok(BModeImage {
                pixels: smoothed(InstructionSet::detect(), pixels, parameters.median)?,
                x0,
                z0: first,
                pixel: [wide, high],
                angles: None,
            });
        }
    };
    b_mode(
        lines,
        parameters.dynamic_range as f32,
        &grid,
        parameters.median,
    )
}
