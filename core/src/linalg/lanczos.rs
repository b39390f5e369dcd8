//! Lanczos iteration: the largest eigenvalue and its eigenvector (the rank-1 signal subspace).
//!
//! - **Start**: `v_i = 0.5 + frac((i+1)·0.618034)`, normalised; a fixed vector without symmetry.
//!   The steering vector would not do: in a few per cent of samples it is orthogonal to `e₁`.
//! - **Step**: `(A − tr A/n)·v` loses its components along all basis vectors so far, a second time where little
//!   is left of it (in f32 a basis that is kept orthogonal to the last two only, or once only, goes
//!   wrong as soon as `e₁` has been found); the rest is the next basis vector. The matrix in that
//!   basis is tridiagonal; its largest eigenvalue `θ` with the eigenvector `y` approaches `λ₁`, much
//!   faster than the power iteration does.
//! - **Stop**: where `θ` is more than all other eigenvalues together can be (`2θ > tr A`), none of
//!   them is nearer than `2θ − tr A`, and the error of `e₁` is at most the residual `‖A·e − θ·e‖`
//!   over that: a lane is done when this is [`ACCURACY`]. Any other is done where the residual is at
//!   most [`TOLERANCE`]·`θ` and [`LEAST_STEPS`] steps have been taken, in which even a component that
//!   only rounding has brought in would have grown, or `n`. A basis that is exhausted earlier proves
//!   nothing: the lane is given up.
//! - **Limit**: a lane that is not done after [`STEP_LIMIT`] steps says so, and its caller takes the
//!   full eigensolver, whose accuracy does not depend on the gap.

use super::panels::{Column, TILE, panel};
use crate::vector::{Mask, Scalar, Vector};

/// The residual at which a lane is done, of the eigenvalue: the error of `e₁` is at most that over
/// `1 − λ₂/λ₁`.
pub const TOLERANCE: f32 = 1e-6;

/// The most steps that are taken.
pub const STEP_LIMIT: usize = 48;

/// The fewest, unless the eigenvalue is certainly the largest.
pub const LEAST_STEPS: usize = 5;

/// The error of `e₁` at which a lane is done where the gap to the other eigenvalues is known.
pub const ACCURACY: f32 = 1e-5;

/// The steps before it is looked whether a lane is done.
const FIRST_LOOK: usize = 3;

/// The share of `‖A·v‖²` below which what is left has lost so many bits that it is orthogonalised
/// again.
const CANCELLATION: f32 = 0.1;

/// Beyond the first steps, how often it is looked whether a lane is done.
const INTERVAL: usize = 2;

/// The most steps from an upper bound to the largest eigenvalue; four are usual.
const LAGUERRE_STEPS: usize = 10;

/// The tridiagonal matrix in the basis, and its eigenvector: slices of [`STEP_LIMIT`] vectors, or of
/// as many as the matrix has rows.
pub struct Tridiagonal<'a, V> {
    diagonal: &'a mut [V],
    /// Entry `k` couples basis vectors `k` and `k + 1`.
    off_diagonal: &'a mut [V],
    /// The pivots of `θ − T`, first to last.
    falling: &'a mut [V],
    /// The eigenvector of the step at hand.
    eigenvector: &'a mut [V],
    /// The eigenvector of each lane's last step.
    coefficients: &'a mut [V],
}

impl<'a, V> Tridiagonal<'a, V> {
    /// The slices from memory for matrices of up to `L` rows.
    pub fn new<const L: usize>(memory: &'a mut [[V; L]; 5]) -> Self {
        let [diagonal, off_diagonal, falling, eigenvector, coefficients] = memory;
        Tridiagonal {
            diagonal,
            off_diagonal,
            falling,
            eigenvector,
            coefficients,
        }
    }
}

