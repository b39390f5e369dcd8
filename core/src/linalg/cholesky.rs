//! Cholesky factorisation `A = G·Gᴴ`, and the rows below it that the factor divides.

use super::FLOOR;
use super::panels::{Column, TILE, panel};
use crate::vector::{Scalar, Vector};

/// Factorises the matrix of `panels` panels `a` into `g`, and turns `rows`, which stand below `a`,
/// into `rows·G⁻ᴴ`: a row `b*` becomes `(G⁻¹b)*`.
///
/// Order: entry `(i, j)` is `A(i,j) − Σ_k G(i,k)·G(j,k)*`, one subtraction after another with `k`
/// ascending, then times `1/G(j,j)`; the pivot is `A(j,j) − Σ_k |G(j,k)|²` likewise, its root and
/// then its reciprocal taken. The rows below follow the same rule. The diagonal of `g` is `1/G(j,j)`.
///
/// Tile by tile: a tile of 4×4 entries stays in registers while `k` runs over all the panels'
/// columns before it, so that each product costs two operations and half a load.
///
/// Returns the lanes in which the matrix is positive definite: no pivot is below the rounding error
/// of the trace. From there on the others' pivots count as just that, but what follows is made of
/// rounding errors, which can grow beyond f32; their caller takes the eigensolver.
///
/// Cost: `n³/3` flops real, `4n³/3` complex, `n` roots and divisions; `n²` (`4n²`) for each row below.
#[inline(always)]
pub fn factorise<S: Scalar<V>, V: Vector, const ROWS: usize>(
    a: &[Column<S>],
    g: &mut [Column<S>],
    rows: &mut [[S; ROWS]],
    panels: usize,
) -> V::Mask {
    let zero = a[0][0].real().zero();
    let mut definite = zero.mask(
        #[inline(always)]
        |_| true,
    );
    for j in 0..panels {
        let (before, after) = g[..panel(panels)].split_at_mut(panel(j + 1));
        let (done, tile) = before[panel(j)..].split_at_mut(TILE * j);
        let mut sums = tile_of(&a[panel(j)..], j);
        subtract_products(&mut sums, done, done);
        for k in 0..TILE {
            let pivot = sums[k][k].real();
            definite = definite & zero.splat(FLOOR).less(pivot);
            let pivot = V::select(definite, pivot, zero.splat(FLOOR));
            let inverse = zero.splat(1.0) / pivot.sqrt();
            sums[k][k] = S::from_real(inverse);
            for r in k + 1..TILE {
                sums[k][r] = sums[k][r].scale(inverse);
            }
            for c in k + 1..TILE {
                for r in c..TILE {
                    sums[c][r] = sums[c][r] - sums[k][r].mul_conj(sums[k][c]);
                }
            }
        }
        tile.copy_from_slice(&sums);
        let tile = &sums;
        for i in j + 1..panels {
            let row = &mut after[panel(i) - panel(j + 1)..];
            let (row, rest) = row.split_at_mut(TILE * j);
            let mut sums = tile_of(&a[panel(i)..], j);
            subtract_products(&mut sums, row, done);
            divide(&mut sums, tile);
            rest[..TILE].copy_from_slice(&sums);
        }
        let (row, rest) = rows.split_at_mut(TILE * j);
        let mut sums = tile_of(rest, 0);
        subtract_products(&mut sums, row, done);
        divide(&mut sums, tile);
        rest[..TILE].copy_from_slice(&sums);
    }
    definite
}

/// Tile `j` of a panel.
#[inline(always)]
fn tile_of<S: Copy, const ROWS: usize>(panel: &[[S; ROWS]], j: usize) -> [[S; ROWS]; TILE] {
    let columns = &panel[TILE * j..TILE * j + TILE];
    [columns[0], columns[1], columns[2], columns[3]]
}

/// `sums[c][r] −= Σ_k row[k][r]·column[k][c]*`, `k` ascending: as many columns at a time as leave
/// registers free for the factors.
#[inline(always)]
fn subtract_products<S: Scalar<V>, V: Vector, const ROWS: usize>(
    sums: &mut [[S; ROWS]; TILE],
    row: &[[S; ROWS]],
    column: &[Column<S>],
) {
    match V::REGISTERS / (2 * ROWS * S::PARTS) {
        4.. => subtract_columns::<S, V, ROWS, 4>(sums, 0, row, column),
        2..4 => {
            subtract_columns::<S, V, ROWS, 2>(sums, 0, row, column);
            subtract_columns::<S, V, ROWS, 2>(sums, 2, row, column);
        }
        _ => {
            for c in 0..TILE {
                subtract_columns::<S, V, ROWS, 1>(sums, c, row, column);
            }
        }
    }
}

#[inline(always)]
fn subtract_columns<S: Scalar<V>, V: Vector, const ROWS: usize, const C: usize>(
    sums: &mut [[S; ROWS]; TILE],
    first: usize,
    row: &[[S; ROWS]],
    column: &[Column<S>],
) {
    let mut kept = [sums[first]; C];
    kept.copy_from_slice(&sums[first..first + C]);
    for (row, column) in row.iter().zip(column) {
        for c in 0..C {
            let factor = column[first + c];
            for r in 0..ROWS {
                kept[c][r] = kept[c][r] - row[r].mul_conj(factor);
            }
        }
    }
    sums[first..first + C].copy_from_slice(&kept);
}

/// The rest of the sums over the diagonal tile's own columns, and the division by its diagonal.
#[inline(always)]
fn divide<S: Scalar<V>, V: Vector, const ROWS: usize>(
    sums: &mut [[S; ROWS]; TILE],
    tile: &[Column<S>; TILE],
) {
    for c in 0..TILE {
        for k in 0..c {
            for r in 0..ROWS {
                sums[c][r] = sums[c][r] - sums[k][r].mul_conj(tile[k][c]);
            }
        }
        for r in 0..ROWS {
            sums[c][r] = sums[c][r].scale(tile[c][c].real());
        }
    }
}
