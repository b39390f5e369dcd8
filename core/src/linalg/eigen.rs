//! The full Hermitian eigensolver: Householder reduction to a real tridiagonal matrix, then implicit QL.

use super::householder::Reduction;
use super::implicit_ql::implicit_ql;
use super::panels::PanelColumn;
use crate::simd::{ComplexVector, Scalar, Vector};

/// All eigenvalues of the matrix `a` of `n` rows, unordered in `values`, and what the eigenvectors `E`
/// make of given vectors, which lie `stride` apart: each `vectors[r] ← Eᴴ·vectors[r]`.
///
/// With the unit vectors as `vectors` this is the whole of `E` (`vectors[i][k] = E(i,k)*`); a
/// caller who needs only `Eᴴa` and `Eᴴx` passes those two and saves `O(n³)` work.
///
/// Cost: the reduction, then QL.
#[inline(always)]
pub fn eigen<S: Scalar<V>, V: Vector>(
    a: &[PanelColumn<S>],
    n: usize,
    reduction: &mut Reduction<'_, '_, S, V>,
    values: &mut [V],
    vectors: &mut [ComplexVector<V>],
    stride: usize,
) {
    let mean = reduction.reduce(a, n);
    reduction.project(n, vectors, stride);
    let d = &mut reduction.tridiagonal.diagonal[..n];
    let e = &mut reduction.tridiagonal.off_diagonal[..n];
    implicit_ql(d, e, vectors, stride);
    for (value, &d) in values.iter_mut().zip(&*d) {
        *value = d + mean;
    }
}
