//! Transposition of lines between memory and lanes.

use crate::simd::Vector;
use core::hint::cold_path;
use num_complex::Complex;

/// Groups `lines` lines into the lanes of vectors.
///
/// `work` receives the first line of each vector and its number of lines. It is compiled twice, for whole vectors and
/// for the rest, so that whole vectors are read and written by single instructions.
#[inline(always)]
pub(super) fn in_groups<V: Vector>(lines: usize, mut work: impl FnMut(usize, usize)) {
    let whole = lines / V::LANES * V::LANES;
    for first in (0..whole).step_by(V::LANES) {
        work(first, V::LANES);
    }
    if whole < lines {
        work(whole, lines - whole);
    }
}

/// The first `lanes` numbers of `from[at..]`, in the lanes of a vector that is otherwise `rest`.
#[inline(always)]
pub(super) fn load_partial<V: Vector>(rest: V, from: &[f32], at: usize, lanes: usize) -> V {
    let mut vector = rest;
    if V::LANES == 1 {
        // One check instead of a slice's two.
        vector = vector.splat(from.get(at).copied().unwrap_or_default());
    } else if lanes == V::LANES {
        // A length that the compiler knows makes this one instruction.
        vector.lanes_mut().copy_from_slice(&from[at..at + V::LANES]);
    } else {
        vector.lanes_mut()[..lanes].copy_from_slice(&from[at..at + lanes]);
    }
    vector
}

/// Real parts from `first` on, and as many imaginary ones from `width` further on.
#[inline(always)]
pub(super) fn parts(numbers: &[f32], first: usize, width: usize) -> Option<[&[f32]; 2]> {
    let im = numbers.get(first + width..)?;
    Some([numbers.get(first..first + im.len())?, im])
}

/// The complex numbers of [`parts`] from `at` on, in the lanes of a vector.
#[inline(always)]
pub(super) fn load_complex<V: Vector>(
    zero: V,
    [re, im]: [&[f32]; 2],
    at: usize,
    lanes: usize,
) -> Complex<V> {
    if V::LANES == 1 {
        // One check for both.
        let (Some(&re), Some(&im)) = (re.get(at), im.get(at)) else {
            cold_path();
            return Complex::new(zero, zero);
        };
        return Complex::new(zero.splat(re), zero.splat(im));
    }
    Complex::new(
        load_partial(zero, re, at, lanes),
        load_partial(zero, im, at, lanes),
    )
}

/// The first `lanes` lanes, to as many numbers of `to[at..]`.
#[inline(always)]
pub(super) fn store_partial<V: Vector>(vector: V, to: &mut [f32], at: usize, lanes: usize) {
    if V::LANES == 1 {
        if let Some(number) = to.get_mut(at) {
            *number = vector.lanes()[0];
        }
    } else if lanes == V::LANES {
        to[at..at + V::LANES].copy_from_slice(vector.lanes());
    } else {
        to[at..at + lanes].copy_from_slice(&vector.lanes()[..lanes]);
    }
}

/// Adds the first `lanes` lanes to as many numbers of `to[at..]`.
#[inline(always)]
pub(super) fn add_partial<V: Vector>(vector: V, to: &mut [f32], at: usize, lanes: usize) {
    if V::LANES == 1 {
        // A single look-up.
        if let Some(number) = to.get_mut(at) {
            *number += vector.lanes()[0];
        }
    } else {
        let sum = load_partial(vector.zero(), to, at, lanes) + vector;
        store_partial(sum, to, at, lanes);
    }
}
