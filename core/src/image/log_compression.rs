//! Log compression: decibels below the frame's largest envelope, mapped to 0..255.

use super::check_finite;
use crate::Error;
use crate::error::check_length;

/// The largest value of an envelope, 0 for an empty one: the reference of a frame. An infinite one
/// is returned as such, for [`log_compression`] to refuse; NaN is passed over.
pub fn largest(envelope: &[f32]) -> f32 {
    let mut largest = 0.0;
    for &value in envelope {
        if value > largest {
            largest = value;
        }
    }
    largest
}

/// Maps `[−dynamic_range, 0]` dB relative to `reference` linearly to `0..255`, and what lies
/// outside to the nearer end: `255 + 20·log₁₀(envelope/reference)·(255/dynamic_range)`.
///
/// `reference` is the frame's largest envelope ([`largest`]), so that a frame can be compressed
/// line by line. The reference itself gives exactly 255, a zero envelope exactly 0, and a zero
/// reference (an empty frame) 0 everywhere. `dynamic_range` is in dB.
///
/// No memory of its own; a division and a logarithm a sample.
///
/// ```
/// use bonebeam::image::{largest, log_compression};
///
/// let envelope = [2.0, 0.2, 0.0];
/// let mut levels = [0.0; 3];
/// log_compression(&envelope, largest(&envelope), 40.0, &mut levels)?;
/// assert_eq!(levels, [255.0, 127.5, 0.0]);
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// # Errors
/// [`Error::Parameter`] for a dynamic range that is not positive, a reference or an envelope
/// below zero; [`Error::NonFinite`]; [`Error::Length`]. `out` is then untouched.
pub fn log_compression(
    envelope: &[f32],
    reference: f32,
    dynamic_range: f32,
    out: &mut [f32],
) -> Result<(), Error> {
    check_length("log compression output", out.len(), envelope.len())?;
    check_range(dynamic_range)?;
    check_not_negative("reference envelope", reference)?;
    check_finite("envelope", envelope)?;
    for &value in envelope {
        check_not_negative("envelope", value)?;
    }
    let slope = 255.0 / dynamic_range;
    for (out, &value) in out.iter_mut().zip(envelope) {
        *out = level(value, reference, slope);
    }
    Ok(())
}

pub(super) fn check_range(dynamic_range: f32) -> Result<(), Error> {
    if dynamic_range > 0.0 && dynamic_range.is_finite() {
        return Ok(());
    }
    Err(Error::Parameter {
        name: "dynamic range in dB",
        value: dynamic_range.into(),
        expected: "a finite number above 0",
    })
}

fn check_not_negative(name: &'static str, value: f32) -> Result<(), Error> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Error::Parameter {
            name,
            value: value.into(),
            expected: "a finite number of at least 0",
        })
    }
}

/// `slope` is in grey levels per decibel.
fn level(value: f32, reference: f32, slope: f32) -> f32 {
    if value == 0.0 || reference == 0.0 {
        return 0.0;
    }
    if value >= reference {
        return 255.0;
    }
    // The quotient can vanish where the reference is huge; its logarithm is then −∞, the slope
    // may overflow for a tiny dynamic range, and both end at 0 below.
    let decibels = 20.0 * libm::log10f(value / reference);
    let level = 255.0 + decibels * slope;
    if level > 0.0 { level } else { 0.0 }
}
