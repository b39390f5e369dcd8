//! What an averaging of the covariance is: what is kept of it, and the basis in which it is solved.

use super::Covariance;
use super::diagonal_loading::DiagonalLoading;
use crate::linalg::panels::PanelColumn;
use crate::simd::{ComplexVector, Scalar, Vector};

/// Rows that stand below the matrix for MV.
pub(crate) const RIGHT_SIDES: usize = 3;

/// Which covariance is in use: [`Forward`](super::Forward) or
/// [`ForwardBackward`](super::ForwardBackward), over the lanes of `V`.
///
/// `A::COVARIANCE` is the averaging as data, `A::Scalar` the number of its matrix: a
/// [`ComplexVector`] or a `V`.
pub trait Averaging<V: Vector>: Basis<V> {
    /// A real number as one of the matrix: what memory is filled with.
    #[inline(always)]
    fn scalar(value: V) -> Self::Scalar {
        Self::Scalar::from_real(value)
    }
}

impl<A: Basis<V>, V: Vector> Averaging<V> for A {}

/// What is kept of a sample's covariance, and how it becomes the solver's matrix. Out of reach from
/// outside the crate, so that there are no other averagings.
pub trait Basis<V: Vector> {
    /// The number of the solver's matrix: complex for forward, real for forward-backward.
    type Scalar: Scalar<V>;

    /// The same as data.
    const COVARIANCE: Covariance;

    /// Takes the forward sums of the lags `lag..lag + LAGS` into `lags`: `rows[place][k]` is that of
    /// lag `lag + k`, the entry at `(lag + k + place, place)`. There is a row for each place of `lag`;
    /// what stands beyond the last place of a longer lag is to be left out.
    fn keep<const LAGS: usize>(
        lags: &mut [ComplexVector<V>],
        subaperture: usize,
        lag: usize,
        rows: &[[ComplexVector<V>; LAGS]],
    );

    /// The trace of the matrix in use, from the kept sums `lag(index)`, all of which there must be.
    fn trace(lag: impl Fn(usize) -> Option<ComplexVector<V>>, subaperture: usize) -> Option<V>;

    /// The matrix in use, scaled and loaded, in panels, from the kept sums `lag(index)`, all of which
    /// there must be.
    fn matrix(
        lag: impl Fn(usize) -> Option<ComplexVector<V>>,
        subaperture: usize,
        diagonal_loading: &DiagonalLoading<V>,
        matrix: &mut [PanelColumn<Self::Scalar>],
    ) -> Option<()>;

    /// The subaperture sum `s` in the solver's coordinates.
    fn data(s: &[ComplexVector<V>], data: &mut [ComplexVector<V>]);

    /// Entry `i` of the steering vector `a = 1` in the solver's coordinates.
    fn steering(i: usize, subaperture: usize) -> f32;

    /// The steering vector and the data, in the solver's coordinates, as rows below the matrix.
    fn right_sides(data: &[ComplexVector<V>], rows: &mut [[Self::Scalar; RIGHT_SIDES]]);

    /// From one column of those rows after factorisation, with `y = G⁻¹a` and `t = G⁻¹s`: `|y|²`
    /// and `y*·t`.
    fn whitened(rows: &[Self::Scalar; RIGHT_SIDES]) -> (V, ComplexVector<V>);

    /// What `wᴴs` must be divided by, for `P` subapertures, to be `z` of Eq. 4.
    fn gain(subapertures: usize) -> f32;

    /// Weights in the solver's coordinates → weights of the subaperture's elements (Eq. 1, 7), with
    /// `scratch` of the same length.
    fn weights(v: &mut [ComplexVector<V>], scratch: &mut [ComplexVector<V>]);
}
