//! Lines to an image: envelope, decibels, pixels, median.

use crate::bounds::RANGE;
use crate::memory::{Output, array, complex, one};
use crate::status::{Refused, Status, chosen, status};
use crate::vectors::zero;
use crate::{Axis, Complex};
use bonebeam::geometry;
use bonebeam::image::{self, envelope, largest, log_compression_with, median, resample};

impl Axis {
    pub(crate) fn of(axis: geometry::Axis) -> Self {
        let geometry::Axis { first, step, count } = axis;
        Axis { first, step, count }
    }

    pub(crate) fn core(&self) -> geometry::Axis {
        geometry::Axis {
            first: self.first,
            step: self.step,
            count: self.count,
        }
    }
}

pub(crate) fn product(a: usize, b: usize) -> Result<usize, Refused> {
    a.checked_mul(b).ok_or(Refused::Of(Status::Length))
}

/// Computes `|z|` of `length` samples.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_envelope(
    z: *const Complex,
    length: usize,
    out: *mut f32,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let out = Output::new(out, length)?;
        let z = out.apart(complex(z, length)?)?;
        Ok(envelope(z, out.values())?)
    })
}

/// Returns the largest of `length` envelopes; 0 for a null pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_largest(envelopes: *const f32, length: usize) -> f32 {
    // SAFETY: by the caller's promise.
    unsafe { array(envelopes, length) }.map_or(0.0, largest)
}

/// The computation of decibels.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum Logarithm {
    /// libm's logarithm.
    Exact = 0,
    /// A polynomial, with fewer instructions.
    ///
    /// `Logarithm::Polynomial` in the core's documentation gives the error.
    Polynomial = 1,
}

/// Computes grey levels 0 to 255 from envelopes.
///
/// 255 is `reference`, and 0 is `dynamic_range` dB below it. `logarithm` is one of `bonebeam_logarithm`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_log_compression(
    logarithm: i32,
    envelopes: *const f32,
    length: usize,
    reference: f32,
    dynamic_range: f32,
    out: *mut f32,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        RANGE.check("dynamic_range", dynamic_range.into())?;
        let all = [image::Logarithm::Exact, image::Logarithm::Polynomial];
        let by = chosen("logarithm", logarithm, &all)?;
        let out = Output::new(out, length)?;
        let envelopes = out.apart(array(envelopes, length)?)?;
        Ok(log_compression_with(
            by,
            envelopes,
            reference,
            dynamic_range,
            out.values(),
        )?)
    })
}

/// Resamples grey levels of lines to pixels.
///
/// Input `[beam][sample]`, output `[row][column]`, 0 beyond the lines.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_resample(
    levels: *const f32,
    beams: *const Axis,
    samples: *const Axis,
    rows: *const Axis,
    columns: *const Axis,
    out: *mut f32,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let axes = [one(beams)?, one(samples)?, one(rows)?, one(columns)?];
        let [beams, samples, rows, columns] = axes.map(Axis::core);
        let out = Output::new(out, product(rows.count, columns.count)?)?;
        let levels = out.apart(array(levels, product(beams.count, samples.count)?)?)?;
        let pixels = out.values();
        Ok(resample(levels, [beams, samples], [rows, columns], pixels)?)
    })
}

/// Computes the median of 3 × 3 pixels, for an image `[row][column]`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_median(
    image: *const f32,
    rows: usize,
    columns: usize,
    out: *mut f32,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let pixels = product(rows, columns)?;
        let out = Output::new(out, pixels)?;
        let image = out.apart(array(image, pixels)?)?;
        Ok(median(zero(), image, columns, out.values())?)
    })
}
