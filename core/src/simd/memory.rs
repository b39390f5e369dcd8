//! Loads of memory into lanes.

use super::Vector;
use core::slice::SliceIndex;

/// The lanes of the widest vector.
pub(crate) const MOST_LANES: usize = 16;

/// The first `V::LANES` numbers of `from`, which must have that length at least.
#[inline(always)]
pub(crate) fn load<V: Vector>(zero: V, from: &[f32]) -> V {
    let mut vector = zero;
    if let Some(from) = from.get(..V::LANES) {
        copy(from, vector.lanes_mut());
    }
    vector
}

/// Loads one vector from `from[at..]`; `None` past the end.
#[inline(always)]
pub(crate) fn load_at<V: Vector>(zero: V, from: &[f32], at: usize) -> Option<V> {
    let mut vector = zero;
    copy(from.get(at..)?.get(..V::LANES)?, vector.lanes_mut());
    Some(vector)
}

/// Returns `values[index]`; `index` must be in bounds. Vector builds index directly, which saves registers; the
/// scalar build uses `get`, so that no panic is linked.
#[inline(always)]
pub(crate) fn get<V: Vector, T, I: SliceIndex<[T]>>(values: &[T], index: I) -> Option<&I::Output> {
    if V::LANES > 1 {
        Some(&values[index])
    } else {
        values.get(index)
    }
}

/// [`get`], mutable.
#[inline(always)]
pub(crate) fn get_mut<V: Vector, T, I: SliceIndex<[T]>>(
    values: &mut [T],
    index: I,
) -> Option<&mut I::Output> {
    if V::LANES > 1 {
        Some(&mut values[index])
    } else {
        values.get_mut(index)
    }
}

/// Splits the first `length` numbers off `from`, which is at least as long.
#[inline(always)]
pub(crate) fn split_front<'a, T>(from: &mut &'a mut [T], length: usize) -> &'a mut [T] {
    from.split_off_mut(..length).unwrap_or_default()
}

/// Copies between slices of one length.
///
/// If the compiler knows that the lengths are equal, this is only the copy, like `copy_from_slice`. Otherwise
/// `copy_from_slice` would link a panic.
#[inline(always)]
pub(crate) fn copy<T: Copy>(from: &[T], to: &mut [T]) {
    if from.len() == to.len() {
        to.copy_from_slice(from);
    }
}

/// Transposes the first `V::LANES` vectors, of `N` at least: vector `k` gets lane `k` of every vector.
#[inline(always)]
pub(crate) fn transpose<V: Vector, const N: usize>(square: &mut [V; N]) {
    // Each round moves one more bit of the row's number into the lane's.
    for _ in 0..V::LANES.trailing_zeros() {
        let before = *square;
        for k in 0..V::LANES / 2 {
            (square[2 * k], square[2 * k + 1]) = before[k].interleave(before[k + V::LANES / 2]);
        }
    }
}
