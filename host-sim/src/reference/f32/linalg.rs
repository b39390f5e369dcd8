//! Cholesky, Lanczos and the full eigensolver in plain loops, in the order of operations
//! of `bonebeam::linalg`. Matrices are lower triangles, `a[i][j]` for `j ≤ i`.

use std::ops::Mul;

use num_complex::{Complex, ComplexFloat};

/// A matrix entry: f32 after forward-backward averaging, complex without it.
pub(super) trait Number:
    ComplexFloat<Real = f32> + Into<Complex<f32>> + Mul<f32, Output = Self>
{
    /// A real number.
    fn real(value: f32) -> Self;

    /// `self · z`, without adding products with a zero imaginary part.
    fn times(self, z: Complex<f32>) -> Complex<f32>;

    /// The steering vector and the data as conjugated rows; complex data make two real ones.
    fn right_sides(steering: &[Self], s: &[Complex<f32>]) -> Vec<Vec<Self>>;

    /// Entry `k` of the steering vector's row times that of the data's, not conjugated.
    fn product(rows: &[Vec<Self>], k: usize) -> Complex<f32>;
}

impl Number for f32 {
    fn real(value: f32) -> Self {
        value
    }

    fn times(self, z: Complex<f32>) -> Complex<f32> {
        z * self
    }

    fn right_sides(steering: &[f32], s: &[Complex<f32>]) -> Vec<Vec<f32>> {
        vec![
            steering.to_vec(),
            s.iter().map(|s| s.re).collect(),
            s.iter().map(|s| s.im).collect(),
        ]
    }

    fn product(rows: &[Vec<f32>], k: usize) -> Complex<f32> {
        Complex::new(rows[1][k], rows[2][k]) * rows[0][k]
    }
}

impl Number for Complex<f32> {
    fn real(value: f32) -> Self {
        Complex::from(value)
    }

    fn times(self, z: Complex<f32>) -> Complex<f32> {
        self * z
    }

    fn right_sides(steering: &[Self], s: &[Complex<f32>]) -> Vec<Vec<Self>> {
        vec![steering.to_vec(), s.iter().map(|s| s.conj()).collect()]
    }

    fn product(rows: &[Vec<Self>], k: usize) -> Complex<f32> {
        rows[0][k] * rows[1][k].conj()
    }
}

/// The smallest pivot and eigenvalue that count.
pub(super) const FLOOR: f32 = 1.0 / 16_777_216.0;

/// The power below which an entry counts as zero in the eigensolver: 2⁻¹⁰⁰.
const NOTHING: f32 = 7.888_609e-31;

/// `|x|²`.
fn power<T: Number>(x: T) -> f32 {
    (x * x.conj()).re()
}

/// `Σ|v_i|²`, ascending from zero.
pub(super) fn norm_sqr<T: Number>(v: &[T]) -> f32 {
    let mut sum = 0.0;
    for &x in v {
        sum += power(x);
    }
    sum
}

/// `sum` and row `i` of `A·v`: columns ascending from `start`.
fn row_times<T: Number>(mut sum: T, a: &[Vec<T>], start: usize, i: usize, v: &[T]) -> T {
    for j in start..v.len() {
        sum = sum
            + if j <= i {
                a[i][j] * v[j]
            } else {
                v[j] * a[j][i].conj()
            };
    }
    sum
}

/// `rows` divided by the factor of `A = G·Gᴴ`: `b*` becomes `(G⁻¹b)*`. `None` where `A` is singular
/// in f32.
pub(super) fn cholesky<T: Number>(a: &[Vec<T>], rows: &[Vec<T>]) -> Option<Vec<Vec<T>>> {
    let n = a.len();
    let mut g: Vec<Vec<T>> = a.to_vec();
    g.extend(rows.iter().cloned());
    for j in 0..n {
        let mut pivot = g[j][j].re();
        for k in 0..j {
            pivot -= power(g[j][k]);
        }
        if pivot <= FLOOR {
            return None;
        }
        let inverse = 1.0 / pivot.sqrt();
        for i in j + 1..g.len() {
            let mut entry = g[i][j];
            for k in 0..j {
                entry = entry - g[i][k] * g[j][k].conj();
            }
            g[i][j] = entry * inverse;
        }
    }
    Some(g.split_off(n))
}

