//! Log compression: decibels below the frame's largest envelope, mapped to 0..255.

use super::check_finite;
use crate::Error;
use crate::error::{check_length, not_negative};
use crate::memory::STEP;

/// Largest value of an envelope, the reference of a frame; 0 for an empty one.
///
/// An infinite value is returned, and [`log_compression`] refuses it. NaN is skipped.
pub fn largest(envelope: &[f32]) -> f32 {
    let mut largest = 0.0;
    for &value in envelope {
        if value > largest {
            largest = value;
        }
    }
    largest
}

/// Maps decibels relative to `reference` to grey levels `0..255`.
///
/// `[−dynamic_range, 0]` dB is mapped linearly, other values to the nearer end: `255 +
/// 20·log₁₀(envelope/reference)·(255/dynamic_range)`.
///
/// `reference` is the frame's largest envelope ([`largest`]), so that a frame can be compressed
/// line by line. The reference itself gives exactly 255, a zero envelope exactly 0, and a zero
/// reference (an empty frame) 0 everywhere. `dynamic_range` is in dB.
///
/// RAM: none. Cost: a division and a logarithm per sample.
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
/// [`Error::Parameter`] for a dynamic range that is not positive, a reference or an envelope below zero;
/// [`Error::NonFinite`]; [`Error::Length`]. `out` is then unchanged.
pub fn log_compression(
    envelope: &[f32],
    reference: f32,
    dynamic_range: f32,
    out: &mut [f32],
) -> Result<(), Error> {
    log_compression_with(Logarithm::Exact, envelope, reference, dynamic_range, out)
}

/// Logarithm used for the grey levels.
///
/// Both have the same bits on every target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Logarithm {
    /// `libm::log10f`, accurate to one or two roundings.
    #[default]
    Exact,
    /// A polynomial of degree 5 between powers of two, without a branch or a table.
    ///
    /// The error is at most 1.6·10⁻⁴ dB: 8·10⁻⁴ grey levels for a dynamic range of 50 dB. Values more than 758 dB below
    /// the reference are black.
    Polynomial,
}

/// [`log_compression`] with a choice of logarithm.
///
/// ```
/// use bonebeam::image::{Logarithm, log_compression_with};
///
/// let mut levels = [0.0; 3];
/// log_compression_with(Logarithm::Polynomial, &[2.0, 0.2, 0.0], 2.0, 40.0, &mut levels)?;
/// assert_eq!(levels[0], 255.0);
/// assert!((levels[1] - 127.5).abs() < 1e-3); // −20 dB of 40
/// assert_eq!(levels[2], 0.0);
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// # Errors
/// As [`log_compression`].
pub fn log_compression_with(
    logarithm: Logarithm,
    envelope: &[f32],
    reference: f32,
    dynamic_range: f32,
    out: &mut [f32],
) -> Result<(), Error> {
    let range = (reference, dynamic_range);
    log_compression_in_steps(logarithm, envelope, range, out, &mut || {})
}

/// [`log_compression_with`] by reference and dynamic range; reports each step to `progress`.
pub(super) fn log_compression_in_steps(
    logarithm: Logarithm,
    envelope: &[f32],
    (reference, dynamic_range): (f32, f32),
    out: &mut [f32],
    progress: &mut dyn FnMut(),
) -> Result<(), Error> {
    check_length("log compression output", out.len(), envelope.len())?;
    check_range(dynamic_range)?;
    not_negative("reference envelope", reference)?;
    // The bits of invalid values, and of −0, are above the largest float's. A whole chunk at a time, since that needs
    // no branch for each sample.
    let doubtful = |value: &f32| value.to_bits() > f32::MAX.to_bits();
    let any = |chunk: &[f32]| chunk.iter().fold(false, |any, value| any | doubtful(value));
    if envelope.chunks(256).any(any) {
        check_finite("envelope", envelope)?;
        for &value in envelope {
            not_negative("envelope", value)?;
        }
    }
    let slope = 255.0 / dynamic_range;
    for (out, envelope) in out.chunks_mut(STEP).zip(envelope.chunks(STEP)) {
        levels(logarithm, envelope, reference, slope, out);
        progress();
    }
    Ok(())
}

/// Grey levels of a step. By itself, so that its loops have the registers.
#[inline(never)]
fn levels(logarithm: Logarithm, envelope: &[f32], reference: f32, slope: f32, out: &mut [f32]) {
    let pairs = out.iter_mut().zip(envelope);
    match logarithm {
        Logarithm::Exact => {
            for (out, &value) in pairs {
                *out = level(value, reference, slope, exact_decibels);
            }
        }
        Logarithm::Polynomial => {
            for (out, &value) in pairs {
                *out = level(value, reference, slope, decibels);
            }
        }
    }
}

pub(crate) const fn check_range(dynamic_range: f32) -> Result<(), Error> {
    if dynamic_range > 0.0 && dynamic_range.is_finite() {
        return Ok(());
    }
    let expected = "a finite number above 0";
    let value = dynamic_range as f64;
    Err(Error::parameter("dynamic range in dB", value, expected))
}

