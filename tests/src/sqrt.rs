//! The square root: an instruction on a microcontroller, a library elsewhere.

use bonebeam::simd::Vector;

use crate::hash;

/// Every `STEP`-th float in ascending order is tried; `STEP` is a prime.
pub const STEP: usize = 2039;

/// The tested floats: a million from 0 to the largest, 4115 of them subnormal.
pub fn arguments() -> impl Iterator<Item = f32> {
    (0..f32::INFINITY.to_bits())
        .step_by(STEP)
        .map(f32::from_bits)
}

pub(crate) fn run(report: &mut impl FnMut(&str, u64)) {
    report("sqrt", hash::of(arguments().map(Vector::sqrt)));
}
