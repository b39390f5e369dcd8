//! The 3×3 median.

use super::check_finite;
use crate::Error;
use crate::error::check_length;

/// The median of each pixel's 3×3 neighbourhood; `image` and `out` are row-major, `columns` wide.
///
/// Beyond an edge the nearest pixel of the image stands in (the edge is repeated), so every
/// neighbourhood has nine values and a constant image stays as it is.
///
/// No memory of its own; 19 compare-and-exchange steps a pixel (Paeth, Graphics Gems, 1990),
/// none of which branches.
///
/// # Errors
/// [`Error::Parameter`] for no columns, [`Error::Length`] where the image is not made of whole
/// rows or `out` has another length, [`Error::NonFinite`] with the flat index. `out` is then
/// untouched.
pub fn median(image: &[f32], columns: usize, out: &mut [f32]) -> Result<(), Error> {
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

    for row in 0..rows {
        let above = row.saturating_sub(1) * columns;
        let here = row * columns;
        let below = if row + 1 < rows { here + columns } else { here };
        for column in 0..columns {
            let left = column.saturating_sub(1);
            let right = if column + 1 < columns {
                column + 1
            } else {
                column
            };
            out[here + column] = median_of_nine([
                image[above + left],
                image[above + column],
                image[above + right],
                image[here + left],
                image[here + column],
                image[here + right],
                image[below + left],
                image[below + column],
                image[below + right],
            ]);
        }
    }
    Ok(())
}

/// A selection network: only the middle one of the nine ends in order.
fn median_of_nine(mut p: [f32; 9]) -> f32 {
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
        p[low] = if b < a { b } else { a };
        p[high] = if b < a { a } else { b };
    }
    p[4]
}
