//! The product of a Hermitian matrix in panels and a vector.

use super::panels::{PanelColumn, TILE, panel};
use crate::simd::{Scalar, Vector};

/// `y = (A − shift)·v`, each entry summed from `−shift·v` over ascending columns.
///
/// Each column of a panel serves twice while it is in registers: for its own rows and, mirrored,
/// for the row of its own index.
#[inline(always)]
pub fn times_vector<S: Scalar<V>, V: Vector>(
    a: &[PanelColumn<S>],
    shift: V,
    v: &[PanelColumn<S>],
    y: &mut [PanelColumn<S>],
) {
    // Copied: a store to y would make the compiler read it again.
    for (i, &own) in v.iter().enumerate() {
        let (before, diagonal) = a[panel(i)..panel(i + 1)].split_at(TILE * i);
        let mut sums = own.map(
            #[inline(always)]
            |v| v.scale(-shift),
        );
        let (above, rest) = y.split_at_mut(i);
        let entries = v.as_flattened().iter().zip(above.as_flattened_mut());
        for (column, (&v, y)) in before.iter().zip(entries) {
            let mut mirrored = *y;
            for r in 0..TILE {
                sums[r] = sums[r] + column[r].mul(v);
                mirrored = mirrored + own[r].mul_conj(column[r]);
            }
            *y = mirrored;
        }
        for r in 0..TILE {
            for c in 0..r {
                sums[r] = sums[r] + diagonal[c][r].mul(own[c]);
                sums[c] = sums[c] + own[r].mul_conj(diagonal[c][r]);
            }
            sums[r] = sums[r] + diagonal[r][r].mul(own[r]);
        }
        rest[0] = sums;
    }
}
