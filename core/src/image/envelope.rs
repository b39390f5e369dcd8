//! The envelope: the magnitude of the analytic signal.

use crate::Error;
use crate::error::check_length;
use crate::magnitude::largest_part;
use num_complex::Complex;

/// `|z|` of each sample, in the unit of `z`.
///
/// With `a ≥ b` the magnitudes of the two parts: `a·√(1 + (b/a)²)`, so that no square overflows
/// or vanishes. A magnitude beyond `f32::MAX` (both parts near it) gives `f32::MAX`. Scaling the
/// input by a power of two scales the result exactly.
///
/// RAM: none. Cost: a division and a square root per sample.
///
/// ```
/// use bonebeam::Complex;
///
/// let mut out = [0.0; 2];
/// bonebeam::image::envelope(&[Complex::new(3.0, -4.0), Complex::new(0.0, 1.0)], &mut out)?;
/// assert_eq!(out, [5.0, 1.0]);
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// # Errors
/// [`Error::Length`] if `out` and `z` differ in length, [`Error::NonFinite`] with the index of the first bad
/// sample; `out` is then unchanged.
pub fn envelope(z: &[Complex<f32>], out: &mut [f32]) -> Result<(), Error> {
    check_length("envelope output", out.len(), z.len())?;
    check_signal(z)?;
    for (out, z) in out.iter_mut().zip(z) {
        *out = magnitude(*z);
    }
    Ok(())
}

/// Refuses numbers that are not finite.
pub(super) fn check_signal(z: &[Complex<f32>]) -> Result<(), Error> {
    if largest_part(z) < f32::INFINITY.to_bits() {
        return Ok(());
    }
    let bad = z.iter().position(|z| !z.is_finite());
    Err(Error::NonFinite {
        name: "analytic signal",
        index: bad.unwrap_or(0),
    })
}

#[inline(always)]
pub(super) fn magnitude(z: Complex<f32>) -> f32 {
    let (re, im) = (z.re.abs(), z.im.abs());
    let (large, small) = if re < im { (im, re) } else { (re, im) };
    if large == 0.0 {
        return 0.0;
    }
    let ratio = small / large;
    let value = large * crate::instructions::sqrt(1.0 + ratio * ratio);
    if value < f32::MAX { value } else { f32::MAX }
}
