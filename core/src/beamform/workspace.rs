//! The beamformer's memory, divided into the buffers of its kernels.

use super::sizes::{DirectionLengths, Lengths, Sizes};
use crate::Error;
use crate::covariance::{Averaging, ForwardBackward};
#[cfg(feature = "forward")]
use crate::covariance::{Covariance, Forward};
use crate::instructions::vectors;
use crate::linalg::panels::PanelColumn;
use crate::linalg::tridiagonal::Tridiagonal;
use crate::memory::Scratch;
use crate::simd::{ComplexVector, Vector, split_front};

/// Memory of a beamformer, divided by its shapes.
///
/// `V` is a vector: `f32` for one output at a time, a processor's registers for one output per lane. The kernels are
/// compiled once for all sizes.
///
/// ```
/// use bonebeam::prelude::stages::*;
/// use bonebeam::beamform::{Parameters, Sizes};
///
/// const PARAMETERS: Parameters = Parameters { temporal_half_window: 2, ..Parameters::DEFAULT };
/// const SIZES: Sizes = PARAMETERS.sizes(16);
/// const NEED: Need = SIZES.need();
/// // On a target, this is a `static`.
/// let mut memory = Memory::<{ NEED.real }, { NEED.complex }>::new();
/// let mut workspace = Workspace::new(0.0f32, SIZES, memory.scratch())?;
///
/// let samples = [Complex::new(1.0, 0.0); 100 * 16];
/// let mut z = [Complex::default(); 100];
/// let beamformer = Beamformer::new(PARAMETERS)?;
/// let line = AlignedLine::new(&samples, 16)?;
/// let all = |_| Active { first: 0, count: 16 };
/// beamformer.line(&mut workspace, line, all, &mut z)?;
/// # Ok::<(), bonebeam::Error>(())
/// ```
pub struct Workspace<'a, V: Vector = f32> {
    sizes: Sizes,
    pub(crate) buffers: Buffers<'a, V>,
}

/// The buffers of a workspace, by its covariance.
pub(crate) enum Buffers<'a, V: Vector> {
    #[cfg(feature = "forward")]
    Forward(View<'a, Forward, V>),
    ForwardBackward(View<'a, ForwardBackward, V>),
}

/// The buffers of a workspace, for the kernels of one covariance.
pub(crate) struct View<'a, A: Averaging<V>, V: Vector> {
    /// Source of new vectors.
    pub(crate) zero: V,
    /// The active elements of one sample.
    pub(super) snapshot: &'a mut [ComplexVector<V>],
    /// The last `K + 1` samples' subaperture sums, in turn.
    pub(super) ring: &'a mut [ComplexVector<V>],
    /// The time window's sets of lag sums.
    pub(super) lags: &'a mut [ComplexVector<V>],
    pub(super) solver: Solver<'a, A::Scalar, V>,
    pub(super) directions: Directions<'a, A::Scalar, V>,
}

/// Workspace of the directions of sub-lines.
pub(super) struct Directions<'a, S, V> {
    /// Powers of `e^{js}`, from the centre outwards.
    pub(super) powers_of_step: &'a mut [ComplexVector<V>],
    /// The active elements with phases; later the steering vector.
    pub(super) rotated: &'a mut [ComplexVector<V>],
    /// The sum of the subapertures with phases.
    pub(super) sums: &'a mut [ComplexVector<V>],
    /// That sum of each direction in the solver's coordinates.
    pub(super) data: &'a mut [ComplexVector<V>],
    /// The steering vector of each direction in the solver's coordinates, in tiles.
    pub(super) steering: &'a mut [S],
    /// The same as rows below the matrix.
    pub(super) rows: &'a mut [S],
    /// The matrix times its first eigenvector.
    pub(super) product: &'a mut [S],
    /// The tridiagonal matrix, kept for more than one search of its eigenvalues.
    pub(super) tridiagonal: &'a mut [V],
    /// `aᴴR⁻¹a` of each direction.
    pub(super) powers: &'a mut [V],
    /// `e^{−jφ_c}` of each direction, times the postfilter's factor.
    pub(super) phases: &'a mut [ComplexVector<V>],
    /// `e^{js/2}` of each direction; later `wᴴs`.
    pub(super) answers: &'a mut [ComplexVector<V>],
}

