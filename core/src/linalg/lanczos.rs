//! Lanczos iteration: the largest eigenvalue and its eigenvector (the rank-1 signal subspace), where
//! few steps lead there and prove it.
//!
//! - **Start**: the unit vector of coordinate 0 or 1, whichever has the larger diagonal entry, so that
//!   the first product is a column of the matrix. (Forward-backward's first two coordinates are one
//!   pair of elements; no wave is absent from both.) All later basis vectors are zero there.
//! - **Step**: `(A − s)·v` loses its components along all basis vectors so far; the rest is the next
//!   basis vector. The shift `s`, the mean of the eigenvalues besides the largest as far as that is
//!   known, changes nothing but what rounds away. The matrix in that basis is tridiagonal; its largest
//!   eigenvalue `θ` with the eigenvector `y` approaches `λ₁`, much faster than the power iteration does.
//! - **Gap**: no other eigenvalue is nearer to `θ` than `2θ − tr A` where that is positive, since `θ` is
//!   then more than all others together can be; elsewhere, with the mean `μ`, than
//!   `(θ − μ) − √(‖A − μ‖² − (θ − μ)²)`, from the sum of all squares.
//! - **Stop**: the error of `e₁` is at most the residual `‖A·e − θ·e‖` over the gap: a lane is done
//!   when this is [`ACCURACY`]. The residual is the next basis vector's length times the last entry of
//!   `y`, and what rounding can add to it: the row of `T` that `y` leaves open, and, for each entry of
//!   `y`, what is left of the other vectors in its own. That is rounding errors of what was subtracted,
//!   so where little was left of a product, its vector may only count for little.
//! - **Limit**: a lane without a gap is left at once, any other after [`step_limit`] steps or where its
//!   basis ends: [`dominant_eigenpair`](super::dominant_eigenpair) serves those.

use super::gap::{gap_by_squares, squared_deviations};
use super::inner_product::inner_product;
use super::largest_pair::Tridiagonal;
use super::matrix_vector::times_vector;
use super::panels::{Column, TILE, panel, trace};
use crate::simd::{Mask, Scalar, Vector};

/// The error of `e₁` at which a lane is done.
pub const ACCURACY: f32 = 2e-6;

/// The most steps that are ever taken.
pub const STEP_LIMIT: usize = 16;

/// The steps before it is looked whether a lane has a gap and is done.
const FIRST_LOOK: usize = 2;

/// A lane that seems so many times farther from done than it may be is not looked at.
const FAR: f32 = 8.0;

/// A basis vector shorter than this share of the eigenvalue is made of rounding errors.
const EXHAUSTED: f32 = 1e-6;

/// What is left of the other vectors in a basis vector that is as long as what was subtracted: a
/// rounding error or two.
const ROUNDING: f32 = 1e-7;

/// The share of the gap below which a step towards `θ` is the last.
const LAST_STEP: f32 = 1e-3;

/// The most steps on a matrix of `n` rows: up to about the cost of [`dominant_eigenpair`](super::dominant_eigenpair).
pub const fn step_limit(n: usize) -> usize {
    match n {
        0..8 => n,
        8..32 => 8,
        32..64 => n / 4,
        _ => STEP_LIMIT,
    }
}

