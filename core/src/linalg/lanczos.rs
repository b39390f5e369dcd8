//! Lanczos iteration for the largest eigenvalue and its eigenvector.
//!
//! It gives the rank-1 signal subspace if few steps converge and prove it.
//!
//! - **Start**: the unit vector of coordinate 0 or 1 with the larger diagonal entry, so that the first product is a
//!   column of the matrix. (Forward-backward's first two coordinates are one pair of elements; no wave is absent
//!   from both.) All later basis vectors are zero at that coordinate.
//! - **Step**: `(A − s)·v` is orthogonalised against all basis vectors; the remainder is the next basis vector. The
//!   shift `s` is an estimate of the mean of the other eigenvalues; it changes rounding errors only. The matrix in
//!   that basis is tridiagonal. Its largest eigenvalue `θ` with the eigenvector `y` approaches `λ₁`, much faster
//!   than power iteration.
//! - **Gap**: no other eigenvalue is nearer to `θ` than `2θ − tr A` if that is positive, since `θ` is then more
//!   than the sum of all others. Otherwise the bound is `(θ − μ) − √(‖A − μ‖² − (θ − μ)²)` with the mean `μ`, from
//!   the sum of all squares.
//! - **Stop**: the error of `e₁` is at most the residual `‖A·e − θ·e‖` over the gap. A lane is done if this is at
//!   most [`ACCURACY`]. The residual is the length of the next basis vector times the last entry of `y`, plus
//!   bounds of rounding errors: of the row of `T` that `y` does not solve, and, for each entry of `y`, of the
//!   components along other basis vectors that remain in its own. These components are rounding errors of the
//!   subtracted vectors. A product with a small remainder therefore gives its vector only a small weight.
//! - **Limit**: a lane without a gap stops at once, any other after [`step_limit`] steps or at the end of its
//!   basis. Those lanes use [`dominant_eigenpair`](super::dominant_eigenpair).

use super::gap::{gap_by_squares, squared_deviations};
use super::inner_product::inner_product;
use super::matrix_vector::times_vector;
use super::panels::{PanelColumn, TILE, panel, trace};
use super::size::Size;
use super::tridiagonal::Tridiagonal;
use crate::simd::{Mask, Scalar, Vector, get, get_mut};

/// Error of `e₁` at which a lane is done.
pub const ACCURACY: f32 = 2e-6;

/// Maximum number of steps.
pub const STEP_LIMIT: usize = 16;

/// Number of steps before a lane is checked for a gap and for convergence.
const FIRST_LOOK: usize = 2;

/// Ratio of error to accuracy above which a lane is not checked.
const FAR: f32 = 8.0;

/// A basis vector shorter than this fraction of the eigenvalue is made of rounding errors.
const EXHAUSTED: f32 = 1e-6;

/// Components along other vectors in a basis vector, relative to the subtracted length.
///
/// They are one or two rounding errors.
const ROUNDING: f32 = 1e-7;

/// The fraction of the gap below which a step towards `θ` is the last.
const LAST_STEP: f32 = 1e-3;

/// Maximum number of steps on a matrix of `n` rows.
///
/// About the cost of [`dominant_eigenpair`](super::dominant_eigenpair).
pub const fn step_limit(n: usize) -> usize {
    match n {
        0..8 => n,
        8..32 => 8,
        32..64 => n / 4,
        _ => STEP_LIMIT,
    }
}

/// Workspace of the iteration, and its eigenvector.
pub struct Memory<'a, 't, S, V> {
    /// Basis vectors, each as long as the panels have rows, for each possible step.
    pub basis: &'a mut [PanelColumn<S>],
    /// Work vector as long as the panels have rows; finally the unit eigenvector.
    pub vector: &'a mut [PanelColumn<S>],
    /// The matrix in the basis.
    pub tridiagonal: &'a mut Tridiagonal<'t, V>,
    /// The eigenvector in the basis, a number for each step.
    pub kept: &'a mut [V],
}

