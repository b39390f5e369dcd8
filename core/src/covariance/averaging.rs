//! The two covariance estimates: their kept sums, and the basis of their solver.

use super::Covariance;
use super::diagonal_loading::DiagonalLoading;
use crate::linalg::panels::PanelColumn;
use crate::linalg::size::Size;
use crate::simd::{ComplexVector, Scalar, Vector};

/// Rows that stand below the matrix for MV.
pub(crate) const RIGHT_SIDES: usize = 3;

/// The covariance in use, [`Forward`](super::Forward) or [`ForwardBackward`](super::ForwardBackward).
///
/// `V` holds the lanes. `A::COVARIANCE` is the estimate as a [`Covariance`] value. `A::Scalar` is the number type of
/// its matrix: a [`ComplexVector`] or a `V`.
pub trait Averaging<V: Vector>: Basis<V> {}

impl<A: Basis<V>, V: Vector> Averaging<V> for A {}

/// Kept sums of a sample's covariance, and their conversion to the solver's matrix.
///
/// Private to the crate, so that there are no other averagings.
pub trait Basis<V: Vector> {
    /// Number type of the solver's matrix.
    ///
    /// Complex for forward, real for forward-backward.
    type Scalar: Scalar<V>;

    /// The averaging as data.
    const COVARIANCE: Covariance;

    /// Splits `length` matrix entries off the memory of their number type.
    fn scalars<'a>(
        real: &mut &'a mut [V],
        complex: &mut &'a mut [ComplexVector<V>],
        length: usize,
    ) -> &'a mut [Self::Scalar];

    /// Stores the forward sums of the lags `lag..lag + LAGS` in `lags`.
    ///
    /// `rows[column][k]` is the sum of lag `lag + k`, the entry at `(lag + k + column, column)`. There is a row for
    /// each column of `lag`; entries beyond the last column of a longer lag are ignored.
    fn keep<const LAGS: usize>(
        lags: &mut [ComplexVector<V>],
        subaperture: usize,
        lag: usize,
        rows: &[[ComplexVector<V>; LAGS]],
    );

    /// Returns the trace of the matrix in use from the kept sums `lag(index)`.
    ///
    /// All sums must be present.
    fn trace(
        lag: impl Fn(usize) -> Option<ComplexVector<V>> + Copy,
        subaperture: usize,
    ) -> Option<V>;

    /// Writes the matrix in use, scaled and loaded, in panels.
    ///
    /// Its source is the kept sums `lag(index)`, all of which must be present.
    fn matrix(
        lag: impl Fn(usize) -> Option<ComplexVector<V>> + Copy,
        subaperture: impl Size,
        diagonal_loading: &DiagonalLoading<V>,
        matrix: &mut [PanelColumn<Self::Scalar>],
    ) -> Option<()>;

    /// Transforms the subaperture sum `s` to the solver's coordinates.
    fn data(s: &[ComplexVector<V>], data: &mut [ComplexVector<V>]);

    /// Entry `i` of the steering vector `a = 1` in the solver's coordinates.
    fn steering(i: usize, subaperture: usize) -> f32;

    /// Writes a centred steering vector and its product with the data.
    ///
    /// Both are in the solver's coordinates, with zeros beyond. The steering vector `a` (`a_{L−1−i} = a_i*`) comes
    /// from `powers`, its entries from the middle on. The product is `a_i·s_i`, with `sums` the `s_i`.
    fn steered(
        powers: &[ComplexVector<V>],
        sums: &[ComplexVector<V>],
        steering: &mut [Self::Scalar],
        data: &mut [ComplexVector<V>],
    );

    /// Writes steering vector and data as rows below the matrix.
    ///
    /// Both are in the solver's coordinates.
    fn right_sides(data: &[ComplexVector<V>], rows: &mut [[Self::Scalar; RIGHT_SIDES]]);

    /// Returns `|y|²` and `y*·t` of one factorised column.
    ///
    /// `y = G⁻¹a` and `t = G⁻¹s`, from the rows below the matrix.
    fn whitened(rows: &[Self::Scalar; RIGHT_SIDES]) -> (V, ComplexVector<V>);

    /// Divisor of `wᴴs` that gives `z` of Eq. 4, for `P` subapertures.
    fn gain(subapertures: usize) -> f32;

    /// Transforms weights from the solver's coordinates to the subaperture's elements.
    ///
    /// Weights of Eq. 1 or 7. `scratch` has the same length.
    fn weights(v: &mut [ComplexVector<V>], scratch: &mut [ComplexVector<V>]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::covariance::{Forward, ForwardBackward};
    use crate::linalg::panels::{TILE, panel};
    use num_complex::Complex;
    use std::vec;

    fn number(k: usize) -> ComplexVector<f32> {
        let part = |k: usize| ((k * 7 + k / 3) % 13) as f32 - 6.0;
        ComplexVector::new(part(k), part(k + 5))
    }

    /// The padding rows of the last panel are those of the identity, for every loading.
    fn assert_filled<A: Basis<f32>>() {
        for subaperture in 1..=9_usize {
            let diagonal_loading = DiagonalLoading {
                factor: 0.5,
                added: 0.0,
                zero_power: false,
            };
            let panels = subaperture.div_ceil(TILE);
            let mut matrix = vec![[A::Scalar::from_real(9.0); TILE]; panel(panels)];
            let lag = |index| Some(number(index));
            assert_eq!(
                A::matrix(lag, subaperture, &diagonal_loading, &mut matrix),
                Some(())
            );
            let last = &matrix[panel(panels - 1)..];
            for i in subaperture..TILE * panels {
                for (k, column) in last.iter().enumerate() {
                    let expected = Complex::new(if i == k { 1.0 } else { 0.0 }, 0.0);
                    let entry = column[i % TILE].complex().lane(0);
                    assert_eq!(entry, expected, "L = {subaperture}, ({i}, {k})");
                }
            }
        }
    }

    #[test]
    fn rows_beyond_the_subaperture_are_those_of_the_identity() {
        assert_filled::<Forward>();
        assert_filled::<ForwardBackward>();
    }
}
