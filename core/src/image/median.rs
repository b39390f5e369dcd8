//! The 3×3 median.

use super::check_finite;
use crate::Error;
use crate::error::check_length;
use crate::simd::{Vector, load};

/// The median of each pixel's 3×3 neighbourhood; `image` and `out` are row-major, `columns` wide.
///
/// `zero`: any vector of the instruction set to compute with; the pixels do not depend on it.
///
/// Beyond an edge the nearest pixel of the image stands in (the edge is repeated), so every
/// neighbourhood has nine values and a constant image stays as it is.
///
/// No memory of its own; 19 compare-and-exchange steps a pixel (Paeth, Graphics Gems, 1990),
/// none of which branches.
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
/// [`Error::Parameter`] for no columns, [`Error::Length`] where the image is not made of whole
/// rows or `out` has another length, [`Error::NonFinite`] with the flat index. `out` is then
/// untouched.
pub fn median<V: Vector>(
    zero: V,
    image: &[f32],
    columns: usize,
    out: &mut [f32],
) -> Result<(), Error> {
    if columns == 0 {
        return Err(Error::Parameter {
            name: "image columns",
            value: 0.0,
            expected: "at least 1",
        });
    }
    let rows = image.len() / columns;
    check_length("image", image.len(), rows * columns)?;
    check_length("median output", out.len(), image.len())?;
    check_finite("image", image)?;

    zero.vectorize(
        #[inline(always)]
        || rows_of(zero, image, columns, out),
    );
    Ok(())
}

/// Row by row, a pixel a lane.
#[inline(always)]
fn rows_of<V: Vector>(zero: V, image: &[f32], columns: usize, out: &mut [f32]) {
    let rows = image.len() / columns;
    for (row, out) in out.chunks_exact_mut(columns).enumerate() {
        let below = if row + 1 < rows { row + 1 } else { row };
        let three = [row.saturating_sub(1), row, below].map(
            #[inline(always)]
            |row| &image[row * columns..][..columns],
        );
        // Inside, whole vectors; the ends of the row and what is left, pixel by pixel.
        let mut column = 0;
        while column < columns {
            if column > 0 && column + V::LANES < columns {
                let pixels = neighbourhood(
                    three,
                    [column - 1, column, column + 1],
                    #[inline(always)]
                    |row, column| load(zero, &row[column..]),
                );
                out[column..column + V::LANES].copy_from_slice(median_of_nine(pixels).lanes());
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
                    |row, column| row[column],
                );
                out[column] = median_of_nine(pixels);
                column += 1;
            }
        }
    }
}

/// What `load` finds in three rows at three columns.
#[inline(always)]
fn neighbourhood<V>(
    rows: [&[f32]; 3],
    columns: [usize; 3],
    load: impl Fn(&[f32], usize) -> V,
) -> [V; 9] {
    core::array::from_fn(
        #[inline(always)]
        |k| load(rows[k / 3], columns[k % 3]),
    )
}

/// A selection network: only the middle one of the nine ends in order.
#[inline(always)]
fn median_of_nine<V: Vector>(mut p: [V; 9]) -> V {
    const EXCHANGES: [(usize, usize); 19] = [
        (1, 2),
        (4, 5),
        (7, 8),
        (0, 1),
        (3, 4),
        (6, 7),
        (1, 2),
        (4, 5),
        (7, 8),
        (0, 3),
        (5, 8),
        (4, 7),
        (3, 6),
        (1, 4),
        (2, 5),
        (4, 7),
        (4, 2),
        (6, 4),
        (4, 2),
    ];
    for (low, high) in EXCHANGES {
        let (a, b) = (p[low], p[high]);
        let swap = b.less(a);
        p[low] = V::select(swap, b, a);
        p[high] = V::select(swap, a, b);
    }
    p[4]
}
