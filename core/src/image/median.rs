//! The 3×3 median.

use super::check_finite;
use crate::Error;
use crate::error::check_length;
use crate::memory::STEP;
use crate::simd::{Vector, copy, vectorize};

/// Computes the median of each pixel's 3×3 neighbourhood.
///
/// `image` and `out` are row-major, `columns` wide. `zero`: any vector of the instruction set to compute with; the
/// pixels do not depend on it.
///
/// Edges repeat the nearest pixel of the image, so every neighbourhood has nine values and a constant image does
/// not change.
///
/// RAM: none. Cost: 19 compare-and-exchange steps per pixel (Paeth, Graphics Gems, 1990), without branches; 13 with one
/// lane, since a sorted column serves three pixels.
///
/// ```
/// let image = [1.0, 2.0, 3.0, 4.0, 99.0, 6.0, 7.0, 8.0, 9.0];
/// let mut out = [0.0; 9];
/// bonebeam::image::median(0.0f32, &image, 3, &mut out)?;
/// assert_eq!(out[4], 6.0);
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// # Errors
/// [`Error::Parameter`] for no columns, [`Error::Length`] if the image does not consist of whole rows or `out` has
/// another length, [`Error::NonFinite`] with the flat index. `out` is then unchanged.
pub fn median<V: Vector>(
    zero: V,
    image: &[f32],
    columns: usize,
    out: &mut [f32],
) -> Result<(), Error> {
    median_in_steps(zero, image, columns, out, &mut || {})
}

/// [`median`]; reports each step to `progress`.
pub(super) fn median_in_steps<V: Vector>(
    zero: V,
    image: &[f32],
    columns: usize,
    out: &mut [f32],
    progress: &mut dyn FnMut(),
) -> Result<(), Error> {
    if columns == 0 {
        return Err(Error::parameter("image columns", 0.0, "at least 1"));
    }
    let rows = image.len() / columns;
    check_length("image", image.len(), rows * columns)?;
    check_length("median output", out.len(), image.len())?;
    check_finite("image", image)?;

    let step = (STEP / columns).max(1);
    for (k, out) in out.chunks_mut((step * columns).max(1)).enumerate() {
        vectorize!(zero, rows_of(zero, image, k * step, columns, out));
        progress();
    }
    Ok(())
}

/// The rows from `first` on, row by row, a pixel a lane.
#[inline(always)]
fn rows_of<V: Vector>(zero: V, image: &[f32], first: usize, columns: usize, out: &mut [f32]) {
    let rows = image.len() / columns;
    for (row, out) in (first..).zip(out.chunks_exact_mut(columns)) {
        let below = if row + 1 < rows { row + 1 } else { row };
        let three = [row.saturating_sub(1), row, below].map(
            #[inline(always)]
            |row| {
                let row = image.get(row * columns..).unwrap_or_default();
                row.get(..columns).unwrap_or_default()
            },
        );
        if V::LANES == 1 {
            row_by_columns(three, out);
            continue;
        }
        // Inside the row, whole vectors; its ends and the rest, pixel by pixel.
        let mut column = 0;
        while column < columns {
            if column > 0 && column + V::LANES < columns {
                let pixels = neighbourhood(
                    three,
                    [column - 1, column, column + 1],
                    #[inline(always)]
                    |row, column| {
                        let mut values = zero;
                        let from = row.get(column..).and_then(|row| row.get(..V::LANES));
                        copy(from.unwrap_or_default(), values.lanes_mut());
                        values
                    },
                );
                if let Some(out) = out.get_mut(column..column + V::LANES) {
                    copy(median_of_nine(pixels).lanes(), out);
                }
                column += V::LANES;
            } else {
                let right = if column + 1 < columns {
                    column + 1
                } else {
                    column
                };
                let pixels = neighbourhood(
                    three,
                    [column.saturating_sub(1), column, right],
                    #[inline(always)]
                    |row, column| row.get(column).copied().unwrap_or(0.0),
                );
                if let Some(out) = out.get_mut(column) {
                    *out = median_of_nine(pixels);
                }
                column += 1;
            }
        }
    }
}

/// Results of `load` for three columns, each of three rows in order.
#[inline(always)]
fn neighbourhood<V: Vector>(
    [above, own, below]: [&[f32]; 3],
    [left, middle, right]: [usize; 3],
    load: impl Fn(&[f32], usize) -> V,
) -> [[V; 3]; 3] {
    [left, middle, right].map(
        #[inline(always)]
        |column| sorted([load(above, column), load(own, column), load(below, column)]),
    )
}

/// A row of one lane, whose columns are sorted once for all three pixels that use them.
#[inline(always)]
fn row_by_columns([above, own, below]: [&[f32]; 3], out: &mut [f32]) {
    let mut columns = above.iter().zip(own).zip(below);
    let mut next = || {
        let ((&above, &own), &below) = columns.next()?;
        Some(sorted([above, own, below]))
    };
    let Some(first) = next() else {
        return;
    };
    let (mut left, mut middle) = (first, first);
    for out in out {
        let right = next().unwrap_or(middle);
        *out = median_of_nine([left, middle, right]);
        (left, middle) = (middle, right);
    }
}

/// Three numbers in order.
#[inline(always)]
fn sorted<V: Vector>(mut p: [V; 3]) -> [V; 3] {
    exchange::<1, 2, V, 3>(&mut p);
    exchange::<0, 1, V, 3>(&mut p);
    exchange::<1, 2, V, 3>(&mut p);
    p
}

/// The middle one of three columns in order.
///
/// A selection network: only the middle one of the nine ends in order.
#[inline(always)]
fn median_of_nine<V: Vector>([[p0, p1, p2], [p3, p4, p5], [p6, p7, p8]]: [[V; 3]; 3]) -> V {
    let mut p = [p0, p1, p2, p3, p4, p5, p6, p7, p8];
    exchange::<0, 3, V, 9>(&mut p);
    exchange::<5, 8, V, 9>(&mut p);
    exchange::<4, 7, V, 9>(&mut p);
    exchange::<3, 6, V, 9>(&mut p);
    exchange::<1, 4, V, 9>(&mut p);
    exchange::<2, 5, V, 9>(&mut p);
    exchange::<4, 7, V, 9>(&mut p);
    exchange::<4, 2, V, 9>(&mut p);
    exchange::<6, 4, V, 9>(&mut p);
    exchange::<4, 2, V, 9>(&mut p);
    p[4]
}

/// Puts two numbers in order.
#[inline(always)]
fn exchange<const LOW: usize, const HIGH: usize, V: Vector, const N: usize>(p: &mut [V; N]) {
    let (a, b) = (p[LOW], p[HIGH]);
    let swap = b.less(a);
    p[LOW] = V::select(swap, b, a);
    p[HIGH] = V::select(swap, a, b);
}
