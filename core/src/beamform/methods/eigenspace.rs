//! Eigenspace minimum variance (Eq. 5–8).

use crate::beamform::workspace::Solver;
use crate::covariance::Averaging;
use crate::linalg::FLOOR;
use crate::linalg::cholesky::factorise;
use crate::linalg::dominant_eigenpair::dominant_eigenpair;
use crate::linalg::eigen::eigen;
use crate::linalg::householder::Reduction;
use crate::linalg::inner_product::inner_product;
use crate::linalg::lanczos::{self, STEP_LIMIT, lanczos};
use crate::linalg::matrix_vector::times_vector;
use crate::linalg::panels::TILE;
use crate::linalg::power_iteration::power_iteration;
use crate::linalg::size::Size;
use crate::simd::{ComplexVector, Mask, Scalar, Vector, copy, vectorize};

/// `w_pᴴs` with a signal subspace of rank 1, for the loaded covariance in the solver's panels.
///
/// With `λ₁` and `e₁` no back substitution is needed: `w_p = e₁(e₁ᴴa)/(λ₁·aᴴR⁻¹a)`, and `aᴴR⁻¹a = ‖G⁻¹a‖²` from one
/// forward solve. The Lanczos iteration serves the lanes in which it converges, [`dominant_eigenpair`] the others
/// except the `zero_power` ones. Also returns the solved lanes: if `R` is singular in f32, the caller uses [`esmv`]
/// instead.
///
/// `e₁ᴴa` is computed as `e₁ᴴ(R·a)/λ₁`. For an off-axis echo the terms of `e₁ᴴa` cancel, and an error of `e₁` would
/// enter their small sum in full. In this form the error is multiplied by at most `λ₂/λ₁`, and the roundings of `R·a`,
/// each a fraction of an entry of `e₁`, average out.
///
/// Cost: the eigenpair, one product of the matrix with a vector, and one factorisation with a row below it.
#[inline(always)]
pub(in crate::beamform) fn esmv_rank1<A: Averaging<V>, V: Vector>(
    zero: V,
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: impl Size,
    s: &[ComplexVector<V>],
    zero_power: V::Mask,
) -> (ComplexVector<V>, V::Mask) {
    let zero = zero.zero();
    let Some(eigenvalue) = first_eigenpair::<A, V>(zero, solver, subaperture, zero_power) else {
        let nothing = ComplexVector::from_real(zero);
        return (nothing, zero_power & !zero_power);
    };
    by_eigenpair::<A, V>(zero, solver, subaperture, s, eigenvalue)
}

/// The largest eigenvalue of the loaded covariance; its eigenvector is in the solver's `vector`. One function for
/// the line and for its sub-lines.
#[inline(never)]
pub(in crate::beamform) fn first_eigenpair<A: Averaging<V>, V: Vector>(
    zero: V,
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: impl Size,
    zero_power: V::Mask,
) -> Option<V> {
    vectorize!(
        zero,
        dominant::<A, V>(zero, solver, subaperture, zero_power)
    )
}

#[inline(always)]
fn dominant<A: Averaging<V>, V: Vector>(
    zero: V,
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: impl Size,
    zero_power: V::Mask,
) -> Option<V> {
    let padded = subaperture.get().next_multiple_of(TILE);
    let (tiles, _) = solver.vector.get_mut(..padded)?.as_chunks_mut();
    let memory = lanczos::Memory {
        basis: solver.factor,
        vector: tiles,
        tridiagonal: &mut solver.tridiagonal,
        kept: solver.values,
    };
    // Arrays of as many steps as the constant size has.
    let (mut eigenvalue, arrived) = match subaperture.known() {
        Some(8) => lanczos::<_, _, 8>(zero, solver.matrix, subaperture, memory, zero_power),
        _ => lanczos::<_, _, STEP_LIMIT>(zero, solver.matrix, subaperture, memory, zero_power),
    };
    let left = !(arrived | zero_power);
    if left.any() {
        let value = direct_eigenpair(zero, solver, subaperture.get(), left);
        eigenvalue = V::select(left, value, eigenvalue);
    }
    Some(eigenvalue)
}

/// [`dominant_eigenpair`] of the lanes `left`; compiled once, for sizes in constants or not.
#[inline(never)]
fn direct_eigenpair<S: Scalar<V>, V: Vector>(
    zero: V,
    solver: &mut Solver<'_, S, V>,
    subaperture: usize,
    left: V::Mask,
) -> V {
    let mut reduction = Reduction {
        panels: solver.factor,
        vectors: solver.rows.as_flattened_mut(),
        phases: solver.phases,
        tridiagonal: &mut solver.tridiagonal,
    };
    vectorize!(zero, {
        let value = dominant_eigenpair(zero, solver.matrix, subaperture, &mut reduction, left);
        let padded = subaperture.next_multiple_of(TILE);
        let vector = solver.vector.iter_mut().take(padded);
        for (e, &direct) in vector.zip(&*reduction.vectors) {
            *e = S::select(left, direct, *e);
        }
        value
    })
}