/// The largest eigenvalue and its eigenvector, or `None` where the iteration does not arrive.
pub(super) fn lanczos<T: Number>(a: &[Vec<T>]) -> Option<(f32, Vec<T>)> {
    let n = a.len();
    let steps = n.min(48);
    let mut trace = 0.0;
    for i in 0..n {
        trace += a[i][i].re();
    }
    let shift = trace / n as f32;
    let mut basis = vec![start::<T>(n)];
    let (mut alpha, mut beta) = (Vec::new(), Vec::<f32>::new());
    let mut bound = 0.0;
    let mut spent = false;
    for k in 0..steps {
        let mut w: Vec<T> = (0..n)
            .map(|i| row_times(basis[k][i] * -shift, a, 0, i, &basis[k]))
            .collect();
        let before = norm_sqr(&w);
        alpha.push(orthogonalise(&basis, &mut w) + shift);
        if norm_sqr(&w) < before * 0.1 {
            orthogonalise(&basis, &mut w);
        }
        // No eigenvalue of the two rows that the bound and the new diagonal entry make is larger.
        bound = match beta.last() {
            None => alpha[0],
            Some(coupling) => {
                let (mean, difference) = ((bound + alpha[k]) * 0.5, (bound - alpha[k]) * 0.5);
                mean + (difference * difference + coupling * coupling).sqrt()
            }
        };
        beta.push(norm_sqr(&w).sqrt());
        let exhausted = beta[k] < 1e-6 * bound;
        if (k >= 2 && (k < 5 || k % 2 == 0)) || k + 1 == steps {
            let (theta, step, pivots) = largest(&alpha, &beta, bound);
            bound = theta;
            let y = eigenvector(&alpha, &beta, theta, &pivots);
            let certain = trace < theta + theta;
            let (limit, by_gap) = (1e-6 * theta, 1e-5 * ((theta + theta) - trace));
            let limit = if limit < by_gap { by_gap } else { limit };
            let converged = beta[k] * y[k] + step < limit;
            let searched = !spent && (k + 1 == n || (k >= 4 && !exhausted));
            if converged && (certain || searched) {
                return Some((theta, combine(&basis, &y)));
            }
            if spent {
                return None;
            }
        }
        spent = spent || exhausted;
        let reciprocal = if exhausted { 0.0 } else { 1.0 / beta[k] };
        basis.push(w.iter().map(|&entry| entry * reciprocal).collect());
    }
    None
}

/// Takes from `w` its components along the basis, all found before the first is taken; returns the
/// real part of the last.
fn orthogonalise<T: Number>(basis: &[Vec<T>], w: &mut [T]) -> f32 {
    let mut components = Vec::new();
    for v in basis {
        let mut sum = T::zero();
        for i in 0..w.len() {
            sum = sum + w[i] * v[i].conj();
        }
        components.push(sum);
    }
    for (v, &component) in basis.iter().zip(&components) {
        for i in 0..w.len() {
            w[i] = w[i] - v[i] * component;
        }
    }
    components[basis.len() - 1].re()
}

/// Laguerre's iteration from an upper bound to the largest eigenvalue of the tridiagonal matrix;
/// its last step, and the pivots of `θ − T` where they were last found.
fn largest(alpha: &[f32], beta: &[f32], bound: f32) -> (f32, f32, Vec<f32>) {
    let (roots, others) = (alpha.len() as f32, (alpha.len() - 1) as f32);
    let (mut theta, mut last_step) = (bound, bound);
    let mut pivots = Vec::new();
    for _ in 0..10 {
        pivots = vec![theta - alpha[0]];
        let (mut slope, mut curvature) = (1.0, 0.0);
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 1..alpha.len() {
            let reciprocal = 1.0 / pivots[i - 1];
            let (ratio, growth, bend) = (
                beta[i - 1] * reciprocal,
                slope * reciprocal,
                curvature * reciprocal,
            );
            sum += growth;
            squares += growth * growth - bend;
            pivots.push(theta - alpha[i] - beta[i - 1] * ratio);
            slope = 1.0 + beta[i - 1] * ratio * growth;
            curvature = beta[i - 1] * ratio * (bend - (growth * growth + growth * growth));
        }
        let pivot = pivots[alpha.len() - 1];
        let growth = slope / pivot;
        sum += growth;
        squares += growth * growth - curvature / pivot;
        let spread = others * (roots * squares - sum * sum);
        let spread = if spread > 0.0 { spread } else { 0.0 };
        if last_step < theta * (1e-6 / 4.0) {
            break;
        }
        last_step = if pivots.iter().all(|&pivot| pivot > 0.0) {
            roots / (sum + spread.sqrt())
        } else {
            0.0
        };
        theta -= last_step;
    }
    (theta, last_step, pivots)
}

