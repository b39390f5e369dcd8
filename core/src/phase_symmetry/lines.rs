//! Lines in the lanes of vectors, and back in memory.

use crate::vector::Vector;

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
