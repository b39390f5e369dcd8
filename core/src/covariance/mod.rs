//! Spatially smoothed, time-averaged covariance (Eq. 2, 3).
//!
//! `sliding` sums the subarrays of one sample, `averaging` turns the sum into the matrix in use
//! ([`Forward`], or [`ForwardBackward`] as an exactly equivalent real symmetric one), `time_window`
//! adds up neighbouring samples, `loading` conditions the result for the solvers.
//!
//! The matrices are sums, not means: weights do not change when a covariance is multiplied by a
//! positive number, so the divisors of Eq. 2 and 3 are never applied.

mod averaging;
pub(crate) mod loading;
pub(crate) mod sliding;
mod time_window;

pub use averaging::{Averaging, Forward, ForwardBackward};
pub(crate) use time_window::TimeWindow;