/// The unit eigenvector to `theta`: from the top with the pivots found on the way to it, from the
/// bottom with others, meeting where they differ least. A last entry of 1 where it is beyond f32.
fn eigenvector(alpha: &[f32], beta: &[f32], theta: f32, pivots: &[f32]) -> Vec<f32> {
    let last = alpha.len() - 1;
    let mut rising = vec![0.0; last];
    let (mut least, mut meeting) = (pivots[last].abs(), last);
    let mut pivot = theta - alpha[last];
    for i in (0..last).rev() {
        rising[i] = beta[i] / if pivot > FLOOR { pivot } else { FLOOR };
        let rest = beta[i] * rising[i];
        pivot = theta - alpha[i] - rest;
        let gap = (pivots[i] - rest).abs();
        if gap < least {
            (least, meeting) = (gap, i);
        }
    }
    let mut y = vec![1.0];
    let mut sum = 1.0;
    for i in 0..last {
        let ratio = if i < meeting {
            pivots[i] / beta[i]
        } else {
            rising[i]
        };
        let entry = y[i] * ratio;
        sum += entry * entry;
        y.push(entry);
    }
    let reciprocal = 1.0 / sum.sqrt();
    for entry in &mut y {
        *entry *= reciprocal;
    }
    if !sum.is_finite() {
        y[last] = 1.0;
    }
    y
}

/// `Σ v_k·y_k` over the entries above zero.
fn combine<T: Number>(basis: &[Vec<T>], y: &[f32]) -> Vec<T> {
    let mut sum = vec![T::zero(); basis[0].len()];
    for (v, &y) in basis.iter().zip(y) {
        if y > 0.0 {
            for i in 0..sum.len() {
                sum[i] = sum[i] + v[i] * y;
            }
        }
    }
    sum
}

/// The start vector of the Lanczos iteration.
fn start<T: Number>(n: usize) -> Vec<T> {
    let mut entries = Vec::new();
    let mut fraction = 0.0_f32;
    let mut sum = 0.0;
    for _ in 0..n {
        fraction += 0.618_034;
        if fraction >= 1.0 {
            fraction -= 1.0;
        }
        let entry = 0.5 + fraction;
        sum += entry * entry;
        entries.push(entry);
    }
    let reciprocal = 1.0 / sum.sqrt();
    entries
        .into_iter()
        .map(|entry| T::real(entry * reciprocal))
        .collect()
}

/// All eigenvalues, unordered, and `Eᴴ·rows[r]` in place of each `rows[r]`.
pub(super) fn eigen<T: Number>(mut a: Vec<Vec<T>>, rows: &mut [Vec<Complex<f32>>]) -> Vec<f32> {
    let n = a.len();
    let mut trace = 0.0;
    for k in 0..n {
        trace += a[k][k].re();
    }
    let mean = trace / n as f32;
    for k in 0..n {
        a[k][k] = T::real(a[k][k].re() - mean);
    }
    let mut diagonal = Vec::new();
    let mut off_diagonal = Vec::new();
    let mut phase: T = T::real(1.0);
    for k in 0..n {
        diagonal.push(a[k][k].re());
        if k + 1 == n {
            break;
        }
        let below = reflect(&mut a, k, rows);
        if power(below) < NOTHING {
            off_diagonal.push(0.0);
        } else {
            let length = power(below).sqrt();
            off_diagonal.push(length);
            phase = phase * (below * (1.0 / length));
        }
        for row in rows.iter_mut() {
            row[k + 1] = phase.conj().times(row[k + 1]);
        }
    }
    off_diagonal.push(0.0);
    implicit_ql(&mut diagonal, &mut off_diagonal, rows);
    diagonal.into_iter().map(|value| value + mean).collect()
}

