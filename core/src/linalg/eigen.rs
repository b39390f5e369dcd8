//! The full Hermitian eigensolver: Householder reduction to a real tridiagonal matrix over lanes,
//! then implicit QL.

use super::householder::Reduction;
use super::implicit_ql::implicit_ql;
use super::panels::PanelColumn;
use crate::simd::{ComplexVector, Scalar, Vector};

/// All eigenvalues of the matrix `a` of `n` rows, unordered in `values`, and what the eigenvectors `E`
/// make of given vectors, which lie `stride` apart: each `vectors[r] ← Eᴴ·vectors[r]`.
///
/// With the unit vectors as `vectors` this is the whole of `E` (`vectors[i][k] = E(i,k)*`); a
/// caller who needs only `Eᴴa` and `Eᴴx` passes those two and saves `O(n³)` work. `lane` holds one
/// lane's diagonal and off-diagonal.
///
/// Cost: the reduction over lanes; then QL lane by lane.
#[inline(always)]
pub fn eigen<S: Scalar<V>, V: Vector>(
    a: &[PanelColumn<S>],
    n: usize,
    reduction: &mut Reduction<'_, '_, S, V>,
    lane: &mut [&mut [f32]; 2],
    values: &mut [V],
    vectors: &mut [ComplexVector<V>],
    stride: usize,
) {
    let mean = reduction.reduce(a, n);
    reduction.project(n, vectors, stride);
    let [d, e] = lane;
    for lane in 0..V::LANES {
        for k in 0..n {
            d[k] = reduction.tridiagonal.diagonal[k].lanes()[lane];
            e[k] = if k + 1 < n {
                reduction.tridiagonal.off_diagonal[k].lanes()[lane]
            } else {
                0.0
            };
        }
        implicit_ql(&mut d[..n], &mut e[..n], vectors, stride, lane);
        for k in 0..n {
            values[k].lanes_mut()[lane] = d[k] + mean.lanes()[lane];
        }
    }
}