/// [`esmv_rank1`] with the eigenpair of a fixed number of `steps` of power iteration.
///
/// Every sample takes the same operations. If `R` is singular in f32, `w_pᴴs` is 0: the eigensolver that serves the
/// other methods there has no constant time.
#[inline(always)]
pub(in crate::beamform) fn esmv_rank1_steps<A: Averaging<V>, V: Vector>(
    zero: V,
    steps: usize,
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: impl Size,
    s: &[ComplexVector<V>],
) -> ComplexVector<V> {
    let zero = zero.zero();
    let nothing = ComplexVector::from_real(zero);
    let Some(eigenvalue) = stepped_eigenpair::<A, V>(steps, solver, subaperture.get()) else {
        return nothing;
    };
    let (sum, solved) = by_eigenpair::<A, V>(zero, solver, subaperture, s, eigenvalue);
    ComplexVector::select(solved, sum, nothing)
}

/// Eigenvalue after a number of power iteration steps.
///
/// The eigenvector is in the solver's `vector`.
#[inline(always)]
pub(super) fn stepped_eigenpair<A: Averaging<V>, V: Vector>(
    steps: usize,
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: usize,
) -> Option<V> {
    let padded = subaperture.next_multiple_of(TILE);
    let vector = solver.vector.get_mut(..padded)?;
    let product = solver.factor.get_mut(..padded / TILE)?;
    let (vector, _) = vector.as_chunks_mut();
    power_iteration(solver.matrix, subaperture, steps, vector, product)
}

/// `w_pᴴs` of the eigenvector in the solver's `vector`, and the lanes in which `R` is not singular in f32.
#[inline(always)]
fn by_eigenpair<A: Averaging<V>, V: Vector>(
    zero: V,
    solver: &mut Solver<'_, A::Scalar, V>,
    n: impl Size,
    s: &[ComplexVector<V>],
    eigenvalue: V,
) -> (ComplexVector<V>, V::Mask) {
    let subaperture = n.get();
    let padded = subaperture.next_multiple_of(TILE);
    let nothing = ComplexVector::from_real(zero);
    let none = zero.mask(|_| false);
    let Some(vector) = solver.vector.get(..padded) else {
        return (nothing, none);
    };
    let mut product = nothing;
    for (&e, &s) in vector.iter().zip(s) {
        product = product + e.conj_mul_complex(s);
    }
    let steering = solver.rows.as_flattened_mut().get_mut(..padded);
    let (vector, _) = vector.as_chunks();
    let (Some(steering), Some(transformed)) = (steering, solver.factor.get_mut(..vector.len()))
    else {
        return (nothing, none);
    };
    let Some((entries, beyond)) = steering.split_at_mut_checked(subaperture) else {
        return (nothing, none);
    };
    for (i, entry) in entries.iter_mut().enumerate() {
        *entry = A::Scalar::from_real(zero.splat(A::steering(i, subaperture)));
    }
    beyond.fill(A::Scalar::from_real(zero));
    times_vector(solver.matrix, zero, steering.as_chunks().0, transformed);
    let projection = inner_product(zero, vector, transformed);
    let (rows, _) = steering.as_chunks_mut();
    let definite = factorise::<_, _, 1>(zero, solver.matrix, solver.factor, rows, n);
    // ‖G⁻¹a‖², ascending from zero.
    let mut power = zero;
    for [y] in rows.get(..subaperture).unwrap_or_default() {
        power = power + y.norm_sqr();
    }
    let z = projection
        .conj_mul_complex(product)
        .divide(eigenvalue * eigenvalue * power);
    (z, definite & z.is_finite())
}

