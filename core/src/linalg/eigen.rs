//! The full Hermitian eigensolver: Householder reduction to a real tridiagonal matrix, then implicit QL.

use super::householder::Reduction;
use super::implicit_ql::implicit_ql;
use super::panels::PanelColumn;
use super::tridiagonal::Tridiagonal;
use crate::simd::{ComplexVector, Scalar, Vector};

/// All eigenvalues of the matrix `a` of as many rows as there are `values`, unordered, and what the eigenvectors `E`
/// make of two given vectors of as many entries, one of the matrix's own numbers and a complex one: each
/// `x ← Eᴴx`.
///
/// A unit vector gives a row of `E` (entry `k` is `E(i,k)*`); a caller who needs only `Eᴴa` and `Eᴴx`
/// saves `O(n³)` work.
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
