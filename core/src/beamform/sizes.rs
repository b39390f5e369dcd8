//! How much memory a beamformer needs.

use crate::covariance::{Covariance, time_window};
use crate::linalg::lanczos::step_limit;
use crate::linalg::panels::TILE;
use crate::memory::Need;

/// The largest shapes that a beamformer is to work on: what its memory follows from.
///
/// ```
/// use bonebeam::beamform::Sizes;
/// use bonebeam::covariance::Covariance;
/// use bonebeam::memory::Need;
///
/// const SIZES: Sizes = Sizes { elements: 32, subaperture: 16, temporal_half_window: 2 };
/// // A constant, so that arrays can have the lengths.
/// const NEED: Need = SIZES.need(Covariance::ForwardBackward);
/// assert_eq!(NEED.complex, 576);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sizes {
    /// `M`: the most active elements.
    pub elements: usize,
    /// `L`: the longest subaperture.
    pub subaperture: usize,
    /// `K`: the covariance is averaged over up to `2K+1` samples.
    pub temporal_half_window: usize,
}

impl Sizes {
    /// The memory of a [`Workspace`](super::Workspace).
    ///
    /// With `S` lag sums kept of a sample (forward `L(L+1)/2`, forward-backward a quarter of `L(L+2)`
    /// for an even `L`), and 1 set of them for `K = 0`, else `2K+2`: `M + (5+K)·L + sets·S` complex
    /// vectors, `5·L` real ones, and about `L² + 10·L` numbers of the matrix, which are complex for forward
    /// and real for forward-backward.
    #[inline(always)]
    pub const fn need(self, covariance: Covariance) -> Need {
        let length = self.subaperture;
        let parts = Parts::new(length, self.temporal_half_window, covariance);
        let need = Need {
            real: length.saturating_mul(5),
            complex: self
                .elements
                .saturating_add(parts.work)
                .saturating_add(parts.ring)
                .saturating_add(parts.lags),
        };
        let scalars = parts
            .matrix
            .saturating_add(parts.factor)
            .saturating_add(parts.rows)
            .saturating_add(parts.padded.saturating_mul(2));
        need.and(match covariance {
            Covariance::Forward => Need {
                real: 0,
                complex: scalars,
            },
            Covariance::ForwardBackward => Need::real(scalars),
        })
    }
}

/// What the slices are cut into, in numbers; see the view's fields.
pub(super) struct Parts {
    pub(super) ring: usize,
    pub(super) lags: usize,
    pub(super) work: usize,
    pub(super) matrix: usize,
    pub(super) factor: usize,
    pub(super) rows: usize,
    /// A vector whose last tile is filled up.
    pub(super) padded: usize,
}

impl Parts {
    #[inline(always)]
    pub(super) const fn new(
        subaperture: usize,
        temporal_half_window: usize,
        covariance: Covariance,
    ) -> Self {
        let tiles = subaperture.div_ceil(TILE);
        let padded = tiles.saturating_mul(TILE);
        // As `panel(tiles)` columns, but for sizes that cannot be.
        let matrix = padded
            .saturating_mul(tiles.saturating_add(1))
            .saturating_mul(TILE / 2);
        // A Lanczos step leaves a basis vector, but for the first and the last.
        let basis = padded.saturating_mul(step_limit(subaperture).saturating_sub(1));
        Parts {
            ring: temporal_half_window
                .saturating_add(1)
                .saturating_mul(subaperture),
            lags: time_window::sets(temporal_half_window)
                .saturating_mul(covariance.lag_count(subaperture)),
            work: subaperture.saturating_mul(4),
            matrix,
            factor: if basis > matrix { basis } else { matrix },
            rows: padded.saturating_mul(TILE),
            padded,
        }
    }
}
