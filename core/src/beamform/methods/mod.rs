//! The methods: their names, arguments and kernels.
//!
//! A method is a file with its kernel, and its rows in this file. Nothing else in the crate depends on the method.

mod das;
mod directions;
mod eigenspace;
mod mv;
mod pairs;
mod stage;

pub(super) use directions::{Shape, answers};
pub(super) use eigenspace::{Subspace, at_least_floor, first_eigenpair, rank_order};

use super::apodization::Window;
use super::segment::Segment;
use super::table::{Parameter, Range, choices, range};
use super::workspace::Solver;
use crate::Error;
use crate::covariance::Averaging;
use crate::geometry::DepthStep;
use crate::linalg::size::{CONSTANTS, Known, Size};
use crate::simd::{ComplexVector, Mask, Scalar, Vector, vectorize};
use eigenspace::{esmv, esmv_rank1, esmv_rank1_steps};
use mv::mv;
use num_complex::Complex;

choices! {
    /// The beamforming method.
    ///
    /// All but [`Method::Das`] are adaptive, with weights for each sample.
    Method {
        /// Delay and sum: the mean over the active elements.
        Das, "das", "DAS";
        /// Minimum variance, Capon (Eq. 1, 4).
        Mv, "mv", "MV";
        /// Eigenspace MV (Eq. 5–7) of the smallest rank `j` with `c_j ≥ β·c_L` (Eq. 8).
        EsmvBeta(beta: f32 = 0.1, BETA), "esmv-beta", "ESMV by β";
        /// Eigenspace MV with a fixed rank, at most the subaperture's length.
        EsmvRank(rank: usize = 3, RANK), "esmv-rank", "ESMV of a fixed rank";
        /// Eigenspace MV with a signal subspace of rank 1.
        ///
        /// It uses the dominant eigenpair alone, by Lanczos steps, or by reduction to tridiagonal form if no
        /// eigenvalue stands out.
        EsmvRank1, "esmv-rank1", "ESMV rank 1";
        /// [`Method::EsmvRank1`] in constant time, by steps of power iteration.
        ///
        /// The number of steps is 1 to [`Method::MOST_STEPS`], for all data. The share of other eigenvectors falls
        /// by `λ₂/λ₁` a step: docs/numerics.md has a table. A sample whose covariance is singular in f32 gives 0,
        /// which a diagonal loading of 10⁻³ or more prevents.
        EsmvRank1Steps(steps: usize = 8, STEPS), "esmv-rank1-steps", "ESMV rank 1 by steps";
        /// Eigenspace MV with all eigenvectors but the first (Fig. 2c): `w − e₁e₁ᴴw`.
        EsmvExcludeFirst, "esmv-exclude-first", "ESMV without λ₁";
    }
}

/// `β` of [`Method::EsmvBeta`].
const BETA: Parameter = Parameter {
    name: "beta",
    unit: "",
    help: "β of the cross-spectral rank rule (Eq. 8): the share of the power that the signal subspace keeps",
    default: 0.01,
    example: 0.1,
    whole: false,
    range: range!(above 0, at most 1),
};

/// The rank of [`Method::EsmvRank`].
const RANK: Parameter = Parameter {
    name: "rank",
    unit: "",
    help: "A fixed rank of the signal subspace",
    default: 1.0,
    example: 3.0,
    whole: true,
    // Far above any subaperture's length: a larger rank was not meant.
    range: range!(at least 1 and at most 65536),
};

/// The steps of [`Method::EsmvRank1Steps`].
const STEPS: Parameter = Parameter {
    name: "power_steps",
    unit: "",
    help: "Steps of power iteration, for a time that does not depend on the data",
    default: 8.0,
    example: 8.0,
    whole: true,
    range: range!(1 to 64),
};

