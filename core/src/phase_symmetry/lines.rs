//! Lines in the lanes of vectors, and back in memory.

use crate::vector::Vector;

/// The lanes of the widest vector.
const MOST_LANES: usize = 16;

/// How `lines` lines go into the lanes of vectors: the first of each vector, and how many.
#[inline(always)]
pub(super) fn groups<V: Vector>(lines: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..lines).step_by(V::LANES).map(move |first| {
        let left = lines - first;
        (first, if left < V::LANES { left } else { V::LANES })
    })
}

/// The first `lanes` numbers, in the lanes of a vector that is otherwise `rest`.
#[inline(always)]
pub(super) fn load<V: Vector>(rest: V, from: &[f32], lanes: usize) -> V {
    let mut vector = rest;
    if lanes == V::LANES {
        // A length that the compiler knows makes this one instruction.
        vector.lanes_mut().copy_from_slice(&from[..V::LANES]);
    } else {
        vector.lanes_mut()[..lanes].copy_from_slice(&from[..lanes]);
    }
    vector
}

/// The first `lanes` lanes, to as many numbers.
#[inline(always)]
pub(super) fn store<V: Vector>(vector: V, to: &mut [f32], lanes: usize) {
    if lanes == V::LANES {
        to[..V::LANES].copy_from_slice(vector.lanes());
    } else {
        to[..lanes].copy_from_slice(&vector.lanes()[..lanes]);
    }
}

/// A square of numbers; only the first vectors count, as many as one has lanes.
pub(super) type Square<V> = [V; MOST_LANES];

/// The rows of a square become its columns: vector `k` gets lane `k` of every vector.
#[inline(always)]
pub(super) fn transpose<V: Vector>(square: &mut Square<V>) {
    // Each round moves one more bit of the row's number into the lane's.
    for _ in 0..V::LANES.trailing_zeros() {
        let before = *square;
        for k in 0..V::LANES / 2 {
            (square[2 * k], square[2 * k + 1]) = before[k].interleave(before[k + V::LANES / 2]);
        }
    }
}
