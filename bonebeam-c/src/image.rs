//! Lines to an image: envelope, decibels, pixels, median.

use crate::memory::{array, array_mut, one};
use crate::status::{Status, status};
use crate::{Axis, Complex};
use bonebeam::geometry;
use bonebeam::image::{envelope, largest, log_compression, median, resample};

impl Axis {
    fn core(&self) -> geometry::Axis {
        geometry::Axis {
            first: self.first,
            step: self.step,
            count: self.count,
        }
    }
}

/// `|z|` of `length` samples.
///
/// # Safety
/// `z` and `out` lead to `length` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_envelope(
    z: *const Complex,
    length: usize,
    out: *mut f32,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise. The core's complex number is two floats as well.
        let (z, out): (&[bonebeam::Complex<f32>], _) =
            unsafe { (array(z.cast(), length)?, array_mut(out, length)?) };
        Ok(envelope(z, out)?)
    })
}

/// The largest of `length` envelopes; 0 for a null pointer.
///
/// # Safety
/// `envelopes` leads to `length` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_largest(envelopes: *const f32, length: usize) -> f32 {
    // SAFETY: by the caller's promise.
    unsafe { array(envelopes, length) }.map_or(0.0, largest)
}

/// Grey levels 0 to 255: decibels relative to `reference`, of which `dynamic_range` dB are shown.
///
/// # Safety
/// `envelopes` and `out` lead to `length` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_log_compression(
    envelopes: *const f32,
    length: usize,
    reference: f32,
    dynamic_range: f32,
    out: *mut f32,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let (envelopes, out) = unsafe { (array(envelopes, length)?, array_mut(out, length)?) };
        Ok(log_compression(envelopes, reference, dynamic_range, out)?)
    })
}

/// Grey levels of lines, `[beam][sample]`, as pixels `[row][column]`; 0 beyond the lines.
///
/// # Safety
/// The axes lead to what they say; `levels` to beams · samples numbers, `out` to rows · columns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_resample(
    levels: *const f32,
    beams: *const Axis,
    samples: *const Axis,
    rows: *const Axis,
    columns: *const Axis,
    out: *mut f32,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let [beams, samples, rows, columns] =
            unsafe { [one(beams)?, one(samples)?, one(rows)?, one(columns)?] }.map(Axis::core);
        let product = |a: usize, b: usize| a.checked_mul(b).ok_or(Status::Length);
        let (read, written) = (
            product(beams.count, samples.count)?,
            product(rows.count, columns.count)?,
        );
        // SAFETY: by the caller's promise.
        let (levels, out) = unsafe { (array(levels, read)?, array_mut(out, written)?) };
        Ok(resample(levels, beams, samples, rows, columns, out)?)
    })
}

/// The median of 3 × 3 pixels.
///
/// # Safety
/// `image` and `out` lead to rows · columns numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_median(
    image: *const f32,
    rows: usize,
    columns: usize,
    out: *mut f32,
) -> Status {
    status(|| {
        let pixels = rows.checked_mul(columns).ok_or(Status::Length)?;
        // SAFETY: by the caller's promise.
        let (image, out) = unsafe { (array(image, pixels)?, array_mut(out, pixels)?) };
        Ok(median(0.0f32, image, columns, out)?)
    })
}
