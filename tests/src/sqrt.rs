//! The square root: one instruction on a microcontroller, a library's elsewhere.

use bonebeam::simd::Vector;

use crate::hash;

/// Every so many of the floats in ascending order are tried: a prime.
pub const STEP: usize = 2039;

/// The floats tried: a million from 0 up to the largest, 4115 of them subnormal.
pub fn arguments() -> impl Iterator<Item = f32> {
    (0..f32::INFINITY.to_bits())
        .step_by(STEP)
        .map(f32::from_bits)
}

pub(crate) fn run(report: &mut impl FnMut(&str, u64)) {
    report("sqrt", hash::of(arguments().map(Vector::sqrt)));
}
