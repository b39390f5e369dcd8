//! Cholesky factorisation `A = G·Gᴴ`, and triangular solves with its factor.

use super::FLOOR;
use super::panels::{PanelColumn, TILE, panel};
use super::size::Size;
use crate::simd::{Scalar, Vector};

/// Factorises a matrix into `g`, and solves for the rows below it.
///
/// The matrix is `a`, of `n` rows in whole panels. `rows` become `rows·G⁻ᴴ`: a row `b*` becomes `(G⁻¹b)*`.
///
/// Order: entry `(i, j)` is `A(i,j) − Σ_k G(i,k)·G(j,k)*`, one subtraction after another with `k`
/// ascending, then times `1/G(j,j)`; the pivot is `A(j,j) − Σ_k |G(j,k)|²` likewise, its root and
/// then its reciprocal taken. The rows below follow the same rule. The diagonal of `g` is `1/G(j,j)`.
///
/// The order of panels is from the top, and tile by tile in each. A tile of 4×4 entries stays in registers while
/// `k` runs over all columns before it, so that each product costs two operations and half a load. The rows below
/// follow each panel while it is in the cache.
///
/// `a`, `g` and `rows` have as many tiles as the panels need; further tiles stay unchanged.
///
/// Returns the lanes with a positive definite matrix: no pivot is below the rounding error of the trace. Other
/// lanes continue with that error as their pivot. Their results are rounding errors that can exceed f32; the caller
/// uses the eigensolver for them.
///
/// Cost: `n³/3` flops real, `4n³/3` complex, `n` roots and divisions; `n²` (`4n²`) for each row below.
#[inline(always)]
pub fn factorise<S: Scalar<V>, V: Vector, const ROWS: usize>(
    zero: V,
    a: &[PanelColumn<S>],
    g: &mut [PanelColumn<S>],
    rows: &mut [[S; ROWS]],
    n: impl Size,
) -> V::Mask {
    let mut definite = zero.mask(
        #[inline(always)]
        |_| true,
    );
    let panels = n.get().div_ceil(TILE);
    let (Some(a), Some(g), Some(rows)) = (
        n.front(a.as_chunks::<TILE>().0, first_tile(panels)),
        n.front_mut(g.as_chunks_mut::<TILE>().0, first_tile(panels)),
        n.front_mut(rows.as_chunks_mut::<TILE>().0, panels),
    ) else {
        return definite;
    };
    n.each(
        panels,
        #[inline(always)]
        |i| {
            let (done, rest) = g.split_at_mut_checked(first_tile(i))?;
            let of_panel = first_tile(i)..first_tile(i) + i + 1;
            let (diagonal, own) = rest.get_mut(..=i)?.split_last_mut()?;
            let (last, a) = a.get(of_panel)?.split_last()?;
            let mut done = &*done;
            let size = n.rows_of(i);
            for (j, &entry) in a.iter().enumerate() {
                let (panel, rest) = done.split_at_checked(j + 1)?;
                done = rest;
                let (tile, panel) = panel.split_last()?;
                let (slot, own) = own.get_mut(..=j)?.split_last_mut()?;
                let mut sums = entry;
                subtract_products(&mut sums, (TILE, size, false), own, panel);
                divide(&mut sums, (TILE, size), tile);
                *slot = sums;
            }
            let mut sums = *last;
            subtract_products(&mut sums, (size, size, true), own, own);
            for k in 0..size {
                let pivot = sums[k][k].real();
                definite = definite & zero.splat(FLOOR).less(pivot);
                let pivot = V::select(definite, pivot, zero.splat(FLOOR));
                let inverse = zero.splat(1.0) / pivot.sqrt();
                sums[k][k] = S::from_real(inverse);
                for r in k + 1..size {
                    sums[k][r] = sums[k][r].scale(inverse);
                }
                for c in k + 1..size {
                    for r in c..size {
                        sums[c][r] = sums[c][r] - sums[k][r].mul_conj(sums[k][c]);
                    }
                }
            }
            *diagonal = sums;
            let (before, [slot, ..]) = rows.split_at_mut_checked(i)? else {
                return None;
            };
            let mut row = *slot;
            subtract_products(&mut row, (size, ROWS, false), before, own);
            divide(&mut row, (size, ROWS), &sums);
            *slot = row;
            Some(())
        },
    );
    definite
}

