//! Eigenspace minimum variance (Eq. 5–8).

use crate::beamform::view::Solver;
use crate::covariance::Averaging;
use crate::linalg::FLOOR;
use crate::linalg::cholesky::factorise;
use crate::linalg::dominant_eigenpair::dominant_eigenpair;
use crate::linalg::eigen::eigen;
use crate::linalg::householder::Reduction;
use crate::linalg::inner_product::inner_product;
use crate::linalg::lanczos::{self, lanczos};
use crate::linalg::matrix_vector::times_vector;
use crate::linalg::panels::TILE;
use crate::simd::{ComplexVector, Mask, Scalar, Vector};

/// `w_pᴴs` with a signal subspace of rank 1, for the loaded covariance in the solver's panels.
///
/// With `λ₁` and `e₁` no back substitution is needed: `w_p = e₁(e₁ᴴa)/(λ₁·aᴴR⁻¹a)`, and
/// `aᴴR⁻¹a = ‖G⁻¹a‖²` from one forward solve. The Lanczos iteration serves the lanes where it arrives,
/// [`dominant_eigenpair`] the others but for the `silent` ones. Also returns the lanes that this is true of:
/// where `R` is singular in f32, the caller takes [`esmv`] instead.
///
/// `e₁ᴴa` is taken as `e₁ᴴ(R·a)/λ₁`. For an echo from aside its terms cancel, and an error of `e₁` would
/// count whole beside what they leave; so it counts `λ₂/λ₁` times at most, and the roundings of `R·a`,
/// each a share of an entry of `e₁`, average out.
///
/// Cost: those, one product of the matrix with a vector, and one factorisation with a row below it.
#[inline(always)]
pub(in crate::beamform) fn esmv_rank1<A: Averaging<V>, V: Vector>(
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: usize,
    s: &[ComplexVector<V>],
    silent: V::Mask,
) -> (ComplexVector<V>, V::Mask) {
    let zero = s[0].re.zero();
    let padded = subaperture.next_multiple_of(TILE);
    let vector = &mut solver.vector[..padded];
    let (tiles, _) = vector.as_chunks_mut();
    let (mut eigenvalue, arrived) = lanczos(
        solver.matrix,
        subaperture,
        lanczos::Memory {
            basis: solver.factor,
            vector: tiles,
            tridiagonal: &mut solver.tridiagonal,
            kept: solver.values,
        },
        silent,
    );
    let left = !(arrived | silent);
    if left.any() {
        let mut reduction = Reduction {
            panels: solver.factor,
            vectors: solver.rows.as_flattened_mut(),
            phases: solver.phases,
            tridiagonal: &mut solver.tridiagonal,
        };
        let value = zero.vectorize(
            #[inline(always)]
            || dominant_eigenpair(solver.matrix, subaperture, &mut reduction, left),
        );
        eigenvalue = V::select(left, value, eigenvalue);
        for (e, &direct) in vector.iter_mut().zip(&*reduction.vectors) {
            *e = A::Scalar::select(left, direct, *e);
        }
    }
    let mut product = ComplexVector::from_real(zero);
    for (&e, &s) in vector.iter().zip(s) {
        product = product + e.conj_mul_complex(s);
    }
    let steering = &mut solver.rows.as_flattened_mut()[..padded];
    for (i, entry) in steering[..subaperture].iter_mut().enumerate() {
        *entry = A::Scalar::from_real(zero.splat(A::steering(i, subaperture)));
    }
    steering[subaperture..].fill(A::Scalar::from_real(zero));
    let (vector, _) = vector.as_chunks();
    let turned = &mut solver.factor[..vector.len()];
    times_vector(solver.matrix, zero, steering.as_chunks().0, turned);
    let projection = inner_product(vector, turned);
    let (rows, _) = steering.as_chunks_mut();
    let definite = factorise::<_, _, 1>(solver.matrix, solver.factor, rows, padded / TILE);
    // ‖G⁻¹a‖², ascending from zero.
    let mut power = zero;
    for [y] in &rows[..subaperture] {
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
    subspace: Subspace,
    solver: &mut Solver<'_, A::Scalar, V>,
    subaperture: usize,
    s: &[ComplexVector<V>],
) -> ComplexVector<V> {
    let zero = s[0].re.zero();
    let Solver {
        matrix,
        factor,
        rows,
        phases,
        tridiagonal,
        values,
        work,
        ..
    } = solver;
    let (steering, data) = work.split_at_mut(work.len() / 2);
    let (steering, data) = (&mut steering[..subaperture], &mut data[..subaperture]);
    for (i, entry) in steering.iter_mut().enumerate() {
        *entry = ComplexVector::from_real(zero.splat(A::steering(i, subaperture)));
    }
    data.copy_from_slice(&s[..subaperture]);
    let mut reduction = Reduction {
        panels: factor,
        vectors: rows.as_flattened_mut(),
        phases,
        tridiagonal,
    };
    let vectors = [&mut *steering, &mut *data];
    eigen(matrix, subaperture, &mut reduction, values, vectors);
    let (shares, terms) = (steering, data);
    let values = &mut values[..subaperture];
    for ((share, term), &value) in shares.iter_mut().zip(&mut *terms).zip(&*values) {
        let value = at_least_floor(value);
        *term = share.conj_mul_complex(*term).divide(value);
        share.re = share.norm_sqr() / value;
    }
    let order = &mut tridiagonal.eigenvector[..subaperture];
    let total = rank_order(values, shares, order);
    let mut sum = ComplexVector::from_real(zero);
    for place in 0..subaperture {
        let kept = subspace.has(place, values, total);
        if kept.any() {
            let term = gather(terms, order[place]);
            sum = ComplexVector::select(kept, sum + term, sum);
        }
    }
    sum.divide(total)
}

/// Orders each lane's eigenvalues: `order` gets their indices, largest first, equal ones in the order
/// found. Of `shares`, whose real parts are `|e_kᴴa|²/λ_k`, `values` become the cross-spectral metric
/// (Eq. 8) `c_j = Σ_{k≤j} |e_kᴴa|²/λ_k`. Returns `c_L`.
#[inline(always)]
pub(in crate::beamform) fn rank_order<V: Vector>(
    values: &mut [V],
    shares: &[ComplexVector<V>],
    order: &mut [V],
) -> V {
    sort(values, order);
    let mut total = values[0].zero();
    for (sum, &index) in values.iter_mut().zip(&*order) {
        total = total + gather(shares, index).re;
        *sum = total;
    }
    total
}

/// Sorts each lane's values, largest first, equal ones as they stood; `order` gets their indices.
///
/// By merge exchange (Knuth, Algorithm 5.2.2M), whose comparisons do not depend on the data, so that all
/// lanes take the same ones. About `n·log²n/4` of them.
#[inline(always)]
fn sort<V: Vector>(values: &mut [V], order: &mut [V]) {
    let n = values.len();
    for (i, index) in order.iter_mut().enumerate() {
        *index = values[0].splat(i as f32);
    }
    let half = n.next_power_of_two() / 2;
    let mut p = half;
    while p > 0 {
        let (mut q, mut r, mut d) = (half, 0, p);
        loop {
            for i in 0..n - d {
                if i & p == r {
                    exchange(values, order, i, i + d);
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

/// Puts the larger of two values to `i`, of equal ones that with the smaller index.
#[inline(always)]
fn exchange<V: Vector>(values: &mut [V], order: &mut [V], i: usize, j: usize) {
    let (a, b) = (values[i], values[j]);
    let (m, n) = (order[i], order[j]);
    let swap = a.less(b) | (!b.less(a) & n.less(m));
    values[i] = V::select(swap, b, a);
    values[j] = V::select(swap, a, b);
    order[i] = V::select(swap, n, m);
    order[j] = V::select(swap, m, n);
}

/// In each lane the number at its own index.
#[inline(always)]
fn gather<V: Vector>(from: &[ComplexVector<V>], index: V) -> ComplexVector<V> {
    let mut number = from[0];
    for lane in 0..V::LANES {
        let from = from[index.lanes()[lane] as usize];
        number.re.lanes_mut()[lane] = from.re.lanes()[lane];
        number.im.lanes_mut()[lane] = from.im.lanes()[lane];
    }
    number
}

/// An eigenvalue, no smaller than the rounding error of the trace.
#[inline(always)]
pub(in crate::beamform) fn at_least_floor<V: Vector>(value: V) -> V {
    let floor = value.splat(FLOOR);
    V::select(floor.less(value), value, floor)
}

/// Which eigenvectors make up a subspace.
#[derive(Clone, Copy, Debug)]
pub(in crate::beamform) enum Subspace {
    /// All of them: the weights are those of MV.
    All,
    /// Those of so many of the largest eigenvalues.
    Largest(usize),
    /// Those of the largest eigenvalues that make up this share of the cross-spectral metric (Eq. 8).
    Share(f32),
    /// All but the largest eigenvalue's.
    AllButLargest,
}

impl Subspace {
    /// The lanes in which the subspace has the eigenvector at a place of the descending order, given the
    /// cross-spectral metric up to each place, and its total.
    #[inline(always)]
    pub(in crate::beamform) fn has<V: Vector>(
        self,
        place: usize,
        cumulative: &[V],
        total: V,
    ) -> V::Mask {
        let all = total.mask(|_| true);
        match self {
            Subspace::All => all,
            Subspace::Largest(rank) if place < rank => all,
            Subspace::AllButLargest if place > 0 => all,
            // The first always, another where those before it are not enough.
            Subspace::Share(_) if place == 0 => all,
            Subspace::Share(beta) => cumulative[place - 1].less(total.splat(beta) * total),
            _ => !all,
        }
    }
}
