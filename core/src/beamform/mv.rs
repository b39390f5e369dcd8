//! Minimum variance (Eq. 1, 4).

use super::workspace::Solver;
use crate::covariance::Averaging;
use crate::lanes::{ComplexLanes, Lanes, Scalar};
use crate::linalg::cholesky::{factorise, solve_lower, solve_upper};
use crate::linalg::norm_sqr;

/// `wᴴs` for the loaded covariance `a` and the data `s` in the solver's coordinates.
///
/// `R = GGᴴ`, `g = G⁻¹a`, `v = G⁻ᴴg`; `wᴴs = Σ v_i*·s_i / ‖g‖²`, both sums ascending from zero.
///
/// Also returns the lanes that this is true of: where `R` is singular in f32, as it can be with a
/// `Δ` near 0, the caller takes [`esmv`](super::esmv::esmv) with all eigenvectors instead.
///
/// Cost: one factorisation and two triangular solves.
#[inline]
pub(super) fn mv<A: Averaging<W>, const L: usize, const W: usize>(
    a: &mut [[A::Scalar; L]; L],
    subarray: usize,
    s: &[ComplexLanes<W>; L],
    solver: &mut Solver<A::Scalar, L, W>,
) -> (ComplexLanes<W>, [bool; W]) {
    let (power, definite) = whitened_steering::<A, L, W>(a, subarray, solver);
    solve_upper(a, subarray, &solver.inverse, &mut solver.v);
    let mut sum = ComplexLanes::ZERO;
    for i in 0..subarray {
        sum = sum + solver.v[i].conj_mul_complex(s[i]);
    }
    let z = ComplexLanes {
        re: sum.re / power,
        im: sum.im / power,
    };
    (z, solved(definite, z))
}

/// The lanes whose factorisation stands and has led to a number.
#[inline]
pub(super) fn solved<const W: usize>(definite: [bool; W], z: ComplexLanes<W>) -> [bool; W] {
    let finite = z.is_finite();
    core::array::from_fn(|k| definite[k] && finite[k])
}

/// Factorises `a`, leaves `g = G⁻¹a` in the solver's `v` and returns `‖g‖² = aᴴR⁻¹a`, and the lanes
/// in which `a` is positive definite.
#[inline]
pub(super) fn whitened_steering<A: Averaging<W>, const L: usize, const W: usize>(
    a: &mut [[A::Scalar; L]; L],
    subarray: usize,
    solver: &mut Solver<A::Scalar, L, W>,
) -> (Lanes<W>, [bool; W]) {
    let definite = factorise(a, subarray, &mut solver.inverse);
    for i in 0..subarray {
        solver.v[i] = A::Scalar::from_real(Lanes::splat(A::steering(i, subarray)));
    }
    solve_lower(a, subarray, &solver.inverse, &mut solver.v);
    let power = norm_sqr::<A::Scalar, W>(&solver.v[..subarray]);
    (power, definite)
}