/// Iterates on the matrix `a` of `n` rows.
///
/// Leaves the unit eigenvector in `vector` and returns its eigenvalue and the lanes that are done.
/// `vector` is as long as the panels have rows; `basis` holds that many numbers for each step there
/// can be, `min(n, STEP_LIMIT)`. A lane that is done does not change any more, so its bits do not
/// depend on the other lanes.
///
/// Cost of step `k`: `2n²` flops real, `8n²` complex for the product, `4nk` (`16nk`) for the
/// projections, and `4k` divisions.
#[inline(always)]
pub fn lanczos<S: Scalar<V>, V: Vector>(
    a: &[Column<S>],
    n: usize,
    basis: &mut [S],
    vector: &mut [S],
    tridiagonal: &mut Tridiagonal<'_, V>,
) -> (V, V::Mask) {
    let zero = a[0][0].real().zero();
    let one = zero.splat(1.0);
    let rows = vector.len();
    let steps = if n < STEP_LIMIT { n } else { STEP_LIMIT };
    let mut trace = zero;
    for i in 0..n {
        trace = trace + a[panel(i / TILE) + i][i % TILE].real();
    }
    // What is subtracted here need not be orthogonalised away: where eigenvalues crowd around their
    // mean, little is left of A·v, and much of (A − mean)·v.
    let shift = trace / zero.splat(n as f32);
    start(n, zero, &mut basis[..rows]);
    let never = zero.mask(
        #[inline(always)]
        |_| false,
    );
    let mut done = never;
    // Where the basis had an end before this step.
    let mut spent = never;
    // Where that was seen without an arrival.
    let mut given_up = never;
    let mut eigenvalue = zero;
    let mut bound = zero;
    let mut components = [S::from_real(zero); STEP_LIMIT];
    for k in 0..steps {
        let (basis, next) = basis.split_at_mut((k + 1) * rows);
        times_vector(a, shift, &basis[k * rows..], vector);
        let before = norm_sqr::<S, V>(vector);
        tridiagonal.diagonal[k] = orthogonalise(basis, vector, &mut components, !never) + shift;
        let mut after = norm_sqr::<S, V>(vector);
        let again = after.less(before * zero.splat(CANCELLATION)) & !done;
        if again.any() {
            orthogonalise(basis, vector, &mut components, again);
            after = norm_sqr::<S, V>(vector);
        }
        let beta = after.sqrt();
        tridiagonal.off_diagonal[k] = beta;
        bound = tridiagonal.upper_bound(k, bound);
        let exhausted = beta.less(zero.splat(TOLERANCE) * bound);
        let look = k + 1 >= FIRST_LOOK && (k < LEAST_STEPS || k.is_multiple_of(INTERVAL));
        if look || k + 1 == steps {
            let (theta, step) = tridiagonal.largest(k, bound);
            bound = theta;
            let last = tridiagonal.eigenvector(k, theta);
            let certain = trace.less(theta + theta);
            let limit = zero.splat(TOLERANCE) * theta;
            let by_gap = zero.splat(ACCURACY) * ((theta + theta) - trace);
            let limit = V::select(limit.less(by_gap), by_gap, limit);
            // A NaN is not below it.
            let converged = (beta * last + step).less(limit);
            let searched = if k + 1 == n {
                !spent
            } else if k + 1 >= LEAST_STEPS {
                !spent & !exhausted
            } else {
                never
            };
            let arrived = converged & (certain | searched) & !done & !given_up;
            if arrived.any() {
                tridiagonal.keep(k, arrived);
                eigenvalue = V::select(arrived, theta, eigenvalue);
                done = done | arrived;
            }
            // Nothing is added to such a basis: a silent lane's identity, a lane without a run.
            given_up = given_up | (spent & !done);
            if (done | given_up).all() {
                break;
            }
        }
        spent = spent | exhausted;
        if k + 1 < steps {
            let reciprocal = V::select(exhausted, zero, one / V::select(exhausted, one, beta));
            for (next, &rest) in next.iter_mut().zip(&*vector) {
                *next = rest.scale(reciprocal);
            }
        }
    }
    combine(basis, &tridiagonal.coefficients[..steps], done, vector);
    (eigenvalue, done)
}

