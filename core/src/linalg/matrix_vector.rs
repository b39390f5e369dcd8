//! Product of a Hermitian matrix in panels and a vector.

use super::panels::{PanelColumn, TILE, panel};
use crate::simd::{Scalar, Vector};

/// `y = (A − shift)·v`, each entry summed from `−shift·v` over ascending columns.
///
/// Each column of a panel is used twice while it is in registers: for its own rows and, mirrored, for the row of
/// its own index.
#[inline(always)]
pub fn times_vector<S: Scalar<V>, V: Vector>(
    a: &[PanelColumn<S>],
    shift: V,
    v: &[PanelColumn<S>],
    y: &mut [PanelColumn<S>],
) {
    if V::LANES > 1 {
        // Indices leave more registers to the results, which may be sixteen.
        for (i, own) in v.iter().enumerate() {
            let (before, diagonal) = a[panel(i)..panel(i + 1)].split_at(TILE * i);
            let (above, rest) = y.split_at_mut(i);
            rest[0] = panel_times_vector((before, diagonal), shift, (v, *own), above);
        }
        return;
    }
    // Without indices, so that no panic is called.
    let mut panels = a;
    for (i, own) in v.iter().enumerate() {
        let Some((before, rest)) = panels.split_at_checked(TILE * i) else {
            break;
        };
        let Some((diagonal, rest)) = rest.split_at_checked(TILE) else {
            break;
        };
        let Some((above, [slot, ..])) = y.split_at_mut_checked(i) else {
            break;
        };
        panels = rest;
        *slot = panel_times_vector((before, diagonal), shift, (v, *own), above);
    }
}

/// The product of a panel's rows and a vector.
///
/// The panel has the columns before its diagonal tile, and the tile. Its mirrored columns are added to the rows
/// above. `own`: the vector's entries at the panel's rows, copied, since a store would make the compiler read them
/// again.
#[inline(always)]
fn panel_times_vector<S: Scalar<V>, V: Vector>(
    (before, diagonal): (&[PanelColumn<S>], &[PanelColumn<S>]),
    shift: V,
    (v, own): (&[PanelColumn<S>], PanelColumn<S>),
    above: &mut [PanelColumn<S>],
) -> PanelColumn<S> {
    let mut sums = own.map(
        #[inline(always)]
        |v| v.scale(-shift),
    );
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
    sums
}
