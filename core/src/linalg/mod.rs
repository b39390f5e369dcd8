//! Cholesky, power iteration and the full eigensolver, over lanes.
//!
//! Each works on a Hermitian (or real symmetric) matrix of which the lower triangle is stored, in
//! the leading `n × n` block of an `L × L` array, with a trace near 1 (see
//! [`load`](crate::covariance::loading::load)).

pub(crate) mod cholesky;
pub(crate) mod eigen;
pub(crate) mod power_iteration;
#[cfg(test)]
mod tests;
mod tridiagonal;

use crate::lanes::{Lanes, Scalar};

/// The smallest pivot and eigenvalue that count, for matrices of trace near 1: one rounding error.
/// A loaded matrix stays above it whenever `Δ/L > 2⁻²⁴`.
pub(crate) const FLOOR: f32 = 1.0 / 16_777_216.0; // 2^-24

/// `y = A·v`, each entry summed from zero over ascending columns.
#[inline]
pub(crate) fn hermitian_times_vector<S: Scalar<W>, const L: usize, const W: usize>(
    a: &[[S; L]; L],
    start: usize,
    end: usize,
    v: &[S; L],
    y: &mut [S; L],
) {
    for i in start..end {
        let row = &a[i];
        let mut sum = S::ZERO;
        for j in start..i {
            sum = sum + row[j].mul(v[j]);
            // The same product serves the upper triangle: row j has summed columns below i so far.
            y[j] = y[j] + v[i].mul_conj(row[j]);
        }
        y[i] = sum + row[i].mul(v[i]);
    }
}

/// `Σ_i |v_i|²`, `i` ascending from zero.
#[inline]
pub(crate) fn norm_sqr<S: Scalar<W>, const W: usize>(v: &[S]) -> Lanes<W> {
    let mut sum = Lanes::ZERO;
    for x in v {
        sum += x.norm_sqr();
    }
    sum
}
