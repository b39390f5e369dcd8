//! The beamformer's memory.

use crate::covariance::{Averaging, OneLane};
use crate::linalg::panels::{PanelColumn, TILE};
use crate::linalg::tridiagonal::Tridiagonal;
use crate::simd::{ComplexVector, Scalar, Vector};

/// All the memory a beamformer needs; a plain struct for a `static` or a box.
///
/// `A` is [`Forward`] or [`ForwardBackward`], `V` a vector: `f32` for one output at a time, a
/// processor's registers for as many as they have lanes. Capacities: `M` active elements, subapertures
/// of `L` (a multiple of 4), and `ROWS` rows of `L` complex numbers for the time window:
/// [`ForwardBackward::window_rows`], [`Forward::window_rows`].
///
/// [`Forward`]: crate::covariance::Forward
/// [`Forward::window_rows`]: crate::covariance::Forward::window_rows
/// [`ForwardBackward`]: crate::covariance::ForwardBackward
/// [`ForwardBackward::window_rows`]: crate::covariance::ForwardBackward::window_rows
///
/// RAM is [`Workspace::BYTES`]: `4·LANES·(2s·L² + 2M + 2L·ROWS + (13 + 6s)·L) + 12·L` bytes and `L`
/// machine words, with `s = 1` for forward-backward and 2 for forward, and what aligns a register.
pub struct Workspace<A: Averaging<V>, V: Vector, const M: usize, const L: usize, const ROWS: usize>
{
    snapshot: [ComplexVector<V>; M],
    window: [[ComplexVector<V>; L]; ROWS],
    matrix: [[A::Scalar; L]; L],
    factor: [[A::Scalar; L]; L],
    rows: [PanelColumn<A::Scalar>; L],
    vector: [A::Scalar; L],
    tridiagonal: [[V; L]; 4],
    phases: [A::Scalar; L],
    lane: [[f32; L]; 2],
    values: [V; L],
    work: [[ComplexVector<V>; L]; 4],
    order: [usize; L],
    cumulative: [f32; L],
}

/// A [`Workspace`] as slices, so that the kernels are compiled once for all capacities.
pub(super) struct Memory<'a, S, V> {
    /// The active elements of one sample.
    pub(super) snapshot: &'a mut [ComplexVector<V>],
    /// A ring of subaperture sums, then the window's sets of lag sums; later eigenvectors, where they
    /// are asked for.
    pub(super) window: &'a mut [ComplexVector<V>],
    pub(super) solver: Solver<'a, S, V>,
}

/// What the solvers work on.
pub(super) struct Solver<'a, S, V> {
    /// The loaded covariance in panels.
    pub(super) matrix: &'a mut [PanelColumn<S>],
    /// The Lanczos basis, the Cholesky factor in panels, or the matrix while it is reduced.
    pub(super) factor: &'a mut [S],
    /// Steering vector and data below the matrix, or a reduction's vectors.
    pub(super) rows: &'a mut [PanelColumn<S>],
    pub(super) vector: &'a mut [S],
    pub(super) tridiagonal: Tridiagonal<'a, V>,
    pub(super) phases: &'a mut [S],
    /// One lane's tridiagonal matrix.
    pub(super) lane: [&'a mut [f32]; 2],
    pub(super) values: &'a mut [V],
    /// The subaperture sum, then the lag sums under way; later `Eᴴa` and `Eᴴx`, one after the other.
    pub(super) work: &'a mut [ComplexVector<V>],
    /// One lane's eigenvalues in descending order.
    pub(super) order: &'a mut [usize],
    /// One lane's cross-spectral metric.
    pub(super) cumulative: &'a mut [f32],
}

impl<A: Averaging<V>, V: Vector, const M: usize, const L: usize, const ROWS: usize>
    Workspace<A, V, M, L, ROWS>
{
    /// The size in bytes.
    pub const BYTES: usize = core::mem::size_of::<Self>();

    const SHAPES: () = {
        assert!(
            M >= 1 && L >= 1 && ROWS >= 1,
            "every capacity is at least 1"
        );
        assert!(L <= M, "a subaperture cannot exceed the aperture");
        assert!(
            L.is_multiple_of(TILE),
            "the subaperture capacity is a multiple of 4"
        );
    };

    /// A workspace over the lanes of `zero`, a vector of zeros.
    pub fn over(zero: V) -> Self {
        Self::filled(zero, A::Scalar::from_real(zero))
    }

    /// `zero` and `number` are the same zero as a vector and as the solver's number.
    const fn filled(zero: V, number: A::Scalar) -> Self {
        const { Self::SHAPES };
        let complex = ComplexVector { re: zero, im: zero };
        Workspace {
            snapshot: [complex; M],
            window: [[complex; L]; ROWS],
            matrix: [[number; L]; L],
            factor: [[number; L]; L],
            rows: [[number; TILE]; L],
            vector: [number; L],
            tridiagonal: [[zero; L]; 4],
            phases: [number; L],
            lane: [[0.0; L]; 2],
            values: [zero; L],
            work: [[complex; L]; 4],
            order: [0; L],
            cumulative: [0.0; L],
        }
    }

    pub(super) fn memory(&mut self) -> Memory<'_, A::Scalar, V> {
        let (matrix, _) = self.matrix.as_flattened_mut().as_chunks_mut();
        Memory {
            snapshot: &mut self.snapshot,
            window: self.window.as_flattened_mut(),
            solver: Solver {
                matrix,
                factor: self.factor.as_flattened_mut(),
                rows: &mut self.rows,
                vector: &mut self.vector,
                tridiagonal: Tridiagonal::new(&mut self.tridiagonal),
                phases: &mut self.phases,
                lane: self.lane.each_mut().map(|row| row.as_mut_slice()),
                values: &mut self.values,
                work: self.work.as_flattened_mut(),
                order: &mut self.order,
                cumulative: &mut self.cumulative,
            },
        }
    }
}

impl<A: OneLane, const M: usize, const L: usize, const ROWS: usize> Workspace<A, f32, M, L, ROWS> {
    /// A workspace for one output at a time, all zero.
    pub const fn new() -> Self {
        Self::filled(0.0, A::ZERO)
    }
}

impl<A: OneLane, const M: usize, const L: usize, const ROWS: usize> Default
    for Workspace<A, f32, M, L, ROWS>
{
    fn default() -> Self {
        Self::new()
    }
}