/// Turns groups of rows below a factorised matrix into `rows·G⁻ᴴ`.
///
/// Each row has `TILE·panels` columns. The operations are those of [`factorise`]; the factor is read once for all
/// groups.
///
/// Cost: `n²` flops (`4n²`) for each row.
#[inline(always)]
pub fn divide_forward<S: Scalar<V>, V: Vector, const ROWS: usize>(
    g: &[PanelColumn<S>],
    rows: &mut [[S; ROWS]],
    panels: usize,
) {
    let (g, _) = g.as_chunks::<TILE>();
    let (rows, _) = rows.as_chunks_mut::<TILE>();
    for i in 0..panels {
        let own = g.get(first_tile(i)..first_tile(i) + i + 1);
        let Some((diagonal, own)) = own.and_then(<[_]>::split_last) else {
            break;
        };
        for rows in rows.chunks_exact_mut(panels.max(1)) {
            let Some((before, [slot, ..])) = rows.split_at_mut_checked(i) else {
                break;
            };
            let mut row = *slot;
            subtract_products(&mut row, (TILE, ROWS, false), before, own);
            divide(&mut row, (TILE, ROWS), diagonal);
            *slot = row;
        }
    }
}

/// Turns groups of rows below a factorised matrix into `rows·G⁻¹`.
///
/// Each row has `TILE·panels` columns. A row `b*` becomes `(G⁻ᴴb)*`, so that both solves together give `(A⁻¹b)*`.
///
/// Order: column `c` is `b*(c) − Σ_k u*(k)·G(k,c)`, one subtraction after another with `k` descending from the last
/// column to `c + 1`, then times `1/G(c,c)`.
///
/// Cost: that of [`divide_forward`].
#[inline(always)]
pub fn divide_backward<S: Scalar<V>, V: Vector, const ROWS: usize>(
    g: &[PanelColumn<S>],
    rows: &mut [[S; ROWS]],
    n: impl Size,
) {
    let panels = n.get().div_ceil(TILE);
    let (rows, _) = rows.as_chunks_mut::<TILE>();
    let Some(g) = n.front(g.as_chunks::<TILE>().0, first_tile(panels)) else {
        return;
    };
    n.each(
        panels,
        #[inline(always)]
        |above| {
            let i = panels - 1 - above;
            let tile = |panel: usize| g.get(first_tile(panel) + i);
            let diagonal = tile(i)?;
            for rows in rows.chunks_exact_mut(panels.max(1)) {
                let ([.., slot], behind) = rows.split_at_mut_checked(i + 1)? else {
                    return None;
                };
                let mut row = *slot;
                let below = |offset: usize| {
                    let index = i + 1 + offset;
                    Some((tile(index)?, n.rows_of(index)))
                };
                let size = n.rows_of(i);
                match V::REGISTERS / (2 * ROWS * S::PARTS) {
                    4.. => subtract_below::<S, V, ROWS, 4>(&mut row, 0, behind, below),
                    2..4 => {
                        subtract_below::<S, V, ROWS, 2>(&mut row, 0, behind, below);
                        subtract_below::<S, V, ROWS, 2>(&mut row, 2, behind, below);
                    }
                    _ => {
                        for c in 0..TILE {
                            subtract_below::<S, V, ROWS, 1>(&mut row, c, behind, below);
                        }
                    }
                }
                for c in (0..size).rev() {
                    for k in (c + 1..size).rev() {
                        for r in 0..ROWS {
                            row[c][r] = row[c][r] - row[k][r].mul(diagonal[c][k]);
                        }
                    }
                    for r in 0..ROWS {
                        row[c][r] = row[c][r].scale(diagonal[c][c].real());
                    }
                }
                *slot = row;
            }
            Some(())
        },
    );
}

