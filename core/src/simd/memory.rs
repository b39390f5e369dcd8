//! From memory into lanes.

use super::Vector;

/// The lanes of the widest vector.
pub(crate) const MOST_LANES: usize = 16;

/// The first lanes' worth of `from`, which is that long at least.
#[inline(always)]
pub(crate) fn load<V: Vector>(zero: V, from: &[f32]) -> V {
    let mut vector = zero;
    vector.lanes_mut().copy_from_slice(&from[..V::LANES]);
    vector
}

/// Takes the first `length` numbers off `from`, which is as long at least.
#[inline(always)]
pub(crate) fn first<'a, T>(from: &mut &'a mut [T], length: usize) -> &'a mut [T] {
    from.split_off_mut(..length).unwrap_or_default()
}

/// Copies between slices of one length. Where the compiler sees that it is one, this is no more than the
/// copy, as `copy_from_slice` is; elsewhere that would bring a panic.
#[inline(always)]
pub(crate) fn copy<T: Copy>(from: &[T], to: &mut [T]) {
    if from.len() == to.len() {
        to.copy_from_slice(from);
    }
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
