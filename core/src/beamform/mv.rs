//! Minimum variance (Eq. 1, 4).

use super::workspace::Solver;
use crate::covariance::Averaging;
use crate::lanes::{ComplexLanes, Lanes, Scalar};
use crate::linalg::cholesky::{factorise, solve_lower, solve_upper};

/// `wᴴs` for the loaded covariance `a` and the data `s` in the solver's coordinates.
///
/// `R = GGᴴ`, `g = G⁻¹a`, `v = G⁻ᴴg`; `wᴴs = Σ v_i*·s_i / ‖g‖²`, both sums ascending from zero.
///
/// Cost: one factorisation and two triangular solves.
#[inline]
pub(super) fn mv<A: Averaging<W>, const L: usize, const W: usize>(
    a: &mut [[A::Scalar; L]; L],
    subarray: usize,
    s: &[ComplexLanes<W>; L],
    solver: &mut Solver<A::Scalar, L, W>,
) -> ComplexLanes<W> {
    let power = whitened_steering::<A, L, W>(a, subarray, solver);
    solve_upper(a, subarray, &solver.inverse, &mut solver.v);
    let mut sum = ComplexLanes::ZERO;
    for i in 0..subarray {
        sum = sum + solver.v[i].conj_mul_complex(s[i]);
    }
    ComplexLanes {
        re: sum.re / power,
        im: sum.im / power,
    }
}

/// Factorises `a`, leaves `g = G⁻¹a` in the solver's `v` and returns `‖g‖² = aᴴR⁻¹a`.
#[inline]
pub(super) fn whitened_steering<A: Averaging<W>, const L: usize, const W: usize>(
    a: &mut [[A::Scalar; L]; L],
    subarray: usize,
    solver: &mut Solver<A::Scalar, L, W>,
) -> Lanes<W> {
    factorise(a, subarray, &mut solver.inverse);
    for i in 0..subarray {
        solver.v[i] = A::Scalar::from_real(Lanes::splat(A::steering(i, subarray)));
    }
    solve_lower(a, subarray, &solver.inverse, &mut solver.v);
    crate::linalg::norm_sqr::<A::Scalar, W>(&solver.v[..subarray])
}