/// Householder: reflects column `k` onto its entry below the diagonal, which is returned.
fn reflect<T: Number>(a: &mut [Vec<T>], k: usize, rows: &mut [Vec<Complex<f32>>]) -> T {
    let n = a.len();
    let mut v = vec![T::zero(); n];
    for i in k + 1..n {
        v[i] = a[i][k];
    }
    let alpha = v[k + 1];
    let tail = norm_sqr(&v[k + 2..]);
    if tail < NOTHING {
        return alpha;
    }
    let alpha_length = power(alpha).sqrt();
    let length = (power(alpha) + tail).sqrt();
    let phase = if power(alpha) >= NOTHING {
        alpha * (1.0 / alpha_length)
    } else {
        T::real(1.0)
    };
    let first = alpha_length + length;
    v[k + 1] = phase * first;
    let tau = 2.0 / (tail + first * first);

    let mut q = vec![T::zero(); n];
    let mut inner = 0.0;
    for i in k + 1..n {
        q[i] = row_times(T::zero(), a, k + 1, i, &v) * tau;
        inner += (q[i] * v[i].conj()).re();
    }
    let half = 0.5 * tau * inner;
    for i in k + 1..n {
        q[i] = q[i] - v[i] * half;
    }
    for i in k + 1..n {
        for j in k + 1..=i {
            a[i][j] = a[i][j] - v[i] * q[j].conj() - q[i] * v[j].conj();
        }
    }
    for row in rows {
        let mut inner = Complex::ZERO;
        for i in k + 1..n {
            inner += v[i].conj().times(row[i]);
        }
        let inner = inner * tau;
        for i in k + 1..n {
            row[i] -= v[i].into() * inner;
        }
    }
    T::zero() - phase * length
}

/// EISPACK's `tql2` with a Wilkinson shift, on rows instead of columns of eigenvectors.
fn implicit_ql(d: &mut [f32], e: &mut [f32], rows: &mut [Vec<Complex<f32>>]) {
    let n = d.len();
    for first in 0..n {
        for _ in 0..40 {
            let mut last = first;
            while last + 1 < n
                && e[last].abs() >= NOTHING.sqrt()
                && e[last].abs() > FLOOR * (d[last].abs() + d[last + 1].abs())
            {
                last += 1;
            }
            if last == first {
                break;
            }
            ql_step(d, e, first, last, rows);
        }
        e[first] = 0.0;
    }
}

/// One implicit step on the unreduced block `first..=last`.
fn ql_step(
    d: &mut [f32],
    e: &mut [f32],
    first: usize,
    last: usize,
    rows: &mut [Vec<Complex<f32>>],
) {
    let gap = (d[first + 1] - d[first]) / (2.0 * e[first]);
    let root = (gap * gap + 1.0).sqrt();
    let mut g = d[last] - d[first] + e[first] / (if gap >= 0.0 { gap + root } else { gap - root });
    let (mut s, mut c, mut p) = (1.0_f32, 1.0_f32, 0.0_f32);
    for i in (first..last).rev() {
        let f = s * e[i];
        let b = c * e[i];
        let r = (f * f + g * g).sqrt();
        e[i + 1] = r;
        if r == 0.0 {
            d[i + 1] -= p;
            e[last] = 0.0;
            return;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1] - p;
        let t = (d[i] - g) * s + 2.0 * c * b;
        p = s * t;
        d[i + 1] = g + p;
        g = c * t - b;
        for row in rows.iter_mut() {
            let (left, right) = (row[i], row[i + 1]);
            row[i + 1] = left * s + right * c;
            row[i] = left * c - right * s;
        }
    }
    d[first] -= p;
    e[first] = g;
    e[last] = 0.0;
}
