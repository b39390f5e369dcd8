//! The dominant eigenpair by direct reduction, for every spectrum.
//!
//! Householder reduction to tridiagonal form, the dominant eigenpair of that matrix, and the back-transformation.

use super::householder::Reduction;
use super::panels::{PanelColumn, TILE};
use crate::simd::{Scalar, Vector};

/// The fraction of the eigenvalue below which a step towards it is the last.
const LAST_STEP: f32 = 1e-6;

/// Computes the largest eigenvalue of `a` and its unit eigenvector.
///
/// `a` has `n` rows. The eigenvector is left in the reduction's first vector, with zeros in the padding rows of the
/// last panel. Returns the eigenvalue. Lanes that are not `wanted` have undefined results.
///
/// Cost: the reduction, `2n²` flops (`8n²` complex) back, and for the tridiagonal matrix some seven times `n`
/// divisions.
#[inline(always)]
pub fn dominant_eigenpair<S: Scalar<V>, V: Vector>(
    zero: V,
    a: &[PanelColumn<S>],
    n: usize,
    reduction: &mut Reduction<'_, '_, S, V>,
    wanted: V::Mask,
) -> V {
    let mean = reduction.reduce(zero, a, n);
    let mut bound = zero;
    let tridiagonal = &mut *reduction.tridiagonal;
    for i in 0..n {
        if let Some(entry) = tridiagonal.diagonal.get_mut(i) {
            *entry = *entry + mean;
        }
        bound = tridiagonal.upper_bound(i + 1, bound);
    }
    let enough = zero.splat(LAST_STEP) * bound;
    let theta = tridiagonal.largest(n, bound, enough, wanted);
    tridiagonal.eigenvector(n, theta);
    let padded = n.next_multiple_of(TILE);
    let x = reduction.vectors.get_mut(..padded).unwrap_or_default();
    if let Some((x, beyond)) = x.split_at_mut_checked(n) {
        for (x, &y) in x.iter_mut().zip(&*tridiagonal.eigenvector) {
            *x = S::from_real(y);
        }
        beyond.fill(S::from_real(zero));
    }
    reduction.transform_back(zero, n);
    theta
}