/// Iterates on the matrix `a` of `n` rows.
///
/// Leaves the unit eigenvector in the memory's `vector`. Returns its eigenvalue and the lanes that are done,
/// without those in `ignored`. A lane that is done or has stopped does not change any more, so its bits do not
/// depend on other lanes. `STEPS` is at least the [`step_limit`].
///
/// Cost of step `k` but the first: `2n²` flops real, `8n²` complex for the product, `4nk` (`16nk`) for the
/// projections.
#[inline(always)]
pub fn lanczos<S: Scalar<V>, V: Vector, const STEPS: usize>(
    zero: V,
    a: &[PanelColumn<S>],
    n: impl Size,
    memory: Memory<'_, '_, S, V>,
    ignored: V::Mask,
) -> (V, V::Mask) {
    let Memory {
        basis,
        vector,
        tridiagonal,
        kept,
    } = memory;
    let vector = n.front_mut(vector, n.get().div_ceil(TILE));
    let vector = vector.unwrap_or_default();
    let one = zero.splat(1.0);
    let size = n;
    let n = n.get();
    let tiles = vector.len();
    let steps = step_limit(n);
    let never = ignored & !ignored;
    let (Some(kept), Some(first), Some(next)) = (
        get_mut::<V, _, _>(kept, ..steps),
        get::<V, _, _>(a, 0),
        get::<V, _, _>(a, 1),
    ) else {
        return (zero, never);
    };
    kept.fill(zero);
    let trace = trace(zero, a, n);
    let mut gap_bound = GapBound::new(trace, n);
    let second = if n == 1 {
        never
    } else {
        first[0].real().less(next[1].real())
    };
    let mut done = never;
    // The lanes in which the iteration continues.
    let mut open = !ignored;
    let mut eigenvalue = zero;
    let mut bound = V::select(second, next[1].real(), first[0].real());
    let mut shift = zero;
    // The last entry of y over the first, at least.
    let mut last = one;
    let mut reciprocals = [zero; STEPS];
    let mut errors = [zero; STEPS];
    let mut components = [S::from_real(zero); STEPS];
    let mut stored = 0;
    for k in 0..steps {
        if k == 0 {
            put::<V, _>(tridiagonal.diagonal, 0, bound);
            first_column(a, second, vector);
        } else {
            let (Some(basis), Some(components)) = (
                get::<V, _, _>(basis, ..k * tiles),
                get_mut::<V, _, _>(&mut components, ..k),
            ) else {
                break;
            };
            let along = if V::LANES == 1 {
                step_apart((a, size), shift, basis, second, vector, components)
            } else {
                step((a, size), shift, basis, second, vector, components)
            };
            put::<V, _>(tridiagonal.diagonal, k, along + shift);
            bound = tridiagonal.upper_bound(k + 1, bound);
            let Some((entry, coupling)) = row(tridiagonal, k) else {
                break;
            };
            // The ratio to the entry before is at least that.
            last = last * (coupling / (bound - entry));
        }
        let beta = inner_product(zero, vector, vector).real().sqrt();
        put::<V, _>(tridiagonal.off_diagonal, k, beta);
        let longer = (zero.splat(EXHAUSTED) * bound).less(beta);
        let end = k + 1 == steps;
        // The last vector of a basis is always checked.
        let watched = if k + 1 >= FIRST_LOOK || end {
            open
        } else {
            open & !longer
        };
        if watched.any() {
            let gap = gap_bound.at(a, n, bound, watched);
            open = open & (!watched | zero.less(gap));
            let mut due = watched & open;
            if !end {
                let far = (zero.splat(FAR * ACCURACY) * bound).less(beta * last);
                due = due & !(far & longer);
            }
            if due.any() {
                bound = tridiagonal.largest(k + 1, bound, zero.splat(LAST_STEP) * gap, due);
                let (Some(known), Some(errors)) = (
                    get::<V, _, _>(&reciprocals, ..k),
                    get::<V, _, _>(&errors, ..k),
                ) else {
                    break;
                };
                let residual = residual(tridiagonal, bound, known, errors);
                // A NaN is not below it.
                let arrived = due & residual.less(zero.splat(ACCURACY) * gap);
                let Some(y) = get::<V, _, _>(tridiagonal.eigenvector, ..=k) else {
                    break;
                };
                if arrived.any() {
                    for (kept, &y) in kept.iter_mut().zip(y) {
                        *kept = V::select(arrived, y, *kept);
                    }
                    eigenvalue = V::select(arrived, bound, eigenvalue);
                    done = done | arrived;
                    open = open & !arrived;
                }
            }
            open = open & longer;
        }
        if !open.any() {
            break;
        }
        if !end {
            let reciprocal = V::select(longer, one / V::select(longer, beta, one), zero);
            let Some(next) = get_mut::<V, _, _>(basis, k * tiles..) else {
                break;
            };
            let Some(next) = get_mut::<V, _, _>(next, ..tiles) else {
                break;
            };
            scale(vector, reciprocal, next);
            stored = k + 1;
            if k > 0 {
                let Some((entry, coupling)) = row(tridiagonal, k) else {
                    break;
                };
                let lost = (entry - shift).abs() + coupling;
                let error = (zero.splat(ROUNDING) * trace) * (lost * reciprocal);
                put::<V, _>(&mut errors, k, error);
            }
            put::<V, _>(&mut reciprocals, k, reciprocal);
            shift = (trace - bound) / zero.splat((n - 1) as f32);
        }
    }
    if done.any()
        && let Some(basis) = get::<V, _, _>(basis, ..stored * tiles)
    {
        combine(basis, kept, second, vector);
    }
    (eigenvalue, done)
}