/// `w_pᴴs` by the full eigensolver, for the loaded covariance in the solver's panels.
///
/// `w_pᴴs = Σ (e_kᴴa)*·(e_kᴴs)/λ_k / Σ_all |e_kᴴa|²/λ_k`, the first sum over the eigenvectors that
/// `subspace` has, both in descending order of `λ`: neither the eigenvectors nor the weights are
/// formed.
#[inline(always)]
pub(in crate::beamform) fn esmv<A: Averaging<V>, V: Vector>(
    zero: V,
    subspace: Subspace,
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: impl Size,
    s: &[ComplexVector<V>],
) -> ComplexVector<V> {
    let (zero, subaperture) = (zero.zero(), subaperture.get());
    let nothing = ComplexVector::from_real(zero);
    let Solver {
        matrix,
        factor,
        rows,
        phases,
        tridiagonal,
        values,
        vector: steering,
        work: data,
        ..
    } = solver;
    let (Some(steering), Some(data), Some(values), Some(s)) = (
        steering.get_mut(..subaperture),
        data.get_mut(..subaperture),
        values.get_mut(..subaperture),
        s.get(..subaperture),
    ) else {
        return nothing;
    };
    for (i, entry) in steering.iter_mut().enumerate() {
        *entry = A::Scalar::from_real(zero.splat(A::steering(i, subaperture)));
    }
    copy(s, data);
    let mut reduction = Reduction {
        panels: factor,
        vectors: rows.as_flattened_mut(),
        phases,
        tridiagonal,
    };
    eigen(matrix, &mut reduction, values, steering, data);
    // The remains of the matrix are overwritten.
    let (Some(metrics), Some(order)) = (
        tridiagonal.diagonal.get_mut(..subaperture),
        tridiagonal.eigenvector.get_mut(..subaperture),
    ) else {
        return nothing;
    };
    let terms = data;
    let projected = steering.iter().zip(&mut *terms);
    for ((steering, term), (metric, &value)) in projected.zip(metrics.iter_mut().zip(&*values)) {
        let value = at_least_floor(value);
        *term = steering.conj_mul_complex(*term).divide(value);
        *metric = steering.norm_sqr() / value;
    }
    let total = rank_order(zero, values, metrics, order);
    let sum = subspace_sum(
        zero,
        subspace,
        (values, order),
        total,
        #[inline(always)]
        |k| terms.get(k).copied(),
    );
    sum.divide(total)
}

/// The terms of the eigenvectors that `subspace` has, in the `order` of descending eigenvalues. `sums` holds the
/// cross-spectral metric up to each position of that order.
#[inline(always)]
pub(super) fn subspace_sum<V: Vector>(
    zero: V,
    subspace: Subspace,
    (sums, order): (&[V], &[V]),
    total: V,
    term: impl Fn(usize) -> Option<ComplexVector<V>>,
) -> ComplexVector<V> {
    let mut sum = ComplexVector::from_real(zero);
    // The metric before each position.
    let mut before = zero;
    for (position, (&index, &metric)) in order.iter().zip(sums).enumerate() {
        let kept = subspace.has(position, before, total);
        if kept.any() {
            let term = ComplexVector::new(
                gather(zero, |k| term(k).map(|term| term.re), index),
                gather(zero, |k| term(k).map(|term| term.im), index),
            );
            sum = ComplexVector::select(kept, sum + term, sum);
        } else if position > 0 {
            // The metric does not fall, so no later eigenvector is in the subspace.
            break;
        }
        before = metric;
    }
    sum
}

/// Orders each lane's eigenvalues: `order` gets their indices, largest first.
///
/// Equal ones keep their order. From the `metrics` `|e_kᴴa|²/λ_k`, `values` receives the cross-spectral metric (Eq.
/// 8) `c_j = Σ_{k≤j} |e_kᴴa|²/λ_k`. Returns `c_L`.
#[inline(always)]
pub(in crate::beamform) fn rank_order<V: Vector>(
    zero: V,
    values: &mut [V],
    metrics: &[V],
    order: &mut [V],
) -> V {
    sort(zero, values, order);
    accumulate(zero, metrics, order, values)
}

/// The cross-spectral metric up to each position of the `order`, into `sums`. Returns `c_L`.
#[inline(always)]
pub(super) fn accumulate<V: Vector>(zero: V, metrics: &[V], order: &[V], sums: &mut [V]) -> V {
    let mut total = zero;
    for (sum, &index) in sums.iter_mut().zip(order) {
        total = total + gather(zero, |k| metrics.get(k).copied(), index);
        *sum = total;
    }
    total
}

/// Sorts each lane's values, largest first, equal ones as they stood; `order` gets their indices.
#[inline(always)]
pub(super) fn sort<V: Vector>(zero: V, values: &mut [V], order: &mut [V]) {
    for (i, index) in order.iter_mut().enumerate() {
        *index = zero.splat(i as f32);
    }
    if V::LANES == 1 {
        insert(values, order);
    } else {
        merge(values, order);
    }
}