/// Workspace of the solvers.
pub(super) struct Solver<'a, S, V> {
    /// The loaded covariance in panels.
    pub(super) matrix: &'a mut [PanelColumn<S>],
    /// The Lanczos basis, the Cholesky factor in panels, or the matrix while it is reduced.
    pub(super) factor: &'a mut [PanelColumn<S>],
    /// Steering vector and data below the matrix, or a reduction's vectors.
    pub(super) rows: &'a mut [PanelColumn<S>],
    /// The eigenvector of the largest eigenvalue, or `Eᴴa`.
    pub(super) vector: &'a mut [S],
    pub(super) tridiagonal: Tridiagonal<'a, V>,
    pub(super) phases: &'a mut [S],
    /// Eigenvalues; later the cross-spectral metric.
    pub(super) values: &'a mut [V],
    /// The subaperture sum, then the lag sums under way; later `Eᴴx`.
    pub(super) work: &'a mut [ComplexVector<V>],
}

impl<'a, V: Vector> Workspace<'a, V> {
    /// A workspace for shapes up to `sizes`, in memory of size [`Sizes::need`].
    ///
    /// `zero` is a vector of zeros that sets the lanes. The function is inlined, so that the compiler knows
    /// constant sizes.
    ///
    /// # Errors
    /// [`Error::Length`] if the memory is shorter.
    #[inline(always)]
    pub fn new(zero: V, sizes: Sizes, scratch: Scratch<'a, V>) -> Result<Self, Error> {
        let mut scratch = scratch;
        let scratch = scratch.take(sizes.need())?;
        let buffers = match sizes.covariance {
            #[cfg(feature = "forward")]
            Covariance::Forward => Buffers::Forward(View::new(zero, sizes, scratch)),
            _ => Buffers::ForwardBackward(View::new(zero, sizes, scratch)),
        };
        Ok(Workspace { sizes, buffers })
    }

    /// The shapes that fit into the workspace.
    pub fn sizes(&self) -> Sizes {
        self.sizes
    }
}

impl<'a, A: Averaging<V>, V: Vector> View<'a, A, V> {
    /// The buffers for shapes up to `sizes`, in memory of that need.
    #[inline(always)]
    pub(crate) fn new(zero: V, sizes: Sizes, scratch: Scratch<'a, V>) -> Self {
        let sizes = Sizes {
            covariance: A::COVARIANCE,
            ..sizes
        };
        let (length, parts) = (sizes.subaperture, Lengths::new(sizes));
        let Scratch { mut real, complex } = scratch;
        let mut complex = vectors(complex);
        let mut scalars = |length| A::scalars(&mut real, &mut complex, length);
        let (matrix, factor, rows) = (
            scalars(parts.matrix),
            scalars(parts.factor),
            scalars(parts.rows),
        );
        let (vector, phases) = (scalars(parts.padded), scalars(parts.padded));
        let of = DirectionLengths::new(sizes);
        let (steering, below, product) = (
            scalars(of.steering),
            scalars(of.steering),
            scalars(of.product),
        );
        View {
            zero,
            snapshot: split_front(&mut complex, sizes.elements),
            ring: split_front(&mut complex, parts.ring),
            lags: split_front(&mut complex, parts.lags),
            solver: Solver {
                matrix: matrix.as_chunks_mut().0,
                factor: factor.as_chunks_mut().0,
                rows: rows.as_chunks_mut().0,
                vector,
                phases,
                tridiagonal: Tridiagonal::new([(); 4].map(|()| split_front(&mut real, length))),
                values: split_front(&mut real, length),
                work: split_front(&mut complex, parts.work),
            },
            directions: Directions {
                powers_of_step: split_front(&mut complex, of.powers_of_step),
                rotated: split_front(&mut complex, of.rotated),
                sums: split_front(&mut complex, of.sums),
                data: split_front(&mut complex, of.data),
                steering,
                rows: below,
                product,
                tridiagonal: split_front(&mut real, of.tridiagonal),
                powers: split_front(&mut real, of.sub_lines),
                phases: split_front(&mut complex, of.sub_lines),
                answers: split_front(&mut complex, of.sub_lines),
            },
        }
    }
}

/// Evaluates an expression with the buffers of a workspace, whatever its covariance.
macro_rules! with_view {
    ($workspace:expr, $view:ident => $work:expr) => {
        match &mut $workspace.buffers {
            #[cfg(feature = "forward")]
            $crate::beamform::Buffers::Forward($view) => $work,
            $crate::beamform::Buffers::ForwardBackward($view) => $work,
        }
    };
}
pub(crate) use with_view;