/// Iterates on the matrix `a` of `n` rows.
///
/// Leaves the unit eigenvector in `vector` and returns its eigenvalue and the lanes that are done;
/// those in `ignored` are none of them. `vector` is as long as the panels have rows; `basis` holds
/// that many numbers for each step there can be, and `kept` one. A lane that is done or left does not
/// change any more, so its bits do not depend on the other lanes.
///
/// Cost of step `k` but the first: `2n²` flops real, `8n²` complex for the product, `4nk` (`16nk`) for
/// the projections.
#[inline(always)]
pub fn lanczos<S: Scalar<V>, V: Vector>(
    a: &[Column<S>],
    n: usize,
    basis: &mut [Column<S>],
    vector: &mut [Column<S>],
    tridiagonal: &mut Tridiagonal<'_, V>,
    kept: &mut [V],
    ignored: V::Mask,
) -> (V, V::Mask) {
    let zero = a[0][0].real().zero();
    let one = zero.splat(1.0);
    let tiles = vector.len();
    let steps = step_limit(n);
    let kept = &mut kept[..steps];
    kept.fill(zero);
    let never = ignored & !ignored;
    let trace = trace(a, n);
    let mean = trace / zero.splat(n as f32);
    let mut squares = None;
    let second = if n == 1 {
        never
    } else {
        a[0][0].real().less(a[1][1].real())
    };
    let mut done = never;
    // The lanes in which the iteration goes on.
    let mut open = !ignored;
    let mut eigenvalue = zero;
    let mut bound = V::select(second, a[1][1].real(), a[0][0].real());
    let mut shift = zero;
    // The last entry of y over the first, at least.
    let mut last = one;
    let mut reciprocals = [zero; STEP_LIMIT];
    let mut errors = [zero; STEP_LIMIT];
    let mut components = [S::from_real(zero); STEP_LIMIT];
    let mut stored = 0;
    for k in 0..steps {
        if k == 0 {
            tridiagonal.diagonal[0] = bound;
            first_column(a, second, vector);
        } else {
            let basis = &basis[..k * tiles];
            let components = &mut components[..k];
            let along = if V::LANES == 1 {
                step_apart(a, shift, basis, second, vector, components)
            } else {
                step(a, shift, basis, second, vector, components)
            };
            tridiagonal.diagonal[k] = along + shift;
            bound = tridiagonal.upper_bound(k + 1, bound);
            // The ratio to the entry before is at least that.
            last = last * (tridiagonal.off_diagonal[k - 1] / (bound - tridiagonal.diagonal[k]));
        }
        let beta = inner_product(vector, vector).real().sqrt();
        tridiagonal.off_diagonal[k] = beta;
        let longer = (zero.splat(EXHAUSTED) * bound).less(beta);
        let end = k + 1 == steps;
        // A basis ends where it ends.
        let watched = if k + 1 >= FIRST_LOOK || end {
            open
        } else {
            open & !longer
        };
        if watched.any() {
            let mut gap = (bound + bound) - trace;
            let certain = zero.less(gap);
            if (watched & !certain).any() {
                let squares = *squares.get_or_insert_with(
                    #[inline(always)]
                    || squared_deviations(a, n, mean),
                );
                gap = V::select(certain, gap, gap_by_squares(squares, bound - mean));
            }
            open = open & (!watched | zero.less(gap));
            let mut due = watched & open;
            if !end {
                let far = (zero.splat(FAR * ACCURACY) * bound).less(beta * last);
                due = due & !(far & longer);
            }
            if due.any() {
                let enough = zero.splat(LAST_STEP) * gap;
                bound = tridiagonal.largest(k + 1, bound, enough, due);
                let open_row = tridiagonal.eigenvector_upwards(k + 1, bound, &reciprocals[..k]);
                let y = &tridiagonal.eigenvector[..=k];
                let mut residual = beta * y[k] + open_row;
                for (&error, &y) in errors[..k].iter().zip(&y[1..]) {
                    residual = residual + error * y;
                }
                // A NaN is not below it.
                let arrived = due & residual.less(zero.splat(ACCURACY) * gap);
                for (kept, &y) in kept.iter_mut().zip(y) {
                    *kept = V::select(arrived, y, *kept);
                }
                eigenvalue = V::select(arrived, bound, eigenvalue);
                done = done | arrived;
                open = open & !arrived;
            }
            open = open & longer;
        }
        if !open.any() {
            break;
        }
        if k + 1 < steps {
            let reciprocal = V::select(longer, one / V::select(longer, beta, one), zero);
            for (next, rest) in basis[k * tiles..][..tiles].iter_mut().zip(&*vector) {
                for r in 0..TILE {
                    next[r] = rest[r].scale(reciprocal);
                }
            }
            stored = k + 1;
            if k > 0 {
                let lost =
                    (tridiagonal.diagonal[k] - shift).abs() + tridiagonal.off_diagonal[k - 1];
                errors[k] = (zero.splat(ROUNDING) * trace) * (lost * reciprocal);
            }
            reciprocals[k] = reciprocal;
            shift = (trace - bound) / zero.splat((n - 1) as f32);
        }
    }
    if done.any() {
        combine(&basis[..stored * tiles], kept, second, vector);
    }
    (eigenvalue, done)
}

