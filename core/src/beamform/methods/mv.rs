//! Minimum variance (Eq. 1, 4).

use crate::beamform::workspace::Solver;
use crate::covariance::{Averaging, RIGHT_SIDES};
use crate::linalg::cholesky::factorise;
use crate::linalg::panels::TILE;
use crate::linalg::size::Size;
use crate::simd::{ComplexVector, Scalar, Vector};

/// `wᴴs` for the loaded covariance in the solver's panels and the data `s` in the solver's
/// coordinates.
///
/// `R = GGᴴ`, `y = G⁻¹a`, `t = G⁻¹s`; `wᴴs = aᴴR⁻¹s/aᴴR⁻¹a = yᴴt/‖y‖²`: no back substitution.
///
/// Also returns the lanes in which that holds. If `R` is singular in f32, as is possible with a `Δ` near 0, the
/// caller uses [`esmv`](super::eigenspace::esmv) with all eigenvectors instead.
///
/// `n` rows of the matrix are factorised: the subaperture, or its whole tiles.
///
/// Cost: one factorisation with two rows below it.
#[inline(always)]
pub(in crate::beamform) fn mv<A: Averaging<V>, V: Vector>(
    zero: V,
    solver: &mut Solver<'_, A::Scalar, V>,
    (subaperture, n): (impl Size, impl Size),
    s: &[ComplexVector<V>],
) -> (ComplexVector<V>, V::Mask) {
    let (zero, subaperture) = (zero.zero(), subaperture.get());
    let (rows, _) = solver.rows.as_flattened_mut().as_chunks_mut();
    A::right_sides(s.get(..subaperture).unwrap_or_default(), rows);
    let padded = subaperture.next_multiple_of(TILE);
    let beyond = rows.get_mut(subaperture..padded).unwrap_or_default();
    beyond.fill([A::Scalar::from_real(zero); RIGHT_SIDES]);
    let definite = factorise(zero, solver.matrix, solver.factor, rows, n);
    // ‖G⁻¹a‖² = aᴴR⁻¹a and (G⁻¹a)ᴴ(G⁻¹s) = aᴴR⁻¹s, both sums ascending from zero.
    let mut power = zero;
    let mut product = ComplexVector::from_real(zero);
    for row in rows.get(..subaperture).unwrap_or_default() {
        let (own, cross) = A::whitened(row);
        power = power + own;
        product = product + cross;
    }
    let z = product.divide(power);
    (z, definite & z.is_finite())
}
