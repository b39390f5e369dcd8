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
use num_complex::Complex;

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
        lane,
        values,
        work,
        order,
        cumulative,
        ..
    } = solver;
    let stride = work.len() / 2;
    let (steering, data) = work.split_at_mut(stride);
    for i in 0..subaperture {
        steering[i] = ComplexVector::from_real(zero.splat(A::steering(i, subaperture)));
        data[i] = s[i];
    }
    let mut reduction = Reduction {
        panels: factor,
        vectors: rows.as_flattened_mut(),
        phases,
        tridiagonal,
    };
    eigen(
        matrix,
        subaperture,
        &mut reduction,
        lane,
        values,
        work,
        stride,
    );
    let (steering, data) = work.split_at(stride);
    let mut z = ComplexVector::from_real(zero);
    for lane in 0..V::LANES {
        let mut sum = Complex::new(0.0f32, 0.0);
        let total = rank_order(&values[..subaperture], steering, lane, order, cumulative);
        for place in subspace.places(cumulative, total, subaperture) {
            let index = order[place];
            let a = steering[index].lane(lane);
            let x = data[index].lane(lane);
            let product = a.conj() * x;
            sum += product / at_least_floor(values[index].lanes()[lane]);
        }
        z.set_lane(lane, sum / total);
    }
    z
}

/// Orders one lane's eigenvalues: `order` gets their indices, largest first, equal ones in the order
/// found; `cumulative` the cross-spectral metric (Eq. 8) `c_j = Σ_{k≤j} |e_kᴴa|²/λ_k`, from the
/// projections `Eᴴa`. Returns `c_L`.
pub(in crate::beamform) fn rank_order<V: Vector>(
    values: &[V],
    steering: &[ComplexVector<V>],
    lane: usize,
    order: &mut [usize],
    cumulative: &mut [f32],
) -> f32 {
    for (i, value) in values.iter().enumerate() {
        let mut place = i;
        while place > 0 && values[order[place - 1]].lanes()[lane] < value.lanes()[lane] {
            order[place] = order[place - 1];
            place -= 1;
        }
        order[place] = i;
    }
    let mut total = 0.0;
    for (&index, sum) in order.iter().zip(cumulative).take(values.len()) {
        let projection = steering[index].lane(lane);
        total += projection.norm_sqr() / at_least_floor(values[index].lanes()[lane]);
        *sum = total;
    }
    total
}

/// An eigenvalue, no smaller than the rounding error of the trace.
pub(in crate::beamform) fn at_least_floor(value: f32) -> f32 {
    if value > FLOOR { value } else { FLOOR }
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
    /// The eigenvectors' places in the descending order of `n` eigenvalues, given the cross-spectral
    /// metric and its total.
    pub(in crate::beamform) fn places(
        self,
        cumulative: &[f32],
        total: f32,
        n: usize,
    ) -> core::ops::Range<usize> {
        match self {
            Subspace::All => 0..n,
            Subspace::Largest(rank) => 0..if rank < n { rank } else { n },
            Subspace::Share(beta) => {
                let threshold = beta * total;
                let mut rank = 1;
                while rank < n && cumulative[rank - 1] < threshold {
                    rank += 1;
                }
                0..rank
            }
            Subspace::AllButLargest => 1..n,
        }
    }
}
