//! Lower bound of the gap below the largest eigenvalue, from a sum of squares.

use super::panels::{PanelColumn, TILE, columns};
use crate::simd::{Scalar, Vector};

/// `‖A − μ‖²` for `μ = mean`.
///
/// The diagonal is summed from zero, then twice the entries below it, column by column in each panel from zero.
#[inline(always)]
pub fn squared_deviations<S: Scalar<V>, V: Vector>(a: &[PanelColumn<S>], n: usize, mean: V) -> V {
    let zero = mean.zero();
    let (mut diagonal, mut rest) = (zero, [zero; TILE]);
    for i in 0..n.div_ceil(TILE) {
        let Some((before, tile)) = columns(a, i) else {
            break;
        };
        for column in before {
            for r in 0..TILE {
                rest[r] = rest[r] + column[r].norm_sqr();
            }
        }
        for r in 0..TILE {
            for column in &tile[..r] {
                rest[r] = rest[r] + column[r].norm_sqr();
            }
            if TILE * i + r < n {
                let deviation = tile[r][r].real() - mean;
                diagonal = diagonal + deviation * deviation;
            }
        }
    }
    let rest = (rest[0] + rest[1]) + (rest[2] + rest[3]);
    diagonal + (rest + rest)
}

/// Lower bound of the gap between an eigenvalue and all others.
///
/// `deviation` is the distance of the eigenvalue above the mean; `squares` is the sum of all squared deviations.
#[inline(always)]
pub fn gap_by_squares<V: Vector>(squares: V, deviation: V) -> V {
    let others = squares - deviation * deviation;
    let zero = squares.zero();
    deviation - V::select(zero.less(others), others, zero).sqrt()
}