/// The start vector, of length 1; zero in the rows that fill up the last panel.
#[inline(always)]
fn start<S: Scalar<V>, V: Vector>(n: usize, zero: V, v: &mut [S]) {
    let mut fraction = 0.0f32;
    let mut sum = 0.0f32;
    let (entries, rest) = v.split_at_mut(n);
    for entry in entries.iter_mut() {
        fraction = next_fraction(fraction);
        let value = 0.5 + fraction;
        sum += value * value;
        *entry = S::from_real(zero.splat(value));
    }
    let reciprocal = zero.splat(1.0 / Vector::sqrt(sum));
    for entry in entries {
        *entry = entry.scale(reciprocal);
    }
    rest.fill(S::from_real(zero));
}

/// `frac(fraction + 0.618034)`: the golden ratio spreads the entries without a pattern.
#[inline(always)]
fn next_fraction(fraction: f32) -> f32 {
    let next = fraction + 0.618_034;
    if next >= 1.0 { next - 1.0 } else { next }
}

/// `y = A·v`, each entry summed from zero over ascending columns.
///
/// Each column of a panel serves twice while it is in registers: for its own rows and, mirrored,
/// for the row of its own index.
#[inline(always)]
fn times_vector<S: Scalar<V>, V: Vector>(a: &[Column<S>], shift: V, v: &[S], y: &mut [S]) {
    for (i, own) in v.as_chunks::<TILE>().0.iter().enumerate() {
        let (before, diagonal) = a[panel(i)..panel(i + 1)].split_at(TILE * i);
        let mut sums = own.map(
            #[inline(always)]
            |v| v.scale(-shift),
        );
        for ((column, &v), y) in before.iter().zip(v).zip(y.iter_mut()) {
            let mut mirrored = *y;
            for r in 0..TILE {
                sums[r] = sums[r] + column[r].mul(v);
                mirrored = mirrored + own[r].mul_conj(column[r]);
            }
            *y = mirrored;
        }
        for (column, &v) in diagonal.iter().zip(own) {
            for r in 0..TILE {
                sums[r] = sums[r] + column[r].mul(v);
            }
        }
        y[TILE * i..TILE * (i + 1)].copy_from_slice(&sums);
    }
}

/// Takes from `w` its components `h_i = v_iᴴw` along the basis vectors, all found before the first
/// is taken, `i` ascending, in the lanes of `which`. Returns the real part of the last one.
#[inline(always)]
fn orthogonalise<S: Scalar<V>, V: Vector>(
    basis: &[S],
    w: &mut [S],
    components: &mut [S; STEP_LIMIT],
    which: V::Mask,
) -> V {
    // Four at a time: their sums, each one chain of additions, go side by side.
    const SIDE_BY_SIDE: usize = 4;
    let count = basis.len() / w.len();
    let whole = count - count % SIDE_BY_SIDE;
    for i in (0..whole).step_by(SIDE_BY_SIDE) {
        project::<S, V, SIDE_BY_SIDE>(basis, i, w, components);
    }
    for i in whole..count {
        project::<S, V, 1>(basis, i, w, components);
    }
    for i in (0..whole).step_by(SIDE_BY_SIDE) {
        subtract::<S, V, SIDE_BY_SIDE>(basis, i, w, components, which);
    }
    for i in whole..count {
        subtract::<S, V, 1>(basis, i, w, components, which);
    }
    components[count - 1].real()
}

/// The basis vectors `first..first + B`, sliced so that the loops over them need no further checks.
#[inline(always)]
fn vectors<S, const B: usize>(basis: &[S], first: usize, rows: usize) -> [&[S]; B] {
    core::array::from_fn(
        #[inline(always)]
        |i| &basis[(first + i) * rows..][..rows],
    )
}

