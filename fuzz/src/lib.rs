//! Shared code of the fuzz targets: numbers from bytes, and bits.

use bonebeam::Complex;
use bonebeam::simd::InstructionSet;

/// One of this processor's instruction sets.
pub fn instruction_set(choice: u8) -> InstructionSet {
    let count = InstructionSet::available().count();
    let mut sets = InstructionSet::available();
    let set = sets.nth(usize::from(choice) % count);
    set.unwrap_or(InstructionSet::Scalar)
}

/// A size of 1 to `few`, or up to about `most` for one choice in 16.
///
/// Small sizes take little time, and reach the same branches.
pub fn size(choice: u8, few: usize, most: usize) -> usize {
    match usize::from(choice) {
        choice @ ..240 => 1 + choice % few,
        choice => 1 + (choice - 240) * most / 16,
    }
}

/// Maps the bits of `number` to the range from `least` to `most`.
pub fn within(number: f64, [least, most]: [f64; 2]) -> f64 {
    let share = number.to_bits() as f64 / u64::MAX as f64;
    least + share * (most - least)
}

/// A float from bits; 0 if it is not finite.
pub fn finite(bits: u32) -> f32 {
    let value = f32::from_bits(bits);
    if value.is_finite() { value } else { 0.0 }
}

/// Finite samples: small numbers of a common scale, or any bits.
///
/// The small numbers make covariances as recordings do. Too few bytes are repeated.
pub fn samples(bytes: &[u8], count: usize, any_bits: bool, exponent: i8) -> Vec<f32> {
    let byte = |index: usize| match bytes.len() {
        0 => 0,
        // Rotated, since repeated rows would be equal.
        length => bytes[index % length].rotate_left((index / length) as u32 % 8),
    };
    let scale = f32::from(exponent).exp2();
    (0..count)
        .map(|index| match any_bits {
            true => finite(u32::from_le_bytes(
                [0, 1, 2, 3].map(|k| byte(4 * index + k)),
            )),
            false => f32::from(byte(index) as i8) * scale,
        })
        .map(|value| if value.is_finite() { value } else { 0.0 })
        .collect()
}

/// Pairs of samples.
pub fn complex(bytes: &[u8], count: usize, any_bits: bool, exponent: i8) -> Vec<Complex<f32>> {
    let parts = samples(bytes, 2 * count, any_bits, exponent);
    parts
        .chunks(2)
        .map(|part| Complex::new(part[0], part[1]))
        .collect()
}

/// The bits of numbers, which must all be finite.
pub fn finite_bits(values: &[f32]) -> Vec<u32> {
    assert!(
        values.iter().all(|value| value.is_finite()),
        "a result that is not finite"
    );
    values.iter().map(|value| value.to_bits()).collect()
}

/// The bits of complex numbers, which must all be finite.
pub fn finite_complex_bits(values: &[Complex<f32>]) -> Vec<u32> {
    let parts: Vec<f32> = values
        .iter()
        .flat_map(|value| [value.re, value.im])
        .collect();
    finite_bits(&parts)
}
