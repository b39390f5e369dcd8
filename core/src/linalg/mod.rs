//! Cholesky, the first eigenvector (by Lanczos steps or directly) and the full eigensolver, over lanes.
//!
//! Each works on a Hermitian (or real symmetric) matrix with a trace near 1 (see
//! [`DiagonalLoading`](crate::covariance::diagonal_loading::DiagonalLoading)), kept in [`panels`].

pub(crate) mod cholesky;
pub(crate) mod dominant_eigenpair;
pub(crate) mod eigen;
mod gap;
pub(crate) mod householder;
pub(crate) mod inner_product;
pub(crate) mod lanczos;
pub(crate) mod largest_pair;
pub(crate) mod matrix_vector;
pub(crate) mod panels;
#[cfg(test)]
mod tests;
mod tridiagonal;

/// The smallest pivot and eigenvalue that count, for matrices of trace near 1: one rounding error.
/// A loaded matrix stays above it whenever `Δ/L > 2⁻²⁴`.
pub(crate) const FLOOR: f32 = 1.0 / 16_777_216.0; // 2^-24
