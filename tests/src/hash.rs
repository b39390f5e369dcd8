//! The hash of a result: FNV-1a, 64 bits, over the little-endian bits of its numbers in order.

use bonebeam::Complex;
use core::hash::Hasher;
use fnv::FnvHasher;

/// The hash of real numbers.
pub fn real(values: &[f32]) -> u64 {
    of(values.iter().copied())
}

/// The hash of complex numbers, each its real part and then its imaginary one.
pub fn complex(values: &[Complex<f32>]) -> u64 {
    of(values.iter().flat_map(|z| [z.re, z.im]))
}

/// The hash of the real numbers that an iterator gives.
pub fn of(values: impl Iterator<Item = f32>) -> u64 {
    let mut hasher = FnvHasher::default();
    for value in values {
        hasher.write(&value.to_bits().to_le_bytes());
    }
    hasher.finish()
}
