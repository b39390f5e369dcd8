//! The methods: what each is called, what it may be asked for, and the kernel that makes its output.
//!
//! A method is a file with its kernel, and its lines in this one: nothing else in the crate tells one
//! method from another.

mod das;
mod eigenspace;
mod mv;

pub(super) use eigenspace::{Subspace, at_least_floor, rank_order};

use super::run::Run;
use super::view::Solver;
use crate::Error;
use crate::covariance::Averaging;
use crate::simd::{ComplexVector, Mask, Scalar, Vector};
use eigenspace::{esmv, esmv_rank1, esmv_rank1_steps};
use mv::mv;
use num_complex::Complex;

/// The beamformer. All but [`Method::Das`] are adaptive, with weights for each sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Method {
    /// Delay and sum: the mean over the active elements.
    Das,
    /// Minimum variance, Capon (Eq. 1, 4).
    Mv,
    /// Eigenspace MV (Eq. 5–7) with the cross-spectral rank rule (Eq. 8): the smallest rank `j`
    /// with `c_j ≥ β·c_L`.
    EsmvBeta(f32),
    /// Eigenspace MV with a fixed rank, at most the subaperture's length.
    EsmvRank(usize),
    /// Eigenspace MV with a signal subspace of rank 1: the dominant eigenpair alone, by Lanczos steps,
    /// or by reduction to tridiagonal form where no eigenvalue stands out.
    EsmvRank1,
    /// [`Method::EsmvRank1`] in constant time: the eigenpair is that of so many steps of power iteration,
    /// 1 to [`Method::MOST_STEPS`], whatever the data are. What is left of the other eigenvectors falls by
    /// `λ₂/λ₁` a step: docs/numerics.md has a table. A sample whose covariance is singular in f32 is 0,
    /// which takes a diagonal loading below about 10⁻³.
    EsmvRank1Steps(usize),
    /// Eigenspace MV with all eigenvectors but the first (Fig. 2c): `w − e₁e₁ᴴw`.
    EsmvExcludeFirst,
}

/// A method that takes no covariance, and so neither a subaperture nor memory: it works straight on the
/// aligned samples of a run's `count` active elements.
pub(super) struct Direct {
    /// Makes `z`.
    pub(super) output: fn(run: &Run<'_>, count: usize, z: &mut [Complex<f32>]),
    /// Makes the weights of the run's first sample, one an active element.
    pub(super) weights: fn(run: &Run<'_>, weights: &mut [Complex<f32>]),
}

impl Method {
    /// The most steps of [`Method::EsmvRank1Steps`]: more take longer than the whole eigensolver.
    pub const MOST_STEPS: usize = 64;

    /// Refuses what the method cannot be asked for.
    pub(super) fn check(self) -> Result<(), Error> {
        match self {
            Method::EsmvBeta(beta) if !(beta > 0.0 && beta <= 1.0) => Err(Error::Parameter {
                name: "beta",
                value: beta as f64,
                expected: "above 0, at most 1",
            }),
            Method::EsmvRank(0) => Err(Error::Parameter {
                name: "rank",
                value: 0.0,
                expected: "at least 1",
            }),
            Method::EsmvRank1Steps(steps) if !(1..=Method::MOST_STEPS).contains(&steps) => {
                Err(Error::Parameter {
                    name: "steps",
                    value: steps as f64,
                    expected: "1 to 64",
                })
            }
            _ => Ok(()),
        }
    }

    /// The kernels of a method that takes no covariance.
    pub(super) fn direct(self) -> Option<Direct> {
        match self {
            Method::Das => Some(Direct {
                output: das::das,
                weights: das::weights,
            }),
            _ => None,
        }
    }

    /// The eigenvectors that the other methods' weights are made of.
    pub(super) fn subspace(self) -> Subspace {
        match self {
            Method::EsmvBeta(beta) => Subspace::Share(beta),
            Method::EsmvRank(rank) => Subspace::Largest(rank),
            Method::EsmvRank1 | Method::EsmvRank1Steps(_) => Subspace::Largest(1),
            Method::EsmvExcludeFirst => Subspace::AllButLargest,
            Method::Mv | Method::Das => Subspace::All,
        }
    }
}

/// `wᴴs` for the loaded covariance in the solver's panels and the data `s` in the solver's
/// coordinates. What it is in the `silent` lanes means nothing.
#[inline(always)]
pub(super) fn weighted_sum<A: Averaging<V>, V: Vector>(
    zero: V,
    method: Method,
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: usize,
    s: &[ComplexVector<V>],
    silent: V::Mask,
) -> ComplexVector<V> {
    let nothing = ComplexVector::from_real(zero);
    let (sum, solved) = match method {
        Method::Mv => solve(
            zero,
            solver,
            s,
            #[inline(always)]
            move |solver, s| mv::<A, V>(zero, solver, subaperture, s),
        ),
        Method::EsmvRank1 => solve(
            zero,
            solver,
            s,
            #[inline(always)]
            move |solver, s| esmv_rank1::<A, V>(zero, solver, subaperture, s, silent),
        ),
        Method::EsmvRank1Steps(steps) => {
            return solve(
                zero,
                solver,
                s,
                #[inline(always)]
                move |solver, s| esmv_rank1_steps::<A, V>(zero, steps, solver, subaperture, s),
            );
        }
        _ => (nothing, silent & !silent),
    };
    if (solved | silent).all() {
        return sum;
    }
    // The other methods, and the lanes that the faster solvers leave.
    let subspace = method.subspace();
    let exact = solve(
        zero,
        solver,
        s,
        #[inline(always)]
        move |solver, s| esmv::<A, V>(zero, subspace, solver, subaperture, s),
    );
    ComplexVector::select(solved, sum, exact)
}

/// Runs a kernel on the loaded matrix and the data: a function of its own for each (see `runs`).
#[inline(never)]
fn solve<S: Scalar<V>, V: Vector, R>(
    zero: V,
    solver: &mut Solver<'_, S, V>,
    data: &[ComplexVector<V>],
    kernel: impl FnOnce(&mut Solver<'_, S, V>, &[ComplexVector<V>]) -> R,
) -> R {
    zero.vectorize(
        #[inline(always)]
        || kernel(solver, data),
    )
}
