//! The beamformer's memory as slices, whoever owns them.

use super::sizes::{Parts, Sizes};
use crate::Error;
use crate::covariance::{Averaging, Covariance, ForwardBackward};
use crate::linalg::panels::PanelColumn;
use crate::linalg::tridiagonal::Tridiagonal;
use crate::simd::{ComplexVector, Vector, split_front};

/// The memory that a beamformer works in, as slices: of a [`Workspace`](super::Workspace), or of a
/// caller who knows the sizes only at run time.
///
/// `A` is [`Forward`](crate::covariance::Forward) or [`ForwardBackward`], `V` a vector: `f32` for one
/// output at a time, a processor's registers for as many as they have lanes. The kernels are compiled
/// once for all sizes.
///
/// ```
/// use bonebeam::beamform::{Sizes, Slices, WorkspaceView};
/// use bonebeam::covariance::{Averaging, Covariance, ForwardBackward};
/// use bonebeam::simd::ComplexVector;
///
/// let sizes = Sizes { elements: 48, subaperture: 23, temporal_half_window: 1 };
/// let lengths = sizes.lengths(Covariance::ForwardBackward);
/// let zero = 0.0f32;
/// let mut complex = vec![ComplexVector::from_real(zero); lengths.complex];
/// let mut scalars = vec![ForwardBackward::scalar(zero); lengths.scalars];
/// let mut reals = vec![zero; lengths.reals];
/// let view = WorkspaceView::<ForwardBackward>::new(zero, sizes, Slices {
///     complex: &mut complex,
///     scalars: &mut scalars,
///     reals: &mut reals,
/// })?;
/// assert_eq!(view.sizes(), sizes);
/// # Ok::<(), bonebeam::Error>(())
/// ```
pub struct WorkspaceView<'a, A: Averaging<V> = ForwardBackward, V: Vector = f32> {
    /// What new vectors are made from.
    pub(super) zero: V,
    pub(super) sizes: Sizes,
    /// The active elements of one sample.
    pub(super) snapshot: &'a mut [ComplexVector<V>],
    /// The last `K + 1` samples' subaperture sums, in turn.
    pub(super) ring: &'a mut [ComplexVector<V>],
    /// The time window's sets of lag sums.
    pub(super) lags: &'a mut [ComplexVector<V>],
    pub(super) solver: Solver<'a, A::Scalar, V>,
}

/// What the solvers work on.
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

/// Memory for a [`WorkspaceView`], at least as long as [`Sizes::lengths`] says. What it holds does not
/// matter.
pub struct Slices<'a, A: Averaging<V> = ForwardBackward, V: Vector = f32> {
    /// The samples, their covariances and their time window.
    pub complex: &'a mut [ComplexVector<V>],
    /// The matrix, its factor, and vectors beside them: [`Averaging::scalar`] makes such a number.
    pub scalars: &'a mut [A::Scalar],
    /// A tridiagonal matrix and eigenvalues.
    pub reals: &'a mut [V],
}

impl<'a, A: Averaging<V>, V: Vector> WorkspaceView<'a, A, V> {
    /// A view for shapes of up to `sizes` over the lanes of `zero`, a vector of zeros.
    ///
    /// # Errors
    /// [`Error::Length`] naming the slice that is too short.
    pub fn new(zero: V, sizes: Sizes, slices: Slices<'a, A, V>) -> Result<Self, Error> {
        let lengths = sizes.lengths(A::COVARIANCE);
        for (name, actual, expected) in [
            ("slice `complex`", slices.complex.len(), lengths.complex),
            ("slice `scalars`", slices.scalars.len(), lengths.scalars),
            ("slice `reals`", slices.reals.len(), lengths.reals),
        ] {
            if actual < expected {
                return Err(Error::Length {
                    name,
                    actual,
                    expected,
                });
            }
        }
        let mut slices = slices;
        let snapshot = split_front(&mut slices.complex, sizes.elements);
        let parts = Parts::new(sizes.subaperture, sizes.temporal_half_window, A::COVARIANCE);
        Ok(Self::cut(zero, sizes, parts, snapshot, slices))
    }

    /// The shapes that fit.
    pub fn sizes(&self) -> Sizes {
        self.sizes
    }

    /// Cuts slices that are long enough into `parts`, those of `sizes`; those of complex vectors begin
    /// behind the snapshot. Inlined, so that nothing is left of it where the sizes are constants.
    #[inline(always)]
    pub(super) fn cut(
        zero: V,
        sizes: Sizes,
        parts: Parts,
        snapshot: &'a mut [ComplexVector<V>],
        slices: Slices<'a, A, V>,
    ) -> Self {
        let length = sizes.subaperture;
        let Slices {
            mut complex,
            mut scalars,
            mut reals,
        } = slices;
        WorkspaceView {
            zero,
            sizes,
            snapshot,
            ring: split_front(&mut complex, parts.ring),
            lags: split_front(&mut complex, parts.lags),
            solver: Solver {
                matrix: split_front(&mut scalars, parts.matrix).as_chunks_mut().0,
                factor: split_front(&mut scalars, parts.factor).as_chunks_mut().0,
                rows: split_front(&mut scalars, parts.rows).as_chunks_mut().0,
                vector: split_front(&mut scalars, parts.padded),
                phases: split_front(&mut scalars, parts.padded),
                tridiagonal: Tridiagonal::new([(); 4].map(|()| split_front(&mut reals, length))),
                values: split_front(&mut reals, length),
                work: split_front(&mut complex, parts.work),
            },
        }
    }
}

impl<V: Vector> WorkspaceView<'_, ForwardBackward, V> {
    /// A view of no memory, which is what DAS needs.
    pub fn empty(zero: V) -> Self {
        let slices = Slices {
            complex: &mut [],
            scalars: &mut [],
            reals: &mut [],
        };
        let sizes = Sizes::default();
        let parts = Parts::new(0, 0, Covariance::ForwardBackward);
        Self::cut(zero, sizes, parts, &mut [], slices)
    }
}
