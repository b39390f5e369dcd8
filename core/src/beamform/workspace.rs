//! The beamformer's memory.

use crate::covariance::{Averaging, TimeWindow};
use crate::lanes::{ComplexLanes, Lanes, Scalar};
use crate::linalg::eigen::EigenScratch;

/// All the memory a beamformer needs; a plain struct for a `static` or a box.
///
/// Capacities: `M` active elements, subarrays of `L`, a time window of `SLOTS ≥ 2K+1` samples, `W`
/// lanes. `A` is [`Forward`](crate::covariance::Forward) or
/// [`ForwardBackward`](crate::covariance::ForwardBackward).
///
/// RAM is [`Workspace::BYTES`]: `4W·(L²·(2 + (SLOTS+2)·s) + 2M + 2L·SLOTS + (8+4s)·L)` bytes with
/// `s = 1` for forward-backward and 2 for forward, and at most two machine words more. The full
/// eigensolver takes another `8L` bytes of stack (`12L` where a word has 64 bits).
pub struct Workspace<
    A: Averaging<W>,
    const M: usize,
    const L: usize,
    const SLOTS: usize,
    const W: usize,
> {
    /// The active elements of one sample.
    pub(super) snapshot: [ComplexLanes<W>; M],
    /// One sample's forward sums; later the eigenvectors, where they are asked for.
    pub(super) forward: [[ComplexLanes<W>; L]; L],
    pub(super) window: TimeWindow<A::Scalar, L, SLOTS>,
    /// The subarray sums of the window's samples, in the solver's coordinates.
    pub(super) data: [[ComplexLanes<W>; L]; SLOTS],
    /// The covariance in use; then its factor beside it.
    pub(super) matrix: [[A::Scalar; L]; L],
    pub(super) solver: Solver<A::Scalar, L, W>,
}

/// Vectors of the solvers.
pub(super) struct Solver<S, const L: usize, const W: usize> {
    pub(super) inverse: [Lanes<W>; L],
    pub(super) v: [S; L],
    pub(super) next: [S; L],
    pub(super) eigen: EigenScratch<S, L, W>,
    pub(super) values: [Lanes<W>; L],
    /// `Eᴴa` and `Eᴴx`.
    pub(super) projections: [[ComplexLanes<W>; L]; 2],
}

impl<A: Averaging<W>, const M: usize, const L: usize, const SLOTS: usize, const W: usize>
    Workspace<A, M, L, SLOTS, W>
{
    /// The size in bytes.
    pub const BYTES: usize = core::mem::size_of::<Self>();

    const SHAPES: () = {
        assert!(
            M >= 1 && L >= 1 && SLOTS >= 1 && W >= 1,
            "every capacity is at least 1"
        );
        assert!(L <= M, "a subarray cannot exceed the aperture");
    };

    /// A workspace, all zero.
    pub const fn new() -> Self {
        const { Self::SHAPES };
        let zero = <A::Scalar as Scalar<W>>::ZERO;
        Workspace {
            snapshot: [ComplexLanes::ZERO; M],
            forward: [[ComplexLanes::ZERO; L]; L],
            window: TimeWindow::new(zero),
            data: [[ComplexLanes::ZERO; L]; SLOTS],
            matrix: [[zero; L]; L],
            solver: Solver {
                inverse: [Lanes::ZERO; L],
                v: [zero; L],
                next: [zero; L],
                eigen: EigenScratch::new(zero),
                values: [Lanes::ZERO; L],
                projections: [[ComplexLanes::ZERO; L]; 2],
            },
        }
    }
}

impl<A: Averaging<W>, const M: usize, const L: usize, const SLOTS: usize, const W: usize> Default
    for Workspace<A, M, L, SLOTS, W>
{
    fn default() -> Self {
        Self::new()
    }
}
