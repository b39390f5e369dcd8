//! Sum over a window of neighbouring samples (outer sum of Eq. 2), by two stacks.
//!
//! A running add-and-subtract over time would leave an echo's rounding error in the shadow behind it. The two-stack
//! sum only adds. The lag sums of the last `2K+1` samples are kept in blocks of `2K+1`: the older block as suffix
//! sums, the newer one as one growing prefix. A window is one suffix plus the prefix. Cost: three additions for
//! each number and sample, for every `K`.

use crate::simd::{ComplexVector, Vector, copy, vectorize};

/// Numbers whose suffix sums are formed together, half the widest registers.
const CHUNK: usize = 8;

/// Number of sets of lag sums in a window of `2K+1` samples; saturates.
pub const fn sets(temporal_half_window: usize) -> usize {
    match temporal_half_window {
        0 => 1,
        k => k.saturating_mul(2).saturating_add(2),
    }
}

/// Returns the slot of `memory` for sample `push` of a segment.
///
/// `push` counts from 0, and a set has `size` numbers. Write the slot before calling [`window`]. At the beginning
/// of a block, the block before becomes suffix sums, newest first.
#[inline(always)]
pub fn slot<V: Vector>(
    memory: &mut [ComplexVector<V>],
    size: usize,
    temporal_half_window: usize,
    push: usize,
) -> &mut [ComplexVector<V>] {
    let length = 2 * temporal_half_window + 1;
    let here = push % length;
    if here == 0 && push > 0 && temporal_half_window > 0 {
        suffixes(memory, size, length);
    }
    let slot = here * size..(here + 1) * size;
    memory.get_mut(slot).unwrap_or_default()
}

/// Converts the block's slots to suffix sums, except the first.
///
/// The whole older block is never a window's suffix.
///
/// A chunk of all slots at a time: its sums then stay in registers, and nothing that was just written
/// to a slot is read again (4 % of MV and of rank 1 with 21 samples at 128/64).
#[inline(never)]
fn suffixes<V: Vector>(memory: &mut [ComplexVector<V>], size: usize, length: usize) {
    let Some(first) = memory.first() else {
        return;
    };
    vectorize!(first.re, {
        let whole = size - size % CHUNK;
        for first in (0..whole).step_by(CHUNK) {
            chunk::<V, CHUNK>(memory, size, length, first);
        }
        for first in whole..size {
            chunk::<V, 1>(memory, size, length, first);
        }
    });
}

/// The numbers `first..first + N` of the suffix sums.
#[inline(always)]
fn chunk<V: Vector, const N: usize>(
    memory: &mut [ComplexVector<V>],
    size: usize,
    length: usize,
    first: usize,
) {
    let numbers = |slot: usize| slot * size + first..slot * size + first + N;
    let newest = memory.get(numbers(length - 1));
    let Some(&(mut sums)) = newest.and_then(<[_]>::first_chunk::<N>) else {
        return;
    };
    for slot in (1..length - 1).rev() {
        if let Some(older) = memory.get_mut(numbers(slot)) {
            for (sum, older) in sums.iter_mut().zip(older) {
                *sum = *older + *sum;
                *older = *sum;
            }
        }
    }
}

/// Adds the slot of sample `push` to the prefix, and returns suffix and prefix.
///
/// Their sum is the window that ends at `push`. At the end of a block there is no suffix.
#[inline(always)]
pub fn window<V: Vector>(
    memory: &mut [ComplexVector<V>],
    size: usize,
    temporal_half_window: usize,
    push: usize,
) -> (Option<&[ComplexVector<V>]>, &[ComplexVector<V>]) {
    let length = 2 * temporal_half_window + 1;
    let here = push % length;
    if temporal_half_window == 0 {
        return (None, memory.get(..size).unwrap_or_default());
    }
    let (slots, prefix) = memory
        .split_at_mut_checked(length * size)
        .unwrap_or_default();
    let prefix = prefix.get_mut(..size).unwrap_or_default();
    let newest = here * size..(here + 1) * size;
    let newest = slots.get(newest).unwrap_or_default();
    if here == 0 {
        copy(newest, prefix);
    } else {
        for (prefix, &newest) in prefix.iter_mut().zip(newest) {
            *prefix = *prefix + newest;
        }
    }
    let suffix = if here + 1 < length {
        slots.get((here + 1) * size..(here + 2) * size)
    } else {
        None
    };
    (suffix, prefix)
}
