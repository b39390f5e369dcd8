//! Full Hermitian eigensolver: Householder reduction, then implicit QL.

use super::householder::Reduction;
use super::implicit_ql::implicit_ql;
use super::panels::PanelColumn;
use super::tridiagonal::Tridiagonal;
use crate::simd::{ComplexVector, Scalar, Vector};

/// Computes all eigenvalues of `a`, unordered, and projects two vectors: `x ← Eᴴx`.
///
/// The matrix has as many rows as `values`. One vector has the matrix's number type, the other is complex. A unit
/// vector gives a row of `E` (entry `k` is `E(i,k)*`). A caller who needs only `Eᴴa` and `Eᴴx` saves `O(n³)` work.
///
/// Cost: the reduction, then QL.
#[inline(always)]
pub fn eigen<S: Scalar<V>, V: Vector>(
    a: &[PanelColumn<S>],
    reduction: &mut Reduction<'_, '_, S, V>,
    values: &mut [V],
    x: &mut [S],
    y: &mut [ComplexVector<V>],
) {
    let n = values.len();
    let Some(zero) = values.first().map(|value| value.zero()) else {
        return;
    };
    let mean = reduction.reduce(zero, a, n);
    reduction.project(zero, n, x, y);
    let Tridiagonal {
        diagonal,
        off_diagonal,
        ..
    } = &mut *reduction.tridiagonal;
    let (Some(d), Some(e)) = (diagonal.get_mut(..n), off_diagonal.get_mut(..n)) else {
        return;
    };
    let ((x, _), (y, _)) = (x.as_chunks_mut::<1>(), y.as_chunks_mut::<1>());
    implicit_ql(zero, d, e, x, y);
    for (value, &d) in values.iter_mut().zip(&*d) {
        *value = d + mean;
    }
}
