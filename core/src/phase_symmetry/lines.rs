//! Lines in the lanes of vectors, and back in memory.

use crate::simd::Vector;

/// How `lines` lines go into the lanes of vectors: the first of each vector, and how many.
#[inline(always)]
pub(super) fn groups<V: Vector>(lines: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..lines)
        .step_by(V::LANES)
        .map(move |first| (first, (lines - first).min(V::LANES)))
}

/// The first `lanes` numbers from place `at` on, in the lanes of a vector that is otherwise `rest`.
#[inline(always)]
pub(super) fn load_partial<V: Vector>(rest: V, from: &[f32], at: usize, lanes: usize) -> V {
    let mut vector = rest;
    if V::LANES == 1 {
        // One check instead of a slice's two.
        vector.lanes_mut()[0] = from[at];
    } else if lanes == V::LANES {
        // A length that the compiler knows makes this one instruction.
        vector.lanes_mut().copy_from_slice(&from[at..at + V::LANES]);
    } else {
        vector.lanes_mut()[..lanes].copy_from_slice(&from[at..at + lanes]);
    }
    vector
}

/// The first `lanes` lanes, to as many numbers from place `at` on.
#[inline(always)]
pub(super) fn store_partial<V: Vector>(vector: V, to: &mut [f32], at: usize, lanes: usize) {
    if V::LANES == 1 {
        to[at] = vector.lanes()[0];
    } else if lanes == V::LANES {
        to[at..at + V::LANES].copy_from_slice(vector.lanes());
    } else {
        to[at..at + lanes].copy_from_slice(&vector.lanes()[..lanes]);
    }
}
