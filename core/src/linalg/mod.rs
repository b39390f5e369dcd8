//! Linear algebra over lanes, on one Hermitian or real symmetric matrix per lane.
//!
//! The matrix's trace is near 1 (see [`DiagonalLoading`](crate::covariance::diagonal_loading::DiagonalLoading)).
//! [`panels`] gives its storage.
//!
//! - [`cholesky`]: the factorisation and its triangular solves.
//! - [`lanczos`]: the dominant eigenpair if few steps prove it; by [`matrix_vector`], [`inner_product`] and
//!   [`gap`].
//! - [`power_iteration`]: the dominant eigenpair approximately, in a fixed number of steps.
//! - [`dominant_eigenpair`]: the dominant eigenpair directly, for the other lanes. [`householder`] reduces the
//!   matrix to a [`tridiagonal`] one, whose dominant eigenpair is transformed back.
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
pub(crate) mod size;
#[cfg(test)]
mod tests;
pub(crate) mod tridiagonal;

/// The smallest pivot and eigenvalue that count, for matrices of trace near 1: one rounding error.
/// A loaded matrix stays above it whenever `Δ/L > 2⁻²⁴`.
pub(crate) const FLOOR: f32 = 1.0 / 16_777_216.0; // 2^-24
