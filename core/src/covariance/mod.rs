//! Spatially smoothed, time-averaged covariance (Eq. 2, 3).
//!
//! `lag_sums` sums the subapertures of one sample. `time_window` sums neighbouring samples. `Averaging` turns the
//! sums into the matrix in use, for each [`Covariance`].
//! `diagonal_loading` conditions it for the solvers.
//!
//! The matrices are sums, not means: weights do not change when a covariance is multiplied by a
//! positive number, so the divisors of Eq. 2 and 3 are never applied.

mod averaging;
pub(crate) mod diagonal_loading;
mod forward;
mod forward_backward;
pub(crate) mod lag_sums;
pub(crate) mod time_window;

pub(crate) use averaging::{Averaging, RIGHT_SIDES};
pub(crate) use forward::Forward;
pub(crate) use forward_backward::ForwardBackward;

/// The covariance estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Covariance {
    /// `R` of Eq. 2, complex Hermitian, as in the paper's figures.
    Forward,
    /// `R_FB` of Eq. 3, as an exactly equivalent real symmetric matrix.
    #[default]
    ForwardBackward,
}

impl Covariance {
    /// Number of lag sums kept of a sample.
    ///
    /// It saturates at a number that no memory holds.
    #[inline(always)]
    pub(crate) const fn lag_count(self, subaperture: usize) -> usize {
        match self {
            Covariance::Forward => Forward::lag_count(subaperture),
            Covariance::ForwardBackward => ForwardBackward::lag_count(subaperture),
        }
    }
}
