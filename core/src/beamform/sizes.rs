//! Memory of a beamformer.

use crate::covariance::{Covariance, time_window};
use crate::linalg::lanczos::step_limit;
use crate::linalg::panels::TILE;
use crate::memory::Need;

/// The largest shapes that a beamformer works on; they determine its memory.
///
/// ```
/// use bonebeam::beamform::{Parameters, Sizes};
/// use bonebeam::memory::Need;
///
/// const SIZES: Sizes = Parameters { temporal_half_window: 2, ..Parameters::DEFAULT }.sizes(32);
/// // A constant, so that arrays can have the lengths.
/// const NEED: Need = SIZES.need();
/// assert_eq!(NEED.complex, 576);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sizes {
    /// The covariance, which sets the number of its sums and the numbers of its matrix.
    pub covariance: Covariance,
    /// `M`, the maximum number of active elements.
    pub elements: usize,
    /// `L`, the maximum subaperture length.
    pub subaperture: usize,
    /// `K`; the covariance is averaged over up to `2K+1` samples.
    pub temporal_half_window: usize,
    /// Maximum number of sub-lines; 0 and 1 need no memory.
    pub sub_lines: usize,
}

impl Sizes {
    /// The memory of a [`Workspace`](super::Workspace).
    ///
    /// `S` lag sums are kept per sample: `L(L+1)/2` for forward, a quarter of `L(L+2)` for forward-backward with an
    /// even `L`. There is 1 set of them for `K = 0`, else `2K+2`. The memory is `M + (5+K)·L + sets·S` complex vectors,
    /// `5·L` real ones, and about `L² + 10·L` numbers of the matrix, complex for forward and real for forward-backward.
    /// `N > 1` sub-lines add `1.5·M + (1+N)·L + 2N` complex vectors, `2·L + N` real ones and about `(2N+1)·L` numbers
    /// of the matrix.
    #[inline(always)]
    pub const fn need(self) -> Need {
        let parts = Lengths::new(self);
        let length = self.subaperture;
        let need = Need::new(
            length.saturating_mul(5),
            self.elements
                .saturating_add(parts.work)
                .saturating_add(parts.ring)
                .saturating_add(parts.lags),
        );
        let scalars = parts
            .matrix
            .saturating_add(parts.factor)
            .saturating_add(parts.rows)
            .saturating_add(parts.padded.saturating_mul(2));
        let directions = DirectionLengths::new(self);
        let scalars = scalars.saturating_add(directions.scalars());
        let need = need.and(directions.need());
        need.and(match self.covariance {
            Covariance::Forward => Need::new(0, scalars),
            Covariance::ForwardBackward => Need::real(scalars),
        })
    }
}

/// Memory of the sub-lines, in numbers; see the view's fields.
pub(super) struct DirectionLengths {
    pub(super) powers_of_step: usize,
    pub(super) rotated: usize,
    pub(super) sums: usize,
    pub(super) data: usize,
    /// Steering vectors, and rows: both as many.
    pub(super) steering: usize,
    pub(super) product: usize,
    pub(super) tridiagonal: usize,
    pub(super) sub_lines: usize,
}

impl DirectionLengths {
    #[inline(always)]
    pub(super) const fn new(sizes: Sizes) -> Self {
        if sizes.sub_lines <= 1 || sizes.elements == 0 {
            return DirectionLengths {
                powers_of_step: 0,
                rotated: 0,
                sums: 0,
                data: 0,
                steering: 0,
                product: 0,
                tridiagonal: 0,
                sub_lines: 0,
            };
        }
        let padded = sizes.subaperture.div_ceil(TILE).saturating_mul(TILE);
        DirectionLengths {
            powers_of_step: sizes.elements.div_ceil(2),
            rotated: sizes.elements,
            sums: sizes.subaperture,
            data: sizes.subaperture.saturating_mul(sizes.sub_lines),
            steering: padded.saturating_mul(sizes.sub_lines),
            product: padded,
            tridiagonal: sizes.subaperture.saturating_mul(2),
            sub_lines: sizes.sub_lines,
        }
    }

    /// Numbers of the matrix.
    const fn scalars(&self) -> usize {
        self.steering.saturating_mul(2).saturating_add(self.product)
    }

    /// All numbers other than those of the matrix.
    const fn need(&self) -> Need {
        Need::new(
            self.tridiagonal.saturating_add(self.sub_lines),
            self.powers_of_step
                .saturating_add(self.rotated)
                .saturating_add(self.sums)
                .saturating_add(self.data)
                .saturating_add(self.sub_lines.saturating_mul(2)),
        )
    }
}

/// Lengths of the slices' parts, in numbers; see the view's fields.
pub(super) struct Lengths {
    pub(super) ring: usize,
    pub(super) lags: usize,
    pub(super) work: usize,
    pub(super) matrix: usize,
    pub(super) factor: usize,
    pub(super) rows: usize,
    /// Length of a vector padded to whole tiles.
    pub(super) padded: usize,
}

impl Lengths {
    #[inline(always)]
    pub(super) const fn new(sizes: Sizes) -> Self {
        let Sizes {
            covariance,
            subaperture,
            temporal_half_window,
            ..
        } = sizes;
        let tiles = subaperture.div_ceil(TILE);
        let padded = tiles.saturating_mul(TILE);
        // As `panel(tiles)` columns, but saturating for impossible sizes.
        let matrix = padded
            .saturating_mul(tiles.saturating_add(1))
            .saturating_mul(TILE / 2);
        // Each Lanczos step except the first and the last leaves a basis vector.
        let basis = padded.saturating_mul(step_limit(subaperture).saturating_sub(1));
        Lengths {
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
