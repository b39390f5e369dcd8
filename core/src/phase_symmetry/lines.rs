//! Lines in the lanes of vectors, and back in memory.

use crate::simd::Vector;

/// Puts `lines` lines into the lanes of vectors: `work` gets the first line of each vector, and how
/// many there are in it. It is compiled twice, for whole vectors and for the rest, so that the former are
/// read and written by single instructions.
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
        vector.lanes_mut()[0] = from[at];
    } else if lanes == V::LANES {
        // A length that the compiler knows makes this one instruction.
        vector.lanes_mut().copy_from_slice(&from[at..at + V::LANES]);
    } else {
        vector.lanes_mut()[..lanes].copy_from_slice(&from[at..at + lanes]);
    }
    vector
}

/// The first `lanes` lanes, to as many numbers of `to[at..]`.
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