/// The first column, in the lanes of `second` the second, but for its diagonal entry.
#[inline(always)]
fn first_column<S: Scalar<V>, V: Vector>(a: &[Column<S>], second: V::Mask, w: &mut [Column<S>]) {
    for (i, w) in w.iter_mut().enumerate() {
        let columns = &a[panel(i)..panel(i) + 2];
        for r in 0..TILE {
            w[r] = S::select(second, columns[1][r], columns[0][r]);
        }
    }
    clear(w, second);
}

/// Clears the entry that the start vector has.
#[inline(always)]
fn clear<S: Scalar<V>, V: Vector>(w: &mut [Column<S>], second: V::Mask) {
    let zero = S::from_real(w[0][0].real().zero());
    w[0][0] = S::select(second, w[0][0], zero);
    w[0][1] = S::select(second, zero, w[0][1]);
}

/// `(A − shift)·v` of the last basis vector without its components along all of them and the start
/// vector; returns the one along the last.
#[inline(always)]
fn step<S: Scalar<V>, V: Vector>(
    a: &[Column<S>],
    shift: V,
    basis: &[Column<S>],
    second: V::Mask,
    w: &mut [Column<S>],
    components: &mut [S],
) -> V {
    times_vector(a, shift, &basis[basis.len() - w.len()..], w);
    clear(w, second);
    orthogonalise(basis, w, components);
    components[components.len() - 1].real()
}

/// [`step`] as a function of its own, with a microcontroller's few registers to itself. Its arguments
/// are its own, too: through a closure they take 4 % of rank 1's instructions at M/L = 16/8.
#[inline(never)]
fn step_apart<S: Scalar<V>, V: Vector>(
    a: &[Column<S>],
    shift: V,
    basis: &[Column<S>],
    second: V::Mask,
    w: &mut [Column<S>],
    components: &mut [S],
) -> V {
    step(a, shift, basis, second, w, components)
}

/// Takes from `w` its components `h_i = v_iᴴw` along the basis vectors, all found before the first
/// is taken, `i` ascending.
#[inline(always)]
fn orthogonalise<S: Scalar<V>, V: Vector>(
    basis: &[Column<S>],
    w: &mut [Column<S>],
    components: &mut [S],
) {
    let tiles = w.len();
    for (component, v) in components.iter_mut().zip(basis.chunks_exact(tiles)) {
        *component = inner_product(v, w);
    }
    for (i, w) in w.iter_mut().enumerate() {
        let mut rest = *w;
        for (&component, v) in components.iter().zip(basis.chunks_exact(tiles)) {
            for r in 0..TILE {
                rest[r] = rest[r] - v[i][r].mul(component);
            }
        }
        *w = rest;
    }
}

/// `Σ_k v_k·y_k`, `k` ascending from zero; the start vector's share is its entry.
#[inline(always)]
fn combine<S: Scalar<V>, V: Vector>(
    basis: &[Column<S>],
    kept: &[V],
    second: V::Mask,
    vector: &mut [Column<S>],
) {
    let zero = kept[0].zero();
    let tiles = vector.len();
    for (i, vector) in vector.iter_mut().enumerate() {
        let mut sums = [S::from_real(zero); TILE];
        for (&y, v) in kept[1..].iter().zip(basis.chunks_exact(tiles)) {
            for r in 0..TILE {
                sums[r] = sums[r] + v[i][r].scale(y);
            }
        }
        *vector = sums;
    }
    let first = S::from_real(kept[0]);
    vector[0][0] = S::select(second, vector[0][0], first);
    vector[0][1] = S::select(second, first, vector[0][1]);
}
