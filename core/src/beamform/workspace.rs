//! The beamformer's memory where its sizes are known at compile time.

use super::sizes::{Parts, Sizes};
use super::view::{Slices, WorkspaceView};
use crate::covariance::{Averaging, Covariance, Forward, ForwardBackward};
use crate::simd::ComplexVector;

/// All the memory that a beamformer needs, for one output at a time; a plain struct for a `static`.
///
/// For up to `M` active elements, subapertures of up to `L` (4, 8, … 64, 96 or 128) and time windows of
/// up to `2K+1` samples (`K` up to 10). `A` is [`ForwardBackward`] or [`Forward`]. Memory for other
/// sizes, or for the lanes of a vector: [`WorkspaceView::new`].
///
/// RAM is [`Workspace::BYTES`]: the lengths of [`Sizes::lengths`], with 8 bytes a complex number and
/// 4 a scalar (8 forward) and a real.
///
/// ```
/// use bonebeam::beamform::{AlignedLine, Beamformer, Parameters, Workspace};
/// use bonebeam::{Complex, geometry::Active};
///
/// // 16 elements, L = 8, K = 2. On a target, such a workspace is a `static`.
/// let mut workspace = Workspace::<16, 8, 2>::new();
/// let samples = [Complex::new(1.0, 0.0); 100 * 16];
/// let mut z = [Complex::default(); 100];
/// let beamformer = Beamformer::new(Parameters { temporal_half_window: 2, ..Default::default() })?;
/// let line = AlignedLine::new(&samples, 16)?;
/// let all = |_| Active { first: 0, count: 16 };
/// beamformer.line(&mut workspace.view(), line, all, &mut z)?;
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// Sizes that cannot be are refused by the compiler:
///
/// ```compile_fail
/// # use bonebeam::beamform::Workspace;
/// let _ = Workspace::<16, 9, 2>::new();
/// ```
///
/// ```compile_fail
/// # use bonebeam::beamform::Workspace;
/// let _ = Workspace::<4, 8, 2>::new();
/// ```
pub struct Workspace<
    const M: usize,
    const L: usize,
    const K: usize,
    A: Storage<L, K> = ForwardBackward,
> {
    snapshot: [ComplexVector<f32>; M],
    complex: A::Complex,
    scalars: A::Scalars,
    reals: [[f32; L]; 5],
}

impl<const M: usize, const L: usize, const K: usize, A: Storage<L, K>> Workspace<M, L, K, A> {
    /// The size in bytes.
    pub const BYTES: usize = size_of::<Self>();

    /// What fits.
    pub const SIZES: Sizes = Sizes {
        elements: M,
        subaperture: L,
        temporal_half_window: K,
    };

    /// A workspace, all zero.
    pub const fn new() -> Self {
        const {
            assert!(M >= 1, "M, the number of elements, is at least 1");
            assert!(L <= M, "L, the subaperture, is at most M, the elements");
        }
        Workspace {
            snapshot: [ComplexVector { re: 0.0, im: 0.0 }; M],
            complex: A::COMPLEX,
            scalars: A::SCALARS,
            reals: [[0.0; L]; 5],
        }
    }

    /// The memory as slices, which is what a beamformer takes.
    #[inline]
    pub fn view(&mut self) -> WorkspaceView<'_, A> {
        WorkspaceView::cut(
            0.0,
            Self::SIZES,
            const { Parts::new(L, K, A::COVARIANCE) },
            &mut self.snapshot,
            Slices {
                complex: self.complex.as_mut(),
                scalars: self.scalars.as_mut(),
                reals: self.reals.as_flattened_mut(),
            },
        )
    }
}

impl<const M: usize, const L: usize, const K: usize, A: Storage<L, K>> Default
    for Workspace<M, L, K, A>
{
    fn default() -> Self {
        Self::new()
    }
}

/// The arrays of a [`Workspace`] whose lengths follow from `L` and `K`.
///
/// Stable Rust computes no array's length from a const parameter, so there is one implementation for
/// each `L` and `K`.
#[diagnostic::on_unimplemented(
    message = "no `Workspace` has a subaperture of L = {L} and a half-window of K = {K}",
    label = "L = {L}, K = {K}",
    note = "a Workspace has subapertures of L = 4, 8, … 64, 96 or 128, and a half-window K of 0 to 10",
    note = "memory of any size is a matter of slices: `WorkspaceView::new`"
)]
pub trait Storage<const L: usize, const K: usize>: Averaging<f32> {
    /// The array of complex numbers, but for the snapshot's.
    type Complex: AsMut<[ComplexVector<f32>]>;

    /// The array of the matrix's numbers.
    type Scalars: AsMut<[Self::Scalar]>;

    /// Zeros.
    const COMPLEX: Self::Complex;

    /// Zeros.
    const SCALARS: Self::Scalars;
}

/// [`Storage`] of both averagings for all `K` with each `L`.
macro_rules! storage {
    ($($l:literal)*) => {
        $(storage!($l: 0 1 2 3 4 5 6 7 8 9 10);)*
    };
    ($l:literal: $($k:literal)*) => {
        $(
            storage!(Forward, ComplexVector<f32>, ComplexVector { re: 0.0, im: 0.0 }, $l, $k);
            storage!(ForwardBackward, f32, 0.0, $l, $k);
        )*
    };
    ($averaging:ident, $scalar:ty, $zero:expr, $l:literal, $k:literal) => {
        #[doc(hidden)]
        impl Storage<$l, $k> for $averaging {
            type Complex = [ComplexVector<f32>; {
                let sizes = Sizes { elements: 0, subaperture: $l, temporal_half_window: $k };
                sizes.lengths(Covariance::$averaging).complex
            }];
            type Scalars = [$scalar; {
                let sizes = Sizes { elements: 0, subaperture: $l, temporal_half_window: $k };
                sizes.lengths(Covariance::$averaging).scalars
            }];
            const COMPLEX: Self::Complex = [ComplexVector { re: 0.0, im: 0.0 }; _];
            const SCALARS: Self::Scalars = [$zero; _];
        }
    };
}

storage!(4 8 12 16 20 24 28 32 36 40 44 48 52 56 60 64 96 128);
