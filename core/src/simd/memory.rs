//! From memory into lanes.

use super::Vector;

/// The lanes of the widest vector.
pub(crate) const MOST_LANES: usize = 16;

/// The first lanes' worth of `from`.
#[inline(always)]
pub(crate) fn load<V: Vector>(zero: V, from: &[f32]) -> V {
    let mut vector = zero;
    vector.lanes_mut().copy_from_slice(&from[..V::LANES]);
    vector
}

/// The rows of a square become its columns: vector `k` gets lane `k` of every vector. Only the first
/// vectors count, as many as one has lanes.
#[inline(always)]
pub(crate) fn transpose<V: Vector>(square: &mut [V; MOST_LANES]) {
    // Each round moves one more bit of the row's number into the lane's.
    for _ in 0..V::LANES.trailing_zeros() {
        let before = *square;
        for k in 0..V::LANES / 2 {
            (square[2 * k], square[2 * k + 1]) = before[k].interleave(before[k + V::LANES / 2]);
        }
    }
}
