//! Linear algebra over lanes: a Hermitian (or real symmetric) matrix of trace near 1 in each (see
//! [`DiagonalLoading`](crate::covariance::diagonal_loading::DiagonalLoading)), kept in [`panels`].
//!
//! - [`cholesky`]: the factorisation, and what it divides.
//! - [`lanczos`]: the dominant eigenpair in few steps, where they prove it; by [`matrix_vector`],
//!   [`inner_product`] and [`gap`].
//! - [`power_iteration`]: nearly the same, in a fixed number of steps.
//! - [`dominant_eigenpair`]: the same directly, for the lanes that are left. [`householder`] reduces the
//!   matrix to a [`tridiagonal`] one, whose dominant eigenpair is taken back.
//! - [`eigen`]: all eigenvalues, by the same reduction and [`implicit_ql`].

pub(crate) mod cholesky;
pub(crate) mod dominant_eigenpair;
pub(crate) mod eigen;
mod gap;
pub(crate) mod householder;
pub(crate) mod implicit_ql;
pub(crate) mod inner_product;
pub(crate) mod lanczos;
pub(crate) mod matrix_vector;
pub(crate) mod panels;
pub(crate) mod power_iteration;
#[cfg(test)]
mod tests;
pub(crate) mod tridiagonal;

/// The smallest pivot and eigenvalue that count, for matrices of trace near 1: one rounding error.
/// A loaded matrix stays above it whenever `Δ/L > 2⁻²⁴`.
pub(crate) const FLOOR: f32 = 1.0 / 16_777_216.0; // 2^-24
