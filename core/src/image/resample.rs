//! Bilinear resampling of lines to isotropic pixels.

use super::check_finite;
use crate::Error;
use crate::error::check_length;

/// Uniformly spaced positions: `first + k·step` for `k` in `0..count`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Axis {
    /// The position of index 0 (m).
    pub first: f64,
    /// From one index to the next (m), positive.
    pub step: f64,
    /// How many positions there are.
    pub count: usize,
}

/// Bilinear interpolation of `data`, row-major `[beam][sample]`, at the pixels of an image,
/// row-major `[row][column]` with row 0 shallowest.
///
/// `beams` and `columns` are positions along x, `samples` and `rows` along z, in the same unit.
/// A pixel outside the data is 0; one that lies beyond the first or last position by no more
/// than 10⁻⁶ of a step counts as on it, so that rounding cannot blank an edge.
/// With the fractions `p` along the beams and `q` along the samples:
/// `(1−p)·((1−q)·d₀₀ + q·d₀₁) + p·((1−q)·d₁₀ + q·d₁₁)`, where `p` and `q` are rounded to f32 once
/// from an f64 position. At a data point the result is that point, exactly.
///
/// RAM: 1.5 KiB of stack. Per pixel 6 f32 multiplications; an f64 division and a rounding a column,
/// and a row for each 64 columns.
///
/// # Errors
/// [`Error::Parameter`] for an axis that is not finite, whose step is not positive, or a data
/// axis of fewer than 2 positions; [`Error::Length`]; [`Error::NonFinite`] with the flat index
/// into `data`. `out` is then untouched.
pub fn resample(
    data: &[f32],
    beams: Axis,
    samples: Axis,
    rows: Axis,
    columns: Axis,
    out: &mut [f32],
) -> Result<(), Error> {
    for (axis, name) in [
        (beams, "beam spacing"),
        (samples, "sample spacing"),
        (rows, "row spacing"),
        (columns, "column spacing"),
    ] {
        axis.check(name)?;
    }
    for (axis, name) in [(beams, "number of beams"), (samples, "number of samples")] {
        if axis.count < 2 {
            return Err(Error::Parameter {
                name,
                value: axis.count as f64,
                expected: "at least 2, to interpolate between",
            });
        }
    }
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
    check_finite("lines to resample", data)?;

    // A few columns at a time, whose places among the beams serve all rows.
    const AT_A_TIME: usize = 64;
    for first in (0..columns.count).step_by(AT_A_TIME) {
        let mut places = [None; AT_A_TIME];
        let end = (first + AT_A_TIME).min(columns.count);
        for (place, column) in places.iter_mut().zip(first..end) {
            *place = beams.locate(columns.position(column));
        }
        for (row, pixels) in out.chunks_exact_mut(columns.count).enumerate() {
            let along_samples = samples.locate(rows.position(row));
            for (pixel, place) in pixels[first..end].iter_mut().zip(places) {
                *pixel = match (place, along_samples) {
                    (Some((beam, p)), Some((sample, q))) => {
                        let corner = beam * samples.count + sample;
                        let near = between(data[corner], data[corner + 1], q);
                        let next = corner + samples.count;
                        let far = between(data[next], data[next + 1], q);
                        between(near, far, p)
                    }
                    _ => 0.0,
                };
            }
        }
    }
    Ok(())
}

fn between(a: f32, b: f32, fraction: f32) -> f32 {
    (1.0 - fraction) * a + fraction * b
}

impl Axis {
    /// How far beyond an end, in steps, still counts as the end.
    const EDGE: f64 = 1e-6;

    fn position(&self, index: usize) -> f64 {
        self.first + index as f64 * self.step
    }

    /// The index below a position, at most `count − 2`, and the fraction of the step above it.
    fn locate(&self, position: f64) -> Option<(usize, f32)> {
        let last = (self.count - 1) as f64;
        let at = (position - self.first) / self.step;
        if !(at >= -Self::EDGE && at <= last + Self::EDGE) {
            return None;
        }
        let at = if at < 0.0 {
            0.0
        } else if at > last {
            last
        } else {
            at
        };
        let floor = libm::floor(at);
        let floor = if floor > last - 1.0 {
            last - 1.0
        } else {
            floor
        };
        Some((floor as usize, (at - floor) as f32))
    }

    fn check(&self, name: &'static str) -> Result<(), Error> {
        let end = self.position(self.count);
        if self.step > 0.0 && self.step.is_finite() && self.first.is_finite() && end.is_finite() {
            Ok(())
        } else {
            Err(Error::Parameter {
                name,
                value: self.step,
                expected: "a finite number above 0, from a finite first position",
            })
        }
    }
}
