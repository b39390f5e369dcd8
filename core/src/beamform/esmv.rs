//! Eigenspace minimum variance (Eq. 5–8).

use super::mv::{solved, whitened_steering};
use super::parameters::Method;
use super::workspace::Solver;
use crate::covariance::Averaging;
use crate::lanes::{ComplexLanes, Lanes, Scalar};
use crate::linalg::FLOOR;
use crate::linalg::eigen::eigen;
use crate::linalg::power_iteration::power_iteration;
use num_complex::Complex;

/// `w_pᴴs` with a signal subspace of rank 1, for the loaded covariance `a`.
///
/// With `λ₁` and `e₁` no back substitution is needed: `w_p = e₁(e₁ᴴa)/(λ₁·aᴴR⁻¹a)`, and
/// `aᴴR⁻¹a = ‖G⁻¹a‖²` from one forward solve. Also returns the lanes that this is true of: where the
/// power iteration does not arrive, or `R` is singular in f32, the caller takes [`esmv`] instead.
///
/// Cost: the power iteration, one factorisation, one triangular solve.
#[inline]
pub(super) fn esmv_rank1<A: Averaging<W>, const L: usize, const W: usize>(
    a: &mut [[A::Scalar; L]; L],
    subarray: usize,
    s: &[ComplexLanes<W>; L],
    solver: &mut Solver<A::Scalar, L, W>,
) -> (ComplexLanes<W>, [bool; W]) {
    let (eigenvalue, arrived) = power_iteration(a, subarray, &mut solver.v, &mut solver.next);
    if !arrived.contains(&true) {
        return (ComplexLanes::ZERO, arrived);
    }
    let mut steering = A::Scalar::ZERO;
    let mut data = ComplexLanes::ZERO;
    for i in 0..subarray {
        let e = solver.v[i];
        let entry = A::Scalar::from_real(Lanes::splat(A::steering(i, subarray)));
        steering = steering + entry.mul_conj(e);
        data = data + e.conj_mul_complex(s[i]);
    }
    let (power, definite) = whitened_steering::<A, L, W>(a, subarray, solver);
    let product = steering.conj_mul_complex(data);
    let divisor = eigenvalue * power;
    let z = ComplexLanes {
        re: product.re / divisor,
        im: product.im / divisor,
    };
    let solved = solved(definite, z);
    (z, core::array::from_fn(|k| arrived[k] && solved[k]))
}

/// `w_pᴴs` by the full eigensolver, for the loaded covariance `a` (its lower triangle is
/// destroyed).
///
/// `w_pᴴs = Σ (e_kᴴa)*·(e_kᴴs)/λ_k / Σ_all |e_kᴴa|²/λ_k`, the first sum over the eigenvectors that
/// `method` keeps, both in descending order of `λ`: neither the eigenvectors nor the weights are
/// formed.
pub(super) fn esmv<A: Averaging<W>, const L: usize, const W: usize>(
    method: Method,
    a: &mut [[A::Scalar; L]; L],
    subarray: usize,
    s: &[ComplexLanes<W>; L],
    solver: &mut Solver<A::Scalar, L, W>,
) -> ComplexLanes<W> {
    let Solver {
        eigen: scratch,
        values,
        projections,
        ..
    } = solver;
    for i in 0..subarray {
        let entry = Lanes::splat(A::steering(i, subarray));
        projections[0][i] = ComplexLanes {
            re: entry,
            im: Lanes::ZERO,
        };
        projections[1][i] = s[i];
    }
    eigen(a, subarray, scratch, values, projections);
    let mut z = ComplexLanes::ZERO;
    for lane in 0..W {
        let mut sum = Complex::new(0.0f32, 0.0);
        let spectrum = Spectrum::new(values, &projections[0], subarray, lane);
        for k in spectrum.kept(method, subarray) {
            let index = spectrum.order[k];
            let a = projections[0][index].lane(lane);
            let x = projections[1][index].lane(lane);
            let product = a.conj() * x;
            sum += product / spectrum.value(values, index, lane);
        }
        z.set_lane(lane, sum / spectrum.total);
    }
    z
}

/// One lane's eigenvalues in descending order, and the cross-spectral metric (Eq. 8).
pub(super) struct Spectrum<const L: usize> {
    /// Indices of the eigenvalues, largest first; equal ones in the order found.
    pub(super) order: [usize; L],
    /// `c_j = Σ_{k≤j} |e_kᴴa|²/λ_k`.
    cumulative: [f32; L],
    /// `c_L`.
    pub(super) total: f32,
}

impl<const L: usize> Spectrum<L> {
    pub(super) fn new<const W: usize>(
        values: &[Lanes<W>; L],
        steering: &[ComplexLanes<W>; L],
        n: usize,
        lane: usize,
    ) -> Self {
        let mut order = [0; L];
        for i in 0..n {
            let mut place = i;
            while place > 0 && values[order[place - 1]].0[lane] < values[i].0[lane] {
                order[place] = order[place - 1];
                place -= 1;
            }
            order[place] = i;
        }
        let mut spectrum = Spectrum {
            order,
            cumulative: [0.0; L],
            total: 0.0,
        };
        for j in 0..n {
            let index = order[j];
            let projection = steering[index].lane(lane);
            spectrum.total += projection.norm_sqr() / spectrum.value(values, index, lane);
            spectrum.cumulative[j] = spectrum.total;
        }
        spectrum
    }

    /// Eigenvalue `index`, no smaller than the rounding error of the trace.
    pub(super) fn value<const W: usize>(
        &self,
        values: &[Lanes<W>; L],
        index: usize,
        lane: usize,
    ) -> f32 {
        let value = values[index].0[lane];
        if value > FLOOR { value } else { FLOOR }
    }

    /// Which places in [`Spectrum::order`] make up the subspace that `method` keeps.
    pub(super) fn kept(&self, method: Method, n: usize) -> core::ops::Range<usize> {
        match method {
            Method::EsmvBeta(beta) => {
                let threshold = beta * self.total;
                let mut rank = 1;
                while rank < n && self.cumulative[rank - 1] < threshold {
                    rank += 1;
                }
                0..rank
            }
            Method::EsmvRank(rank) => 0..if rank < n { rank } else { n },
            Method::EsmvRank1 => 0..1,
            Method::EsmvExcludeFirst => 1..n,
            // MV keeps them all; DAS never comes here.
            Method::Mv | Method::Das => 0..n,
        }
    }
}