/// Sorts one lane by insertion.
///
/// At most `n²/2` comparisons, one for each value if they are sorted.
#[inline(always)]
fn insert<V: Vector>(values: &mut [V], order: &mut [V]) {
    for end in 2..=values.len() {
        let (Some(values), Some(order)) = (values.get_mut(..end), order.get_mut(..end)) else {
            return;
        };
        let mut slots = values.iter_mut().zip(order).rev();
        let Some((mut value_slot, mut index_slot)) = slots.next() else {
            return;
        };
        let (value, index) = (*value_slot, *index_slot);
        for (before, index_before) in slots {
            if !before.less(value).all() {
                break;
            }
            (*value_slot, *index_slot) = (*before, *index_before);
            (value_slot, index_slot) = (before, index_before);
        }
        (*value_slot, *index_slot) = (value, index);
    }
}

/// Sorts by merge exchange (Knuth, Algorithm 5.2.2M). Its comparisons, about `n·log²n/4`, do not depend on the data, so
/// that all lanes make the same ones.
#[inline(always)]
fn merge<V: Vector>(values: &mut [V], order: &mut [V]) {
    let n = values.len();
    let half = n.next_power_of_two() / 2;
    let mut p = half;
    while p > 0 {
        let (mut q, mut r, mut d) = (half, 0, p);
        loop {
            for (i, j) in (d..n).enumerate() {
                if i & p == r {
                    exchange(values, order, i, j);
                }
            }
            if q == p {
                break;
            }
            (d, q, r) = (q - p, q / 2, p);
        }
        p /= 2;
    }
}

/// Moves the larger of two values to `i`; of equal values, the one with the smaller index.
#[inline(always)]
fn exchange<V: Vector>(values: &mut [V], order: &mut [V], i: usize, j: usize) {
    let (Ok([a, b]), Ok([m, n])) = (
        values.get_disjoint_mut([i, j]),
        order.get_disjoint_mut([i, j]),
    ) else {
        return;
    };
    let swap = a.less(*b) | (!b.less(*a) & n.less(*m));
    (*a, *b) = (V::select(swap, *b, *a), V::select(swap, *a, *b));
    (*m, *n) = (V::select(swap, *n, *m), V::select(swap, *m, *n));
}

/// In each lane the number at its own index.
#[inline(always)]
fn gather<V: Vector>(zero: V, from: impl Fn(usize) -> Option<V>, index: V) -> V {
    let mut number = zero;
    let lanes = number.lanes_mut().iter_mut().zip(index.lanes());
    for (lane, (number, &index)) in lanes.enumerate() {
        if let Some(&from) = from(index as usize)
            .as_ref()
            .and_then(|x| x.lanes().get(lane))
        {
            *number = from;
        }
    }
    number
}

/// An eigenvalue, no smaller than the rounding error of the trace.
#[inline(always)]
pub(in crate::beamform) fn at_least_floor<V: Vector>(value: V) -> V {
    let floor = value.splat(FLOOR);
    V::select(floor.less(value), value, floor)
}

/// Selection of a subspace's eigenvectors.
#[derive(Clone, Copy, Debug)]
pub(in crate::beamform) enum Subspace {
    /// All eigenvectors: the weights of MV.
    All,
    /// The eigenvectors of this number of largest eigenvalues.
    Largest(usize),
    /// The eigenvectors of a fraction of the cross-spectral metric (Eq. 8).
    ///
    /// They belong to the largest eigenvalues that make up the fraction.
    CrossSpectral(f32),
    /// All eigenvectors but that of the largest eigenvalue.
    AllButLargest,
}

impl Subspace {
    /// The lanes in which the subspace has the eigenvector at a position of the descending order, given the
    /// cross-spectral metric of those before it, and that of all.
    #[inline(always)]
    pub(in crate::beamform) fn has<V: Vector>(
        self,
        position: usize,
        before: V,
        total: V,
    ) -> V::Mask {
        let all = total.mask(|_| true);
        match self {
            Subspace::All => all,
            Subspace::Largest(rank) if position < rank => all,
            Subspace::AllButLargest if position > 0 => all,
            // The first always, others only if those before are not enough.
            Subspace::CrossSpectral(_) if position == 0 => all,
            Subspace::CrossSpectral(beta) => before.less(total.splat(beta) * total),
            _ => !all,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first is included even if a fraction of the metric is too small for f32.
    #[test]
    fn a_share_has_the_first_eigenvector() {
        let least = f32::from_bits(1);
        for beta in [least, 0.5, 1.0] {
            for total in [0.0, least, 0.25, 1.0] {
                assert!(Subspace::CrossSpectral(beta).has(0, 0.0, total));
            }
        }
        // No other one is if the first is enough.
        assert!(!Subspace::CrossSpectral(least).has(1, 0.25, 0.25));
    }
}
