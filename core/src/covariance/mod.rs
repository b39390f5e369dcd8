//! Spatially smoothed, time-averaged covariance (Eq. 2, 3).
//!
//! `lag_sums` sums the subapertures of one sample, `time_window` adds up neighbouring samples,
//! [`Averaging`] turns the sums into the matrix in use ([`Forward`], or [`ForwardBackward`] as an
//! exactly equivalent real symmetric one), `diagonal_loading` conditions it for the solvers.
//!
//! The matrices are sums, not means: weights do not change when a covariance is multiplied by a
//! positive number, so the divisors of Eq. 2 and 3 are never applied.

mod averaging;
pub(crate) mod diagonal_loading;
mod forward;
mod forward_backward;
pub(crate) mod lag_sums;
pub(crate) mod time_window;

pub(crate) use averaging::RIGHT_SIDES;
pub use averaging::{Averaging, OneLane};
pub use forward::Forward;
pub use forward_backward::ForwardBackward;