/// Sets `values[index]`; the basis has no more vectors than fit, so `index` is in bounds.
#[inline(always)]
fn put<V: Vector, T>(values: &mut [T], index: usize, value: T) {
    if let Some(slot) = get_mut::<V, _, _>(values, index) {
        *slot = value;
    }
}

/// The diagonal entry of row `k`, and its coupling to the row before.
#[inline(always)]
fn row<V: Vector>(tridiagonal: &Tridiagonal<'_, V>, k: usize) -> Option<(V, V)> {
    let coupling = get::<V, _, _>(tridiagonal.off_diagonal, k.wrapping_sub(1))?;
    let entry = get::<V, _, _>(tridiagonal.diagonal, k)?;
    Some((*entry, *coupling))
}

/// Lower bound of the gap below the largest eigenvalue.
///
/// See the module's documentation.
struct GapBound<V> {
    trace: V,
    mean: V,
    /// `‖A − μ‖²`, after its first use.
    squares: Option<V>,
}

impl<V: Vector> GapBound<V> {
    #[inline(always)]
    fn new(trace: V, n: usize) -> Self {
        GapBound {
            trace,
            mean: trace / trace.splat(n as f32),
            squares: None,
        }
    }

    /// The gap below an eigenvalue `theta`, in the lanes of `watched`.
    #[inline(always)]
    fn at<S: Scalar<V>>(
        &mut self,
        a: &[PanelColumn<S>],
        n: usize,
        theta: V,
        watched: V::Mask,
    ) -> V {
        let gap = (theta + theta) - self.trace;
        let certain = theta.zero().less(gap);
        if !(watched & !certain).any() {
            return gap;
        }
        let mean = self.mean;
        let squares = *self.squares.get_or_insert_with(
            #[inline(always)]
            || squared_deviations(a, n, mean),
        );
        V::select(certain, gap, gap_by_squares(squares, theta - mean))
    }
}

/// Stores the tridiagonal matrix's eigenvector `y` to `theta`.
///
/// Returns an upper bound of `‖A·e − θ·e‖`.
#[inline(always)]
fn residual<V: Vector>(
    tridiagonal: &mut Tridiagonal<'_, V>,
    theta: V,
    reciprocals: &[V],
    errors: &[V],
) -> V {
    let k = reciprocals.len();
    let open_row = tridiagonal.eigenvector_upwards(k + 1, theta, reciprocals);
    let (Some(&next), Some(&last), Some(behind)) = (
        get::<V, _, _>(tridiagonal.off_diagonal, k),
        get::<V, _, _>(tridiagonal.eigenvector, k),
        get::<V, _, _>(tridiagonal.eigenvector, 1..=k),
    ) else {
        return open_row;
    };
    let mut residual = next * last + open_row;
    for (&error, &y) in errors.iter().zip(behind) {
        residual = residual + error * y;
    }
    residual
}

/// The next basis vector: the remainder of the product, scaled to length 1.
#[inline(always)]
fn scale<S: Scalar<V>, V: Vector>(
    rest: &[PanelColumn<S>],
    reciprocal: V,
    next: &mut [PanelColumn<S>],
) {
    for (next, rest) in next.iter_mut().zip(rest) {
        for r in 0..TILE {
            next[r] = rest[r].scale(reciprocal);
        }
    }
}

/// The first column, or in the lanes of `second` the second, less its diagonal.
#[inline(always)]
fn first_column<S: Scalar<V>, V: Vector>(
    a: &[PanelColumn<S>],
    second: V::Mask,
    w: &mut [PanelColumn<S>],
) {
    for (i, w) in w.iter_mut().enumerate() {
        let Some([first, next]) = get::<V, _, _>(a, panel(i)..panel(i) + 2) else {
            break;
        };
        for r in 0..TILE {
            w[r] = S::select(second, next[r], first[r]);
        }
    }
    clear(w, second);
}