/// Computes the samples of a segment's active elements, apodized by a window.
///
/// Arguments are the number of elements and the depth step.
type Output =
    fn(segment: &Segment<'_>, (usize, DepthStep), window: Option<&Window>, z: &mut [Complex<f32>]);

/// A method without covariance, and so without subaperture or memory.
///
/// It works directly on the aligned samples of a segment's `count` active elements.
pub(super) struct Direct {
    /// Computes `z`.
    pub(super) output: Output,
    /// Computes the weights of the segment's first sample, one for each active element.
    pub(super) weights:
        fn(segment: &Segment<'_>, window: Option<&Window>, weights: &mut [Complex<f32>]),
}

/// Whether the eigenspace methods and their solvers are compiled in.
pub(super) const EIGENSPACE: bool = cfg!(feature = "eigenspace");

/// The least diagonal loading of MV without eigensolvers: no covariance is then singular in f32.
const LEAST_LOADING: f32 = 1e-4;

impl Method {
    /// Checks that the solvers that the method may use are compiled in.
    ///
    /// # Errors
    /// [`Error::Parameter`] without the feature `eigenspace`: for its methods, and for MV if a covariance of this
    /// diagonal loading may be singular in f32.
    pub(crate) const fn check_compiled(self, diagonal_loading: f32) -> Result<(), Error> {
        let (name, value, expected) = match self {
            _ if EIGENSPACE => return Ok(()),
            Method::Das => return Ok(()),
            Method::Mv if diagonal_loading >= LEAST_LOADING => return Ok(()),
            Method::Mv => (
                "diagonal_loading",
                diagonal_loading as f64,
                "at least 1e-4 without the feature eigenspace",
            ),
            _ => (
                self.name(),
                match self.argument() {
                    Some(argument) => argument,
                    None => 0.0,
                },
                "the feature eigenspace",
            ),
        };
        Err(Error::parameter(name, value, expected))
    }

    /// Maximum steps of [`Method::EsmvRank1Steps`].
    ///
    /// More steps would take longer than the whole eigensolver.
    pub const MOST_STEPS: usize = STEPS.range.most as usize;

    /// The kernels of a method without covariance.
    pub(super) const fn direct(self) -> Option<Direct> {
        match self {
            Method::Das => Some(Direct {
                output: das::das,
                weights: das::weights,
            }),
            _ => None,
        }
    }

    /// The subspace of eigenvectors in the other methods' weights.
    pub(super) fn subspace(self) -> Subspace {
        match self {
            Method::EsmvBeta(beta) => Subspace::CrossSpectral(beta),
            Method::EsmvRank(rank) => Subspace::Largest(rank),
            Method::EsmvRank1 | Method::EsmvRank1Steps(_) => Subspace::Largest(1),
            Method::EsmvExcludeFirst => Subspace::AllButLargest,
            Method::Mv | Method::Das => Subspace::All,
        }
    }
}

/// `wᴴs` for the loaded covariance in the solver's panels.
///
/// `s` is the data in the solver's coordinates. The `zero_power` lanes are undefined.
#[inline(always)]
pub(super) fn weighted_sum<A: Averaging<V>, V: Vector>(
    zero: V,
    method: Method,
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: impl Size,
    s: &[ComplexVector<V>],
    zero_power: V::Mask,
) -> ComplexVector<V> {
    let nothing = ComplexVector::from_real(zero);
    let (sum, solved) = match method {
        // Whole tiles of small subapertures are constants.
        Method::Mv => match (V::LANES, subaperture.known(), subaperture.get()) {
            (1, None, ..=4) if CONSTANTS => {
                solve_mv::<A, V>(zero, solver, (subaperture, Known::<4>), s)
            }
            (1, None, ..=8) if CONSTANTS => {
                solve_mv::<A, V>(zero, solver, (subaperture, Known::<8>), s)
            }
            _ => solve_mv::<A, V>(zero, solver, (subaperture, subaperture), s),
        },
        Method::EsmvRank1 if EIGENSPACE => solve(
            zero,
            solver,
            s,
            #[inline(always)]
            move |solver, s| esmv_rank1::<A, V>(zero, solver, subaperture, s, zero_power),
        ),
        Method::EsmvRank1Steps(steps) if EIGENSPACE => {
            return solve(
                zero,
                solver,
                s,
                #[inline(always)]
                move |solver, s| esmv_rank1_steps::<A, V>(zero, steps, solver, subaperture, s),
            );
        }
        _ => (nothing, zero_power & !zero_power),
    };
    if (solved | zero_power).all() {
        return sum;
    }
    if !EIGENSPACE {
        return ComplexVector::select(solved, sum, nothing);
    }
    let (subspace, real) = (method.subspace(), <A::Scalar as Scalar<V>>::PARTS == 1);
    let exact = match (V::LANES, subaperture.get()) {
        (1, 8) if CONSTANTS && real => exact::<A, V>(zero, subspace, solver, Known::<8>, s),
        (_, subaperture) => exact::<A, V>(zero, subspace, solver, subaperture, s),
    };
    ComplexVector::select(solved, sum, exact)
}

/// [`mv`] as a separate function.
#[inline(always)]
fn solve_mv<A: Averaging<V>, V: Vector>(
    zero: V,
    solver: &mut Solver<'_, A::Scalar, V>,
    sizes: (impl Size, impl Size),
    s: &[ComplexVector<V>],
) -> (ComplexVector<V>, V::Mask) {
    solve(
        zero,
        solver,
        s,
        #[inline(always)]
        move |solver, s| mv::<A, V>(zero, solver, sizes, s),
    )
}

/// The other methods, and the lanes in which the faster solvers fail.
///
/// Compiled for any size, and for eight elements with a real matrix: a tenth fewer instructions on a Cortex-M7.
#[inline(always)]
fn exact<A: Averaging<V>, V: Vector>(
    zero: V,
    subspace: Subspace,
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: impl Size,
    s: &[ComplexVector<V>],
) -> ComplexVector<V> {
    solve(
        zero,
        solver,
        s,
        #[inline(always)]
        move |solver, s| esmv::<A, V>(zero, subspace, solver, subaperture, s),
    )
}

/// Runs a kernel on the loaded matrix and the data, as a separate function.
///
/// See `segments`.
#[inline(never)]
fn solve<S: Scalar<V>, V: Vector, R>(
    zero: V,
    solver: &mut Solver<'_, S, V>,
    data: &[ComplexVector<V>],
    kernel: impl FnOnce(&mut Solver<'_, S, V>, &[ComplexVector<V>]) -> R,
) -> R {
    vectorize!(zero, kernel(solver, data))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beamform::{Parameters, View};
    use crate::covariance::ForwardBackward;
    use crate::linalg::panels::panel;
    use crate::memory::Memory;

    /// `w_pᴴs` by the full eigensolver, for eight elements.
    fn of_size(subspace: Subspace, n: impl Size) -> [u32; 2] {
        let mut memory = Memory::<1000, 1000>::new();
        let sizes = Parameters::DEFAULT.sizes(16);
        let mut view = View::<ForwardBackward, f32>::new(0.0, sizes, memory.scratch());
        let solver = &mut view.solver;
        let matrix = &mut *solver.matrix;
        for i in 0..8 {
            for k in 0..=i {
                let distance = (i - k) as f32;
                let own = if i == k { 2.0 + i as f32 } else { 0.0 };
                matrix[panel(i / 4) + k][i % 4] = 1.0 / (1.0 + distance) + own;
            }
        }
        let s: [ComplexVector<f32>; 8] =
            core::array::from_fn(|k| ComplexVector::new(1.0 - 0.25 * k as f32, 0.125 * k as f32));
        let sum = exact::<ForwardBackward, f32>(0.0, subspace, solver, n, &s);
        [sum.re.to_bits(), sum.im.to_bits()]
    }

    #[test]
    fn a_size_in_a_constant_has_the_bits_of_a_given_one() {
        for method in [Method::Mv, Method::EsmvBeta(0.1), Method::EsmvRank(3)] {
            let constant = of_size(method.subspace(), Known::<8>);
            assert_eq!(constant, of_size(method.subspace(), 8), "{method:?}");
            assert!(f32::from_bits(constant[0]).abs() > 1e-3);
        }
    }
}