fn exact_decibels(ratio: f32) -> f32 {
    20.0 * libm::log10f(ratio)
}

/// `20·log₁₀` of a ratio from 2⁻¹²⁶ to below 1; below that −∞.
///
/// With ratio = 2ᵉ·(1 + x): `6.0205999·(e + (x + (x·(1 − x))·p(x)))`, p of degree 3 by Horner's rule, fitted
/// for the smallest largest error. It is exact where x is 0 or 1, so that the pieces meet.
#[inline(always)]
fn decibels(ratio: f32) -> f32 {
    const P: [f32; 4] = [0.441_917_04, -0.267_179_42, 0.148_426_68, -0.045_149_06];
    if ratio < f32::MIN_POSITIVE {
        return f32::NEG_INFINITY;
    }
    let bits = ratio.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let x = f32::from_bits((bits & 0x007F_FFFF) | 0x3F80_0000) - 1.0;
    let p = P[0] + x * (P[1] + x * (P[2] + x * P[3]));
    6.020_6 * (exponent as f32 + (x + (x * (1.0 - x)) * p))
}

/// `slope` is in grey levels per decibel.
#[inline(always)]
fn level(value: f32, reference: f32, slope: f32, decibels: impl Fn(f32) -> f32) -> f32 {
    if value == 0.0 || reference == 0.0 {
        return 0.0;
    }
    if value >= reference {
        return 255.0;
    }
    // The quotient can vanish where the reference is huge; its logarithm is then −∞, the slope
    // may overflow for a tiny dynamic range, and both end at 0 below.
    let level = 255.0 + decibels(value / reference) * slope;
    if level > 0.0 { level } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every mantissa just below 1, where most pixels are, and some of other powers.
    ///
    /// Every 61st of those is tested. Of 1.6·10⁻⁴ the polynomial has 0.94·10⁻⁴. The rounding of e + log₂(1 + x) below
    /// −64 has 2⁻¹⁹ of it, 0.23·10⁻⁴, and the product's rounding at −758 dB 0.31·10⁻⁴.
    #[test]
    fn the_polynomial_errs_by_its_documented_bound() {
        let error = |bits: u32| {
            let ratio = f32::from_bits(bits);
            let exact = 20.0 * libm::log10(f64::from(ratio));
            (f64::from(decibels(ratio)) - exact).abs()
        };
        let mut worst = 0.0f64;
        for mantissa in (0..1 << 23).step_by(crate::step(4003)) {
            worst = worst.max(error(126 << 23 | mantissa));
        }
        assert!(worst > 0.9e-4 && worst < 1.0e-4, "{worst}");
        for exponent in (1..127).step_by(crate::step(31)) {
            for mantissa in (0..1 << 23).step_by(61 * crate::step(30_011)) {
                worst = worst.max(error(exponent << 23 | mantissa));
            }
        }
        assert!(worst < 1.6e-4, "{worst}");
    }

    #[test]
    fn powers_of_two_are_met_from_both_sides() {
        for exponent in 1..127u32 {
            let bits = exponent << 23;
            let (below, at) = (f32::from_bits(bits - 1), f32::from_bits(bits));
            let exact = 6.020_6 * (exponent as f32 - 127.0);
            assert_eq!(decibels(at), exact);
            if exponent > 1 {
                assert!((decibels(below) - exact).abs() < 1e-4);
            }
        }
        assert_eq!(decibels(f32::from_bits(1)), f32::NEG_INFINITY);
    }

    #[test]
    fn the_largest_of_zeros_is_plus_zero() {
        for envelope in [&[][..], &[-0.0], &[0.0, -0.0], &[f32::NAN, -0.0]] {
            assert_eq!(largest(envelope).to_bits(), 0);
        }
    }

    /// Also where no sample of them is good.
    #[test]
    fn envelopes_of_bad_samples_are_refused() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
            for length in [1, 2, 255, 256, 257, 300] {
                let (envelope, mut out) = ([bad; 300], [7.0; 300]);
                let (envelope, out) = (&envelope[..length], &mut out[..length]);
                for logarithm in [Logarithm::Exact, Logarithm::Polynomial] {
                    let refused = log_compression_with(logarithm, envelope, 1.0, 60.0, out);
                    assert!(refused.is_err(), "{length} times {bad}");
                    assert!(out.iter().all(|&level| level == 7.0));
                }
            }
        }
    }

    #[test]
    fn a_zero_envelope_and_a_zero_reference_give_black() {
        for logarithm in [Logarithm::Exact, Logarithm::Polynomial] {
            for (envelope, reference) in [([0.0, -0.0], 1.0), ([1e-30, 1.0], 0.0)] {
                let mut out = [7.0; 2];
                log_compression_with(logarithm, &envelope, reference, 60.0, &mut out).unwrap();
                assert_eq!(out.map(f32::to_bits), [0; 2], "{envelope:?} {reference}");
            }
        }
    }
}