/// `h_i = v_iᴴw` for `first..first + B`, each summed from zero with the entries ascending.
#[inline(always)]
fn project<S: Scalar<V>, V: Vector, const B: usize>(
    basis: &[S],
    first: usize,
    w: &[S],
    components: &mut [S; STEP_LIMIT],
) {
    let mut sums = [S::from_real(basis[0].real().zero()); B];
    let basis = vectors::<S, B>(basis, first, w.len());
    for (p, &w) in w.iter().enumerate() {
        for i in 0..B {
            sums[i] = sums[i] + w.mul_conj(basis[i][p]);
        }
    }
    components[first..first + B].copy_from_slice(&sums);
}

/// `w ← w − Σ v_i·h_i` for `first..first + B`, one subtraction after another, in the lanes of `which`.
#[inline(always)]
fn subtract<S: Scalar<V>, V: Vector, const B: usize>(
    basis: &[S],
    first: usize,
    w: &mut [S],
    components: &[S; STEP_LIMIT],
    which: V::Mask,
) {
    let basis = vectors::<S, B>(basis, first, w.len());
    let components = &components[first..first + B];
    for (p, w) in w.iter_mut().enumerate() {
        let mut rest = *w;
        for i in 0..B {
            rest = rest - basis[i][p].mul(components[i]);
        }
        *w = S::select(which, rest, *w);
    }
}

/// `Σ_i |v_i|²`, `i` ascending from zero.
#[inline(always)]
fn norm_sqr<S: Scalar<V>, V: Vector>(v: &[S]) -> V {
    let mut sum = v[0].real().zero();
    for x in v {
        sum = sum + x.norm_sqr();
    }
    sum
}

/// `Σ_k v_k·y_k`, `k` ascending from zero; zero in the lanes that are not done.
#[inline(always)]
fn combine<S: Scalar<V>, V: Vector>(
    basis: &[S],
    coefficients: &[V],
    done: V::Mask,
    vector: &mut [S],
) {
    let zero = coefficients[0].zero();
    vector.fill(S::from_real(zero));
    let rows = vector.len();
    for (basis, &y) in basis.chunks_exact(rows).zip(coefficients) {
        let used = zero.less(y) & done;
        if !used.any() {
            continue;
        }
        for (entry, &v) in vector.iter_mut().zip(basis) {
            *entry = S::select(used, *entry + v.scale(y), *entry);
        }
    }
}

