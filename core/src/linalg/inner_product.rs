//! Inner product of two vectors in tiles.

use super::panels::{PanelColumn, TILE};
use crate::simd::{Scalar, Vector};

/// `uᴴp` in four partial sums.
///
/// Each adds every fourth entry from zero; the total is `(0 + 1) + (2 + 3)`.
#[inline(always)]
pub fn inner_product<S: Scalar<V>, V: Vector>(
    zero: V,
    u: &[PanelColumn<S>],
    p: &[PanelColumn<S>],
) -> S {
    let mut sums = [S::from_real(zero); TILE];
    for (u, p) in u.iter().zip(p) {
        for r in 0..TILE {
            sums[r] = sums[r] + p[r].mul_conj(u[r]);
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}
