//! Two directions at a time, for one lane and subapertures of a constant length.
//!
//! Their solutions stay in registers, and each number of the factor is loaded once for both. The results are those of
//! `directions`, in the same order of operations.

use super::stage::{no_lane, stage};
use crate::beamform::workspace::{Directions, Solver};
use crate::linalg::cholesky::factorise;
use crate::linalg::matrix_vector::times_vector;
use crate::linalg::panels::{PanelColumn, TILE, panel};
use crate::linalg::size::Known;
use crate::simd::{ComplexVector, Scalar, Vector};

/// Entry `i` of both directions.
type Pair<S, const L: usize> = [[S; 2]; L];

/// Minimum variance in `sub_lines` directions, for subapertures of `L` in `C` columns of panels.
///
/// Returns the lanes in which `R` is not singular in f32.
#[inline(always)]
pub(super) fn mv<S: Scalar<V>, V: Vector, const L: usize, const C: usize>(
    zero: V,
    solver: &mut Solver<'_, S, V>,
    directions: &mut Directions<'_, S, V>,
    sub_lines: usize,
) -> V::Mask {
    stage(
        zero,
        solver,
        directions,
        #[inline(always)]
        move |solver, directions| {
            let definite = factor::<S, V, L>(zero, solver);
            let Some(g) = solver.factor.first_chunk::<C>() else {
                return no_lane(zero);
            };
            each_pair::<S, V, L>(
                directions,
                sub_lines,
                #[inline(always)]
                |steering, data| {
                    let mut rows = conjugate(zero, steering);
                    divide_forward(g, &mut rows);
                    let powers = powers(zero, &rows);
                    divide_backward(g, &mut rows);
                    let sums = products(zero, &rows, data);
                    [sums[0].divide(powers[0]), sums[1].divide(powers[1])]
                },
            );
            definite
        },
    )
}

/// Rank 1 in `sub_lines` directions, by the eigenvalue and the eigenvector in the solver's `vector`.
///
/// Returns the lanes in which `R` is not singular in f32.
#[inline(always)]
pub(super) fn rank1<S: Scalar<V>, V: Vector, const L: usize, const C: usize>(
    zero: V,
    eigenvalue: V,
    solver: &mut Solver<'_, S, V>,
    directions: &mut Directions<'_, S, V>,
    sub_lines: usize,
) -> V::Mask {
    let mut product = [S::from_real(zero); L];
    let Some(vector) = solver.vector.first_chunk::<L>() else {
        return no_lane(zero);
    };
    let (vector, tiles) = (*vector, product.as_chunks_mut().0);
    times_vector(solver.matrix, zero, vector.as_chunks().0, tiles);
    let definite = factor::<S, V, L>(zero, solver);
    let Some(g) = solver.factor.first_chunk::<C>() else {
        return no_lane(zero);
    };
    each_pair::<S, V, L>(
        directions,
        sub_lines,
        #[inline(always)]
        |steering, data| {
            let mut projections = [S::from_real(zero); 2];
            let mut echoes = [ComplexVector::from_real(zero); 2];
            for k in 0..L {
                for r in 0..2 {
                    projections[r] = projections[r] + steering[r][k].mul_conj(product[k]);
                    echoes[r] = echoes[r] + vector[k].conj_mul_complex(data[r][k]);
                }
            }
            let mut rows = conjugate(zero, steering);
            divide_forward(g, &mut rows);
            let powers = powers(zero, &rows);
            let answer = |r: usize| {
                let answer = projections[r].conj_mul_complex(echoes[r]);
                answer.divide(eigenvalue * eigenvalue * powers[r])
            };
            [answer(0), answer(1)]
        },
    );
    definite
}

/// Calls `answer` with steering vectors and data of two directions at a time.
#[inline(always)]
fn each_pair<S: Scalar<V>, V: Vector, const L: usize>(
    directions: &mut Directions<'_, S, V>,
    sub_lines: usize,
    answer: impl Fn(&[[S; L]; 2], &[[ComplexVector<V>; L]; 2]) -> [ComplexVector<V>; 2],
) {
    let (steering, _) = directions.steering.as_chunks::<L>();
    let (data, _) = directions.data.as_chunks::<L>();
    let (answers, _) = directions.answers.as_chunks_mut::<2>();
    let pairs = steering.as_chunks().0.iter().zip(data.as_chunks().0);
    for ((steering, data), answers) in pairs.zip(answers).take(sub_lines / 2) {
        *answers = answer(steering, data);
    }
}

/// The factor of the loaded covariance.
#[inline(always)]
fn factor<S: Scalar<V>, V: Vector, const L: usize>(
    zero: V,
    solver: &mut Solver<'_, S, V>,
) -> V::Mask {
    let mut none: [[S; 0]; L] = [[]; L];
    factorise(zero, solver.matrix, solver.factor, &mut none, Known::<L>)
}

#[inline(always)]
fn conjugate<S: Scalar<V>, V: Vector, const L: usize>(
    zero: V,
    steering: &[[S; L]; 2],
) -> Pair<S, L> {
    let mut rows = [[S::from_real(zero); 2]; L];
    for k in 0..L {
        rows[k] = [steering[0][k].conj(), steering[1][k].conj()];
    }
    rows
}

/// `G(i, k)`.
#[inline(always)]
fn entry<S: Copy, const C: usize>(g: &[PanelColumn<S>; C], i: usize, k: usize) -> S {
    g[panel(i / TILE) + k][i % TILE]
}

#[inline(always)]
fn divide_forward<S: Scalar<V>, V: Vector, const L: usize, const C: usize>(
    g: &[PanelColumn<S>; C],
    rows: &mut Pair<S, L>,
) {
    for i in 0..L {
        for k in 0..i {
            let factor = entry(g, i, k);
            for r in 0..2 {
                rows[i][r] = rows[i][r] - rows[k][r].mul_conj(factor);
            }
        }
        let inverse = entry(g, i, i).real();
        rows[i] = [rows[i][0].scale(inverse), rows[i][1].scale(inverse)];
    }
}

#[inline(always)]
fn divide_backward<S: Scalar<V>, V: Vector, const L: usize, const C: usize>(
    g: &[PanelColumn<S>; C],
    rows: &mut Pair<S, L>,
) {
    for i in (0..L).rev() {
        for k in (i + 1..L).rev() {
            let factor = entry(g, k, i);
            for r in 0..2 {
                rows[i][r] = rows[i][r] - rows[k][r].mul(factor);
            }
        }
        let inverse = entry(g, i, i).real();
        rows[i] = [rows[i][0].scale(inverse), rows[i][1].scale(inverse)];
    }
}

/// `‖G⁻¹a‖²`, ascending from zero.
#[inline(always)]
fn powers<S: Scalar<V>, V: Vector, const L: usize>(zero: V, rows: &Pair<S, L>) -> [V; 2] {
    let mut sums = [zero; 2];
    for row in rows {
        sums = [sums[0] + row[0].norm_sqr(), sums[1] + row[1].norm_sqr()];
    }
    sums
}

/// `uᴴs`, ascending from zero, of the rows `u*`.
#[inline(always)]
fn products<S: Scalar<V>, V: Vector, const L: usize>(
    zero: V,
    rows: &Pair<S, L>,
    data: &[[ComplexVector<V>; L]; 2],
) -> [ComplexVector<V>; 2] {
    let mut sums = [ComplexVector::from_real(zero); 2];
    for k in 0..L {
        for r in 0..2 {
            sums[r] = sums[r] + rows[k][r].mul_complex(data[r][k]);
        }
    }
    sums
}
