//! The largest magnitude of many numbers.
//!
//! A function of its own on 32-bit processors. If it is inlined, the compiler lacks registers and keeps a loop index
//! beside the address (64 elements of DAS: 796 instructions per sample instead of 700).

use crate::Complex;

/// Bits of the largest magnitude.
///
/// Bits order as magnitudes do, and numbers that are not finite come last.
#[cfg_attr(target_pointer_width = "32", inline(never))]
pub(crate) fn largest(x: &[f32]) -> u32 {
    largest_of(x, |&value| [value])
}

/// Bits of the largest magnitude of all real and imaginary parts.
#[cfg_attr(target_pointer_width = "32", inline(never))]
pub(crate) fn largest_part(x: &[Complex<f32>]) -> u32 {
    largest_of(x, |value| [value.re, value.im])
}

#[inline(always)]
fn largest_of<T, const PARTS: usize>(x: &[T], parts: impl Fn(&T) -> [f32; PARTS]) -> u32 {
    if cfg!(any(target_pointer_width = "32", target_arch = "aarch64")) {
        in_one_chain(x, parts)
    } else {
        side_by_side(x, parts)
    }
}

/// Without vectors one chain is best, and a shift is part of Arm's comparison. NEON has the larger of two integers, so
/// the compiler makes registers of the chain.
#[inline(always)]
fn in_one_chain<T, const PARTS: usize>(x: &[T], parts: impl Fn(&T) -> [f32; PARTS]) -> u32 {
    let mut largest = 0;
    for value in x {
        for part in parts(value) {
            let doubled = part.to_bits() << 1;
            largest = if largest < doubled { doubled } else { largest };
        }
    }
    largest >> 1
}

/// For registers of any size. All have instructions for the larger of two numbers, but these lose a NaN. A sum keeps it,
/// in any order: if it is not finite, bits are compared.
#[inline(always)]
fn side_by_side<T, const PARTS: usize>(x: &[T], parts: impl Fn(&T) -> [f32; PARTS]) -> u32 {
    const SIDE_BY_SIDE: usize = 8;
    let mut largest = [[0.0; PARTS]; SIDE_BY_SIDE];
    let mut sums = [[0.0; PARTS]; SIDE_BY_SIDE];
    let (blocks, rest) = x.as_chunks::<SIDE_BY_SIDE>();
    for block in blocks {
        for ((largest, sums), value) in largest.iter_mut().zip(&mut sums).zip(block) {
            for ((largest, sum), part) in largest.iter_mut().zip(sums).zip(parts(value)) {
                let part = libm::fabsf(part);
                *largest = if *largest < part { part } else { *largest };
                *sum += part;
            }
        }
    }
    let mut finite = true;
    for &sum in sums.as_flattened() {
        finite &= sum.is_finite();
    }
    if !finite {
        return in_one_chain(x, parts);
    }
    let rest = rest.iter().flat_map(|value| parts(value).map(magnitude));
    let mut all = 0;
    for part in largest.into_iter().flatten().map(magnitude).chain(rest) {
        all = if all < part { part } else { all };
    }
    all as u32
}

fn magnitude(part: f32) -> i32 {
    (part.to_bits() & 0x7fff_ffff) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_is_found_wherever_it_stands() {
        for length in (0..40).step_by(crate::step(9)) {
            for index in (0..length).step_by(crate::step(4)) {
                let x: std::vec::Vec<f32> = (0..length)
                    .map(|k| if k == index { -7.5 } else { k as f32 / 10.0 })
                    .collect();
                assert_eq!(largest(&x), 7.5f32.to_bits());
                assert_eq!(in_one_chain(&x, |&x| [x]), 7.5f32.to_bits());
                assert_eq!(side_by_side(&x, |&x| [x]), 7.5f32.to_bits());
                let turned = |&x: &f32| [Complex::new(x, 0.5), Complex::new(-0.25, x)];
                for part in 0..2 {
                    let y: std::vec::Vec<_> = x.iter().map(|x| turned(x)[part]).collect();
                    assert_eq!(largest_part(&y), 7.5f32.to_bits());
                }
            }
        }
        assert_eq!(largest(&[]), 0);
        // Sums of these are not finite; the numbers are, or one is not.
        let mut x = [f32::MAX; 70];
        assert_eq!(side_by_side(&x, |&x| [x]), f32::MAX.to_bits());
        for other in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for index in [0, 8, 69] {
                x = [1.0; 70];
                x[index] = other;
                let expected = other.to_bits() & 0x7fff_ffff;
                assert_eq!(side_by_side(&x, |&x| [x]), expected, "{index}");
            }
        }
        assert!(largest(&[1.0, -f32::NAN]) > f32::INFINITY.to_bits());
        assert_eq!(largest(&[1.0, f32::NEG_INFINITY]), f32::INFINITY.to_bits());
    }
}
