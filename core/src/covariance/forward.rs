//! The covariance of Eq. 2 without further averaging.

use super::Covariance;
use super::averaging::{Basis, RIGHT_SIDES};
use super::diagonal_loading::DiagonalLoading;
use crate::linalg::panels::{PanelColumn, TILE, panel};
use crate::linalg::size::Size;
use crate::simd::{ComplexVector, Scalar, Vector, copy, split_front};

/// `R` of Eq. 2, complex Hermitian.
///
/// Kept: every entry on and below the diagonal, column by column, with the lags ascending.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Forward;

impl Forward {
    /// Number of lag sums kept of a sample.
    pub(super) const fn lag_count(subaperture: usize) -> usize {
        subaperture.saturating_mul(subaperture.saturating_add(1)) / 2
    }

    #[inline(always)]
    fn index(subaperture: usize, lag: usize, column: usize) -> usize {
        // Σ (L − t) for t < column.
        column * (2 * subaperture + 1 - column) / 2 + lag
    }
}

impl<V: Vector> Basis<V> for Forward {
    type Scalar = ComplexVector<V>;

    const COVARIANCE: Covariance = Covariance::Forward;

    #[inline(always)]
    fn scalars<'a>(
        _real: &mut &'a mut [V],
        complex: &mut &'a mut [ComplexVector<V>],
        length: usize,
    ) -> &'a mut [Self::Scalar] {
        split_front(complex, length)
    }

    #[inline(always)]
    fn keep<const LAGS: usize>(
        lags: &mut [ComplexVector<V>],
        subaperture: usize,
        lag: usize,
        rows: &[[ComplexVector<V>; LAGS]],
    ) {
        let mut lags = lags.get_mut(lag..).unwrap_or_default();
        for (column, row) in rows.iter().enumerate() {
            let columns = rows.len() - column;
            for (kept, &r) in lags.iter_mut().zip(row).take(columns) {
                *kept = r;
            }
            lags = lags.get_mut(subaperture - column..).unwrap_or_default();
        }
    }

    #[inline(always)]
    fn trace(
        lag: impl Fn(usize) -> Option<ComplexVector<V>> + Copy,
        subaperture: usize,
    ) -> Option<V> {
        let mut trace = lag(0)?.re.zero();
        for column in 0..subaperture {
            trace = trace + lag(Self::index(subaperture, 0, column))?.re;
        }
        Some(trace)
    }

    #[inline(always)]
    fn matrix(
        lag: impl Fn(usize) -> Option<ComplexVector<V>> + Copy,
        subaperture: impl Size,
        diagonal_loading: &DiagonalLoading<V>,
        matrix: &mut [PanelColumn<ComplexVector<V>>],
    ) -> Option<()> {
        let zero = ComplexVector::from_real(diagonal_loading.factor.zero());
        let subaperture = subaperture.get();
        for block in 0..subaperture.div_ceil(TILE) {
            let columns = panel(block)..panel(block + 1);
            let columns = matrix.get_mut(columns)?;
            for (k, column) in columns.iter_mut().enumerate() {
                for (r, entry) in column.iter_mut().enumerate() {
                    let i = TILE * block + r;
                    *entry = if i >= subaperture || k >= subaperture {
                        zero
                    } else if i >= k {
                        lag(Self::index(subaperture, i - k, k))?.scale(diagonal_loading.factor)
                    } else {
                        lag(Self::index(subaperture, k - i, i))?
                            .scale(diagonal_loading.factor)
                            .conj()
                    };
                    if i == k {
                        // The rows that fill up the last tile are those of the identity.
                        let diagonal = if i < subaperture {
                            entry.re + diagonal_loading.added
                        } else {
                            entry.re.splat(1.0)
                        };
                        *entry = ComplexVector::from_real(diagonal);
                    }
                }
            }
        }
        Some(())
    }

    #[inline(always)]
    fn data(s: &[ComplexVector<V>], data: &mut [ComplexVector<V>]) {
        copy(s, data);
    }

    #[inline(always)]
    fn steering(_: usize, _: usize) -> f32 {
        1.0
    }

    #[inline(always)]
    fn steered(
        powers: &[ComplexVector<V>],
        sums: &[ComplexVector<V>],
        steering: &mut [ComplexVector<V>],
        data: &mut [ComplexVector<V>],
    ) {
        let (Some((entries, beyond)), Some(last)) =
            (steering.split_at_mut_checked(sums.len()), powers.last())
        else {
            return;
        };
        beyond.fill(last.zero());
        let middle = sums.len() / 2;
        let (left, right) = entries.split_at_mut(middle);
        let (Some((left_data, right_data)), (left_sums, right_sums)) =
            (data.split_at_mut_checked(middle), sums.split_at(middle))
        else {
            return;
        };
        let right = right.iter_mut().zip(right_data).zip(right_sums);
        for (((a, data), &s), &power) in right.zip(powers) {
            *a = power;
            *data = power.mul(s);
        }
        let left = left.iter_mut().zip(left_data).zip(left_sums);
        for (((a, data), &s), power) in left.zip(powers.iter().rev()) {
            *a = power.conj();
            *data = a.mul(s);
        }
    }

    #[inline(always)]
    fn right_sides(data: &[ComplexVector<V>], rows: &mut [[ComplexVector<V>; RIGHT_SIDES]]) {
        for (row, &s) in rows.iter_mut().zip(data) {
            let zero = s.zero();
            *row = [ComplexVector::from_real(s.re.splat(1.0)), s.conj(), zero];
        }
    }

    #[inline(always)]
    fn whitened(rows: &[ComplexVector<V>; RIGHT_SIDES]) -> (V, ComplexVector<V>) {
        // The rows hold y* and t*.
        let [y, t, ..] = *rows;
        (y.norm_sqr(), y.mul_conj(t))
    }

    #[inline(always)]
    fn gain(subapertures: usize) -> f32 {
        subapertures as f32
    }

    #[inline(always)]
    fn weights(_: &mut [ComplexVector<V>], _: &mut [ComplexVector<V>]) {}
}