/// `sums[c][r] −= Σ_k solved[k][r]·G(k,c)`, `k` descending, for `C` columns from `first` on; `below(offset)` is the tile of
/// the factor whose rows are those of `solved[offset]`, and their number.
#[inline(always)]
fn subtract_below<'g, S: Scalar<V> + 'g, V: Vector, const ROWS: usize, const C: usize>(
    sums: &mut Tile<S, ROWS>,
    first: usize,
    solved: &[Tile<S, ROWS>],
    below: impl Fn(usize) -> Option<(&'g Tile<S>, usize)>,
) {
    let mut kept = [sums[first]; C];
    kept.copy_from_slice(&sums[first..first + C]);
    for (offset, solved) in solved.iter().enumerate().rev() {
        let Some((tile, size)) = below(offset) else {
            break;
        };
        for k in (0..size).rev() {
            for c in 0..C {
                let factor = tile[first + c][k];
                for r in 0..ROWS {
                    kept[c][r] = kept[c][r] - solved[k][r].mul(factor);
                }
            }
        }
    }
    sums[first..first + C].copy_from_slice(&kept);
}

/// A tile of `ROWS` rows, column by column.
type Tile<S, const ROWS: usize = TILE> = [[S; ROWS]; TILE];

/// The first tile of panel `index`, in tiles.
#[inline(always)]
const fn first_tile(index: usize) -> usize {
    panel(index) / TILE
}

/// `sums[c][r] −= Σ_k row[k][r]·column[k][c]*`, `k` ascending, for the first columns and rows.
///
/// With one lane, only the lower triangle of a diagonal tile, whose other half nobody reads.
///
/// The number of columns at a time leaves registers free for the factors.
#[inline(always)]
fn subtract_products<S: Scalar<V>, V: Vector, const ROWS: usize>(
    sums: &mut Tile<S, ROWS>,
    size: (usize, usize, bool),
    row: &[Tile<S, ROWS>],
    column: &[Tile<S>],
) {
    match V::REGISTERS / (2 * ROWS * S::PARTS).max(1) {
        4.. => subtract_columns::<S, V, ROWS, 4>(sums, (0, size), row, column),
        2..4 => {
            subtract_columns::<S, V, ROWS, 2>(sums, (0, size), row, column);
            subtract_columns::<S, V, ROWS, 2>(sums, (2, size), row, column);
        }
        _ => {
            for c in 0..TILE {
                subtract_columns::<S, V, ROWS, 1>(sums, (c, size), row, column);
            }
        }
    }
}

#[inline(always)]
fn subtract_columns<S: Scalar<V>, V: Vector, const ROWS: usize, const C: usize>(
    sums: &mut Tile<S, ROWS>,
    (first, (columns, rows, diagonal)): (usize, (usize, usize, bool)),
    row: &[Tile<S, ROWS>],
    column: &[Tile<S>],
) {
    let mut kept = [sums[first]; C];
    kept.copy_from_slice(&sums[first..first + C]);
    for (row, column) in row.iter().zip(column) {
        for k in 0..TILE {
            for c in 0..C {
                if first + c >= columns {
                    break;
                }
                let factor = column[k][first + c];
                let above = if diagonal && V::LANES == 1 {
                    first + c
                } else {
                    0
                };
                for r in above..rows {
                    kept[c][r] = kept[c][r] - row[k][r].mul_conj(factor);
                }
            }
        }
    }
    sums[first..first + C].copy_from_slice(&kept);
}

/// The rest of the sums over the diagonal tile's own columns, and the division by its diagonal.
#[inline(always)]
fn divide<S: Scalar<V>, V: Vector, const ROWS: usize>(
    sums: &mut Tile<S, ROWS>,
    (columns, rows): (usize, usize),
    tile: &Tile<S>,
) {
    for c in 0..columns {
        for k in 0..c {
            for r in 0..rows {
                sums[c][r] = sums[c][r] - sums[k][r].mul_conj(tile[k][c]);
            }
        }
        for r in 0..rows {
            sums[c][r] = sums[c][r].scale(tile[c][c].real());
        }
    }
}
