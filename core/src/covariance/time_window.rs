//! The sum over a window of neighbouring samples (the outer sum of Eq. 2), by two stacks.
//!
//! A running add-and-subtract over time would leave an echo's rounding error in the shadow behind
//! it. The two-stack sum only adds: the last `2K+1` samples' sets of lag sums stand in blocks of
//! `2K+1`; the older block is kept as suffix sums, the newer one as one growing prefix, and a window
//! is one suffix plus the prefix. Three additions a number and sample, whatever `K` is.

use crate::vector::{ComplexVector, Vector};

/// How many sets of lag sums a window of `2·temporal + 1` samples takes.
pub const fn sets(temporal: usize) -> usize {
    if temporal == 0 { 1 } else { 2 * temporal + 2 }
}

/// Where sample `push` of a run (counted from 0) is to be written in `memory`, before [`window`]
/// is asked for. `size` numbers make a set.
///
/// At the beginning of a block the block before becomes suffix sums, newest first.
#[inline(always)]
pub fn slot<V: Vector>(
    memory: &mut [ComplexVector<V>],
    size: usize,
    temporal: usize,
    push: usize,
) -> &mut [ComplexVector<V>] {
    let length = 2 * temporal + 1;
    let here = push % length;
    if here == 0 && push > 0 {
        // The whole older block is never a window's suffix.
        for slot in (2..length).rev() {
            let (older, newer) = memory.split_at_mut(slot * size);
            let older = &mut older[(slot - 1) * size..];
            for (older, &newer) in older.iter_mut().zip(&newer[..size]) {
                *older = *older + newer;
            }
        }
    }
    &mut memory[here * size..(here + 1) * size]
}

/// Adds the slot of sample `push` to the prefix and returns the suffix and the prefix whose sum is
/// the window that ends there. There is no suffix where a block ends.
#[inline(always)]
pub fn window<V: Vector>(
    memory: &mut [ComplexVector<V>],
    size: usize,
    temporal: usize,
    push: usize,
) -> (Option<&[ComplexVector<V>]>, &[ComplexVector<V>]) {
    let length = 2 * temporal + 1;
    let here = push % length;
    if temporal == 0 {
        return (None, &memory[..size]);
    }
    let (slots, prefix) = memory.split_at_mut(length * size);
    let prefix = &mut prefix[..size];
    let newest = &slots[here * size..(here + 1) * size];
    if here == 0 {
        prefix.copy_from_slice(newest);
    } else {
        for (prefix, &newest) in prefix.iter_mut().zip(newest) {
            *prefix = *prefix + newest;
        }
    }
    let suffix = (here + 1 < length).then(|| &slots[(here + 1) * size..(here + 2) * size]);
    (suffix, prefix)
}