impl<V: Vector> Tridiagonal<'_, V> {
    /// A number that no eigenvalue of the leading `k + 1` rows exceeds, where `bound` is one for the
    /// leading `k`: the larger eigenvalue of the matrix of two rows that it makes with the new row.
    #[inline(always)]
    fn upper_bound(&self, k: usize, bound: V) -> V {
        let alpha = self.diagonal[k];
        if k == 0 {
            return alpha;
        }
        let (half, coupling) = (bound.splat(0.5), self.off_diagonal[k - 1]);
        let (mean, difference) = ((bound + alpha) * half, (bound - alpha) * half);
        mean + (difference * difference + coupling * coupling).sqrt()
    }

    /// The largest eigenvalue `θ` of the leading `k + 1` rows from an upper bound, and the length of
    /// the last step towards it.
    ///
    /// Laguerre's iteration on the characteristic polynomial, which comes down from above without
    /// ever passing its largest root. With `S₁ = Σ 1/(θ−θ_j)` and `S₂ = Σ 1/(θ−θ_j)²` over the `m`
    /// roots, from the pivots `δ` of `θ − T` and their derivatives as `Σ δ'/δ` and
    /// `Σ (δ'/δ)² − δ''/δ`, the step is `m/(S₁ + √((m−1)(m·S₂ − S₁²)))`. A lane rests as soon as its
    /// step is below `TOLERANCE/4·θ`.
    #[inline(always)]
    fn largest(&mut self, k: usize, bound: V) -> (V, V) {
        let (zero, one) = (bound.zero(), bound.splat(1.0));
        let (roots, others) = (bound.splat((k + 1) as f32), bound.splat(k as f32));
        let mut theta = bound;
        let mut last_step = bound;
        for _ in 0..LAGUERRE_STEPS {
            let mut pivot = theta - self.diagonal[0];
            let (mut slope, mut curvature) = (one, zero);
            let (mut sum, mut squares) = (zero, zero);
            self.falling[0] = pivot;
            let mut above = zero.less(pivot);
            for i in 1..=k {
                let beta = self.off_diagonal[i - 1];
                let reciprocal = one / pivot;
                let ratio = beta * reciprocal;
                let growth = slope * reciprocal;
                let bend = curvature * reciprocal;
                sum = sum + growth;
                squares = squares + (growth * growth - bend);
                pivot = (theta - self.diagonal[i]) - beta * ratio;
                slope = one + beta * ratio * growth;
                curvature = beta * ratio * (bend - (growth * growth + growth * growth));
                self.falling[i] = pivot;
                above = above & zero.less(pivot);
            }
            let growth = slope / pivot;
            sum = sum + growth;
            squares = squares + (growth * growth - curvature / pivot);
            let spread = others * (roots * squares - sum * sum);
            let spread = V::select(zero.less(spread), spread, zero);
            // Where rounding leaves no pivot, the root is reached.
            let step = V::select(above, roots / (sum + spread.sqrt()), zero);
            let resting = last_step.less(theta.splat(TOLERANCE / 4.0) * theta);
            last_step = V::select(resting, last_step, step);
            theta = V::select(resting, theta, theta - step);
            if resting.all() {
                break;
            }
        }
        (theta, last_step)
    }

    /// Puts the eigenvector to `theta`, of length 1, into `eigenvector` and returns its last entry.
    ///
    /// The pivots `δ` from the top give the ratio of an entry to the one behind, the pivots `d` from
    /// the bottom to the one before. They meet at the entry (the last of equals) where
    /// `|δ_i + d_i − (θ − α_i)|` is least, near the largest one: towards it both are accurate.
    #[inline(always)]
    fn eigenvector(&mut self, k: usize, theta: V) -> V {
        let (zero, one) = (theta.zero(), theta.splat(1.0));
        let mut least = self.falling[k].abs();
        let mut meeting = zero.splat(k as f32);
        let mut pivot = theta - self.diagonal[k];
        for i in (0..k).rev() {
            let beta = self.off_diagonal[i];
            let ratio = beta / positive(pivot);
            self.eigenvector[i + 1] = ratio;
            let rest = beta * ratio;
            pivot = (theta - self.diagonal[i]) - rest;
            let gap = (self.falling[i] - rest).abs();
            let better = gap.less(least);
            least = V::select(better, gap, least);
            meeting = V::select(better, zero.splat(i as f32), meeting);
        }
        self.eigenvector[0] = one;
        let (mut entry, mut sum) = (one, one);
        for i in 0..k {
            let before = zero.splat(i as f32).less(meeting);
            let ratio = V::select(
                before,
                self.falling[i] / self.off_diagonal[i],
                self.eigenvector[i + 1],
            );
            entry = entry * ratio;
            self.eigenvector[i + 1] = entry;
            sum = sum + entry * entry;
        }
        let reciprocal = one / sum.sqrt();
        for entry in &mut self.eigenvector[..=k] {
            *entry = *entry * reciprocal;
        }
        // Beyond f32 it is not known.
        V::select(sum.is_finite(), self.eigenvector[k], one)
    }

    /// Keeps the eigenvector for the lanes in `which`.
    #[inline(always)]
    fn keep(&mut self, k: usize, which: V::Mask) {
        for (i, kept) in self.coefficients.iter_mut().enumerate() {
            let entry = if i <= k {
                self.eigenvector[i]
            } else {
                kept.zero()
            };
            *kept = V::select(which, entry, *kept);
        }
    }
}

/// A pivot of a positive definite matrix, where rounding has left none.
#[inline(always)]
fn positive<V: Vector>(pivot: V) -> V {
    let floor = pivot.splat(super::FLOOR);
    V::select(floor.less(pivot), pivot, floor)
}