/// Clears the entry that the start vector has.
#[inline(always)]
fn clear<S: Scalar<V>, V: Vector>(w: &mut [PanelColumn<S>], second: V::Mask) {
    if let Some([first, next, ..]) = get_mut::<V, _, _>(w, 0) {
        let zero = S::from_real(first.real().zero());
        *first = S::select(second, *first, zero);
        *next = S::select(second, zero, *next);
    }
}

/// `(A − shift)·v` of the last basis vector without its components along all of them and the start
/// vector; returns the one along the last.
#[inline(always)]
fn step<S: Scalar<V>, V: Vector>(
    (a, n): (&[PanelColumn<S>], impl Size),
    shift: V,
    basis: &[PanelColumn<S>],
    second: V::Mask,
    w: &mut [PanelColumn<S>],
    components: &mut [S],
) -> V {
    let newest = basis.len().wrapping_sub(w.len());
    let newest = get::<V, _, _>(basis, newest..);
    let Some(newest) = newest.and_then(|newest| n.front(newest, w.len())) else {
        return shift.zero();
    };
    times_vector(a, shift, newest, w);
    clear(w, second);
    orthogonalise(shift.zero(), basis, w, components);
    let last = components.len().wrapping_sub(1);
    get::<V, _, _>(components, last).map_or(shift.zero(), |along| along.real())
}

/// [`step`] as a function of its own, with a microcontroller's few registers to itself. Its arguments
/// are its own, too: through a closure they take 4 % of rank 1's instructions at M/L = 16/8.
#[inline(never)]
fn step_apart<S: Scalar<V>, V: Vector>(
    (a, n): (&[PanelColumn<S>], impl Size),
    shift: V,
    basis: &[PanelColumn<S>],
    second: V::Mask,
    w: &mut [PanelColumn<S>],
    components: &mut [S],
) -> V {
    let tiles = n.get().div_ceil(TILE);
    let (Some(a), Some(w)) = (n.front(a, panel(tiles)), n.front_mut(w, tiles)) else {
        return shift.zero();
    };
    step((a, n), shift, basis, second, w, components)
}

/// Subtracts from `w` its components `h_i = v_iᴴw` along the basis vectors.
///
/// All are computed before the first is subtracted, `i` ascending.
#[inline(always)]
fn orthogonalise<S: Scalar<V>, V: Vector>(
    zero: V,
    basis: &[PanelColumn<S>],
    w: &mut [PanelColumn<S>],
    components: &mut [S],
) {
    let tiles = w.len();
    if V::LANES == 1 && tiles == 0 {
        return;
    }
    for (component, v) in components.iter_mut().zip(basis.chunks_exact(tiles)) {
        *component = inner_product(zero, v, w);
    }
    for (i, w) in w.iter_mut().enumerate() {
        let mut rest = *w;
        for (&component, v) in components.iter().zip(basis.chunks_exact(tiles)) {
            let Some(v) = get::<V, _, _>(v, i) else {
                break;
            };
            for r in 0..TILE {
                rest[r] = rest[r] - v[r].mul(component);
            }
        }
        *w = rest;
    }
}

/// `Σ_k v_k·y_k`, `k` ascending from zero; the start vector's term is its entry.
#[inline(always)]
fn combine<S: Scalar<V>, V: Vector>(
    basis: &[PanelColumn<S>],
    kept: &[V],
    second: V::Mask,
    vector: &mut [PanelColumn<S>],
) {
    let Some((&start, kept)) = kept.split_first() else {
        return;
    };
    let zero = start.zero();
    let tiles = vector.len();
    if V::LANES == 1 && tiles == 0 {
        return;
    }
    for (i, vector) in vector.iter_mut().enumerate() {
        let mut sums = [S::from_real(zero); TILE];
        for (&y, v) in kept.iter().zip(basis.chunks_exact(tiles)) {
            let Some(v) = get::<V, _, _>(v, i) else {
                break;
            };
            for r in 0..TILE {
                sums[r] = sums[r] + v[r].scale(y);
            }
        }
        *vector = sums;
    }
    if let Some([first, next, ..]) = get_mut::<V, _, _>(vector, 0) {
        let start = S::from_real(start);
        *first = S::select(second, *first, start);
        *next = S::select(second, start, *next);
    }
}
