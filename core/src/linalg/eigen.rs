//! The full Hermitian eigensolver: Householder reduction to a real tridiagonal matrix, then implicit QL.

use super::householder::Reduction;
use super::implicit_ql::implicit_ql;
use super::panels::PanelColumn;
use crate::simd::{ComplexVector, Scalar, Vector};

/// All eigenvalues of the matrix `a` of `n` rows, unordered in `values`, and what the eigenvectors `E`
/// make of two given vectors of as many entries: each `x ← Eᴴx`.
///
/// A unit vector gives a row of `E` (entry `k` is `E(i,k)*`); a caller who needs only `Eᴴa` and `Eᴴx`
/// saves `O(n³)` work.
///
/// Cost: the reduction, then QL.
#[inline(always)]
pub fn eigen<S: Scalar<V>, V: Vector>(
    a: &[PanelColumn<S>],
    n: usize,
    reduction: &mut Reduction<'_, '_, S, V>,
    values: &mut [V],
    [x, y]: [&mut [ComplexVector<V>]; 2],
) {
    let mean = reduction.reduce(a, n);
    reduction.project(n, [&mut *x, &mut *y]);
    let d = &mut reduction.tridiagonal.diagonal[..n];
    let e = &mut reduction.tridiagonal.off_diagonal[..n];
    implicit_ql(d, e, [x, y]);
    for (value, &d) in values.iter_mut().zip(&*d) {
        *value = d + mean;
    }
}
