//! FIR filters along rows, which hold a sample of each lane.

use crate::vector::{Vector, load};

/// How the taps in front of the middle compare with those behind it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Symmetry {
    /// They are the same.
    Even,
    /// They have the other sign.
    Odd,
}

/// Outputs whose sums are formed together, so that none waits for its last addition.
pub(super) const GROUP: usize = 8;

/// Adds to the sums of outputs that lie `APART` rows apart, of which the first has `middle` as its
/// middle row: `tap · (earlier ± later)`, of the rows k in front of the middle and behind it, for
/// each (k, tap) in turn.
#[inline(always)]
pub(super) fn add_pairs<V: Vector, const APART: usize>(
    sums: &mut [V; GROUP],
    rows: &[f32],
    middle: usize,
    symmetry: Symmetry,
    taps: impl Iterator<Item = (usize, f32)>,
) {
    let zero = sums[0].zero();
    let apart = APART * V::LANES;
    for (k, tap) in taps {
        let earlier = from_row::<V, APART>(rows, middle - k).chunks(apart);
        let later = from_row::<V, APART>(rows, middle + k).chunks(apart);
        for ((sum, earlier), later) in sums.iter_mut().zip(earlier).zip(later) {
            let (earlier, later) = (load(zero, earlier), load(zero, later));
            let pair = match symmetry {
                Symmetry::Even => earlier + later,
                Symmetry::Odd => earlier - later,
            };
            *sum = *sum + zero.splat(tap) * pair;
        }
    }
}

/// The rows from `row` to that of a group's last output.
#[inline(always)]
pub(super) fn from_row<V: Vector, const APART: usize>(rows: &[f32], row: usize) -> &[f32] {
    &rows[row * V::LANES..][..((GROUP - 1) * APART + 1) * V::LANES]
}
