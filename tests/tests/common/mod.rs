//! Shared code of the test files.

pub mod delays;
pub mod frames;
pub mod lines;
pub mod refused;
pub mod tolerances;

use bonebeam::Complex;

/// Asserts equal bits, so that 0 and −0 differ.
pub fn assert_same_bits(left: &[Complex<f32>], right: &[Complex<f32>], what: &str) {
    let [left, right] = [left, right].map(bonebeam_tests::kernel::bits);
    let at = left.iter().zip(&right).position(|(a, b)| a != b);
    assert!(
        at.is_none() && left.len() == right.len(),
        "{what}: other bits at {at:?}"
    );
}

/// A value with something changed.
pub fn changed<T>(mut value: T, change: impl FnOnce(&mut T)) -> T {
    change(&mut value);
    value
}
