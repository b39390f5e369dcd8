//! Bilinear resampling of lines to isotropic pixels.

use super::finite_largest;
use crate::Error;
use crate::error::{attempt, check_length};
use crate::geometry::Axis;
use crate::memory::STEP;

/// Bilinear interpolation of `data[beam][sample]` at the pixels of an image.
///
/// All arrays are row-major; the image is `[row][column]` with row 0 shallowest.
///
/// `beams` and `columns` are positions along x, `samples` and `rows` along z, in the same unit. Pixels outside the
/// data are 0. A pixel beyond the first or last position by at most 10⁻⁶ of a step counts as on it, so that rounding
/// cannot blank an edge. With the fractions `p` along the beams and `q` along the samples, the value is
/// `(1−p)·((1−q)·d₀₀ + q·d₀₁) + p·((1−q)·d₁₀ + q·d₁₁)`, where `p` and `q` are rounded to f32 once from an f64 position.
/// At a data point the result is that point, exactly. Rounding beyond the largest magnitude of the data is clipped.
///
/// RAM: 1.5 KiB of stack. Cost: 6 f32 multiplications per pixel; an f64 division and a rounding per column, and per row
/// for each 64 columns.
///
/// ```
/// use bonebeam::geometry::Axis;
///
/// let two = Axis { first: 0.0, step: 1.0, count: 2 };
/// let middle = Axis { first: 0.5, step: 1.0, count: 1 };
/// let mut pixel = [0.0];
/// bonebeam::image::resample(&[0.0, 1.0, 2.0, 3.0], [two, two], [middle, middle], &mut pixel)?;
/// assert_eq!(pixel, [1.5]);
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// # Errors
/// [`Error::Parameter`] for an axis that is not finite, whose step is not positive, or a data axis of fewer than 2
/// positions; [`Error::Length`]; [`Error::NonFinite`] with the flat index into `data`. `out` is then unchanged.
pub fn resample(
    data: &[f32],
    lines: [Axis; 2],
    pixels: [Axis; 2],
    out: &mut [f32],
) -> Result<(), Error> {
    resample_in_steps(data, lines, pixels, out, &mut || {})
}

/// [`resample`]; reports each step to `progress`.
pub(super) fn resample_in_steps(
    data: &[f32],
    [beams, samples]: [Axis; 2],
    [rows, columns]: [Axis; 2],
    out: &mut [f32],
    progress: &mut dyn FnMut(),
) -> Result<(), Error> {
    check_axes(&beams, &samples, &rows, &columns)?;
    check_length(
        "lines to resample",
        data.len(),
        beams.count.saturating_mul(samples.count),
    )?;
    check_length(
        "resampled image",
        out.len(),
        rows.count.saturating_mul(columns.count),
    )?;
    let most = finite_largest("lines to resample", data)?;
    if rows.count == 0 || columns.count == 0 {
        return Ok(());
    }

    // A few columns at a time, whose positions among the beams serve all rows.
    const AT_A_TIME: usize = 64;
    for first in (0..columns.count).step_by(AT_A_TIME) {
        let mut positions = [None; AT_A_TIME];
        let end = (first + AT_A_TIME).min(columns.count);
        for (position, column) in positions.iter_mut().zip(first..end) {
            *position = beams.locate(columns.position(column));
        }
        for (row, pixels) in out.chunks_exact_mut(columns.count).enumerate() {
            let along_samples = samples.locate(rows.position(row));
            let pixels = pixels.get_mut(first..end).unwrap_or_default();
            for (pixel, position) in pixels.iter_mut().zip(positions) {
                *pixel = 0.0;
                if let (Some(beam), Some(sample)) = (position, along_samples)
                    && let Some(value) = interpolate((data, most), samples.count, beam, sample)
                {
                    *pixel = value;
                }
            }
            if (row + 1).is_multiple_of(STEP / AT_A_TIME) {
                progress();
            }
        }
        progress();
    }
    Ok(())
}

/// Refuses axes that are not finite and ascending, and data without an interval.
pub(super) const fn check_axes(
    beams: &Axis,
    samples: &Axis,
    rows: &Axis,
    columns: &Axis,
) -> Result<(), Error> {
    let spacings = [
        (beams, "beam spacing"),
        (samples, "sample spacing"),
        (rows, "row spacing"),
        (columns, "column spacing"),
    ];
    let mut k = 0;
    while k < spacings.len() {
        let (axis, name) = spacings[k];
        attempt!(axis.check(name));
        k += 1;
    }
    let counts = [(beams, "number of beams"), (samples, "number of samples")];
    let mut k = 0;
    while k < counts.len() {
        let (axis, name) = counts[k];
        if axis.count < 2 {
            let expected = "at least 2, to interpolate between";
            return Err(Error::parameter(name, axis.count as f64, expected));
        }
        k += 1;
    }
    Ok(())
}

/// The value at `p` of the way from one line to the next and `q` from one sample to the next, at most `most`.
#[inline]
pub(super) fn interpolate(
    (data, most): (&[f32], f32),
    samples: usize,
    (line, p): (usize, f32),
    (sample, q): (usize, f32),
) -> Option<f32> {
    let corner = line * samples + sample;
    let ([a, b], [c, d]) = (pair(data, corner)?, pair(data, corner + samples)?);
    let value = between(between(*a, *b, q), between(*c, *d, q), p);
    Some(if value > most { most } else { value })
}

/// The values at an index and the next one.
fn pair(data: &[f32], at: usize) -> Option<&[f32; 2]> {
    data.get(at..)?.first_chunk()
}

fn between(a: f32, b: f32, fraction: f32) -> f32 {
    (1.0 - fraction) * a + fraction * b
}
