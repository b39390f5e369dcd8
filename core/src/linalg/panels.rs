//! Storage of a Hermitian matrix: its lower triangle in panels of four rows.
//!
//! Panel `I` holds rows `4I..4I+4` column by column, from column 0 to the last of the diagonal tile. A product of
//! two panels then reads both from front to back. Diagonal tiles are full, and padding rows of the last panel are
//! those of the identity.

use crate::simd::{Scalar, Vector};

/// Rows of a panel, and columns of a tile.
pub const TILE: usize = 4;

/// A column of a panel.
pub type PanelColumn<S> = [S; TILE];

/// A square tile of a panel.
pub type Tile<S> = [PanelColumn<S>; TILE];

/// First column of panel `index`.
///
/// For the number of panels, the number of all columns.
#[inline(always)]
pub const fn panel(index: usize) -> usize {
    // Σ 4·(i + 1) for i < index.
    2 * index * (index + 1)
}

/// Panel `index`: the columns before its diagonal tile, and that tile.
#[inline(always)]
pub fn columns<S>(a: &[PanelColumn<S>], index: usize) -> Option<(&[PanelColumn<S>], &Tile<S>)> {
    a.get(panel(index)..panel(index + 1))?.split_last_chunk()
}

/// Panel `index` for writing, as [`columns`].
#[inline(always)]
pub fn columns_mut<S>(
    a: &mut [PanelColumn<S>],
    index: usize,
) -> Option<(&mut [PanelColumn<S>], &mut Tile<S>)> {
    let columns = a.get_mut(panel(index)..panel(index + 1))?;
    columns.split_last_chunk_mut()
}

/// Trace, summed in ascending order from zero.
#[inline(always)]
pub fn trace<S: Scalar<V>, V: Vector>(zero: V, a: &[PanelColumn<S>], n: usize) -> V {
    let mut sum = zero;
    for i in 0..n.div_ceil(TILE) {
        let Some((_, tile)) = columns(a, i) else {
            break;
        };
        for r in 0..TILE {
            if TILE * i + r < n {
                sum = sum + tile[r][r].real();
            }
        }
    }
    sum
}
