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

    /// `|α|` and `α/|α|`.
    fn polar(self) -> (f32, Self);

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

    fn polar(self) -> (f32, f32) {
        (self.abs(), if self < 0.0 { -1.0 } else { 1.0 })
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

    fn polar(self) -> (f32, Self) {
        let length = power(self).sqrt();
        if power(self) < NOTHING {
            (length, Complex::ONE)
        } else {
            (length, self * (1.0 / length))
        }
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

/// Four partial sums, of every fourth value, from zero.
fn partial_sums<T: Number>(values: impl Iterator<Item = T>) -> T {
    let mut sums = [T::zero(); 4];
    for (i, value) in values.enumerate() {
        sums[i % 4] = sums[i % 4] + value;
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// The sum of the diagonal.
fn trace<T: Number>(a: &[Vec<T>]) -> f32 {
    let mut trace = 0.0;
    for i in 0..a.len() {
        trace += a[i][i].re();
    }
    trace
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

/// The largest eigenvalue and its eigenvector.
pub(super) fn first_pair<T: Number>(a: &[Vec<T>]) -> (f32, Vec<T>) {
    lanczos(a).unwrap_or_else(|| direct(a))
}

/// The Lanczos iteration, or `None` where it does not arrive.
fn lanczos<T: Number>(a: &[Vec<T>]) -> Option<(f32, Vec<T>)> {
    let n = a.len();
    let steps = match n {
        0..8 => n,
        8..32 => 8,
        32..64 => n / 4,
        _ => 16,
    };
    let trace = trace(a);
    let mean = trace / n as f32;
    let start = usize::from(n > 1 && a[0][0].re() < a[1][1].re());
    // All basis vectors but the first, which is a unit vector.
    let mut basis: Vec<Vec<T>> = Vec::new();
    let (mut alpha, mut beta) = (vec![a[start][start].re()], Vec::<f32>::new());
    let (mut reciprocals, mut errors) = (Vec::new(), vec![0.0]);
    let (mut bound, mut shift, mut share) = (alpha[0], 0.0, 1.0);
    for k in 0..steps {
        let mut w: Vec<T> = (0..n)
            .map(|i| match basis.last() {
                None if i > start => a[i][start],
                None => a[start][i].conj(),
                Some(v) => row_times(v[i] * -shift, a, 0, i, v),
            })
            .collect();
        w[start] = T::zero();
        if k > 0 {
            alpha.push(orthogonalise(&basis, &mut w) + shift);
            bound = upper_bound(bound, alpha[k], beta[k - 1]);
            share *= beta[k - 1] / (bound - alpha[k]);
        }
        let length = partial_sums(w.iter().map(|&x| power(x))).sqrt();
        beta.push(length);
        let exhausted = length <= 1e-6 * bound;
        let end = k + 1 == steps;
        if k >= 1 || end || exhausted {
            let mut gap = (bound + bound) - trace;
            if gap <= 0.0 {
                gap = gap_by_squares(a, mean, bound);
            }
            if gap <= 0.0 {
                return None;
            }
            if end || exhausted || length * share <= 8.0 * 1e-5 * bound {
                bound = largest(&alpha, &beta, bound, 1e-3 * gap);
                let (left, y) = eigenvector_upwards(&alpha, &beta, bound, &reciprocals);
                let mut residual = length * y[k] + left;
                for i in 0..k {
                    residual += errors[i] * y[i + 1];
                }
                if residual < 1e-5 * gap {
                    return Some((bound, combine(&basis, &y, start, n)));
                }
            }
            if exhausted {
                return None;
            }
        }
        let reciprocal = 1.0 / length;
        basis.push(w.iter().map(|&entry| entry * reciprocal).collect());
        reciprocals.push(reciprocal);
        if k > 0 {
            let lost = (alpha[k] - shift).abs() + beta[k - 1];
            errors.push((1e-7 * trace) * (lost * reciprocal));
        }
        shift = (trace - bound) / (n - 1) as f32;
    }
    None
}

/// How far the eigenvalue `bound` is from all others, by the sum of the squared deviations.
fn gap_by_squares<T: Number>(a: &[Vec<T>], mean: f32, bound: f32) -> f32 {
    let (mut diagonal, mut rest) = (0.0, [0.0; 4]);
    for i in 0..a.len() {
        for j in 0..i {
            rest[i % 4] += power(a[i][j]);
        }
        diagonal += (a[i][i].re() - mean) * (a[i][i].re() - mean);
    }
    let rest = (rest[0] + rest[1]) + (rest[2] + rest[3]);
    let deviation = bound - mean;
    let others = (diagonal + (rest + rest)) - deviation * deviation;
    deviation - if others > 0.0 { others.sqrt() } else { 0.0 }
}

/// Takes from `w` its components along the basis, all found before the first is taken; returns the
/// real part of the last.
fn orthogonalise<T: Number>(basis: &[Vec<T>], w: &mut [T]) -> f32 {
    let mut components = Vec::new();
    for v in basis {
        components.push(partial_sums((0..w.len()).map(|i| w[i] * v[i].conj())));
    }
    for (v, &component) in basis.iter().zip(&components) {
        for i in 0..w.len() {
            w[i] = w[i] - v[i] * component;
        }
    }
    components[basis.len() - 1].re()
}

/// `Σ v_k·y_k`, the first basis vector being a unit vector.
fn combine<T: Number>(basis: &[Vec<T>], y: &[f32], start: usize, n: usize) -> Vec<T> {
    let mut sum = vec![T::zero(); n];
    for (v, &y) in basis.iter().zip(&y[1..]) {
        for i in 0..n {
            sum[i] = sum[i] + v[i] * y;
        }
    }
    sum[start] = T::real(y[0]);
    sum
}

/// The eigenvector to `theta` from its last entry on, and what is left of the first row.
fn eigenvector_upwards(
    alpha: &[f32],
    beta: &[f32],
    theta: f32,
    reciprocals: &[f32],
) -> (f32, Vec<f32>) {
    let rows = alpha.len();
    let mut y = vec![1.0_f32; rows];
    let (mut behind, mut sum) = (0.0, 1.0);
    for k in (0..rows - 1).rev() {
        let row = (theta - alpha[k + 1]) * y[k + 1] - behind;
        behind = beta[k] * y[k + 1];
        y[k] = row * reciprocals[k];
        sum += y[k] * y[k];
    }
    let left = ((theta - alpha[0]) * y[0] - behind).abs();
    let reciprocal = 1.0 / sum.sqrt();
    (
        left * reciprocal,
        y.iter().map(|y| y * reciprocal).collect(),
    )
}

/// The pair directly: reduction to a tridiagonal matrix, its pair, and back.
fn direct<T: Number>(a: &[Vec<T>]) -> (f32, Vec<T>) {
    let mut reduced = reduce(a.to_vec());
    let mut bound = 0.0;
    for i in 0..a.len() {
        reduced.alpha[i] += reduced.mean;
        bound = match i {
            0 => reduced.alpha[0],
            _ => upper_bound(bound, reduced.alpha[i], reduced.beta[i - 1]),
        };
    }
    let theta = largest(&reduced.alpha, &reduced.beta, bound, 1e-6 * bound);
    let y = eigenvector(&reduced.alpha, &reduced.beta, theta);
    let mut x: Vec<T> = y.iter().map(|&y| T::real(y)).collect();
    let mut phase: T = T::real(1.0);
    for m in 1..a.len() {
        let Reflection { v, tau, phase: own } = &reduced.reflections[m - 1];
        let along = partial_sums((0..m).map(|j| x[j] * v[j].conj())) * *tau;
        for j in 0..m {
            x[j] = x[j] - v[j] * along;
        }
        phase = phase * own.conj();
        x[m] = x[m] * phase;
    }
    (theta, x)
}

/// The larger eigenvalue of the matrix of two rows that a bound and a further row make.
fn upper_bound(bound: f32, alpha: f32, coupling: f32) -> f32 {
    let (mean, difference) = ((bound + alpha) * 0.5, (bound - alpha) * 0.5);
    mean + (difference * difference + coupling * coupling).sqrt()
}

/// Laguerre's iteration from an upper bound to the largest eigenvalue of the tridiagonal matrix.
fn largest(alpha: &[f32], beta: &[f32], bound: f32, enough: f32) -> f32 {
    let (roots, others) = (alpha.len() as f32, (alpha.len() - 1) as f32);
    let mut theta = bound;
    for _ in 0..20 {
        let mut pivot = theta - alpha[0];
        let (mut slope, mut curvature) = (1.0, 0.0);
        let (mut sum, mut squares) = (0.0, 0.0);
        let mut above = pivot > 0.0;
        for i in 1..alpha.len() {
            let reciprocal = 1.0 / pivot;
            let square = beta[i - 1] * (beta[i - 1] * reciprocal);
            let (growth, bend) = (slope * reciprocal, curvature * reciprocal);
            sum += growth;
            squares += growth * growth - bend;
            pivot = theta - alpha[i] - square;
            slope = 1.0 + square * growth;
            curvature = square * (bend - (growth * growth + growth * growth));
            above = above && pivot > 0.0;
        }
        let reciprocal = 1.0 / pivot;
        let growth = slope * reciprocal;
        sum += growth;
        squares += growth * growth - curvature * reciprocal;
        let spread = others * (roots * squares - sum * sum);
        let spread = if spread > 0.0 { spread } else { 0.0 };
        let step = roots / (sum + spread.sqrt());
        let step = if above && step > 0.0 { step } else { 0.0 };
        theta -= step;
        if step < enough {
            break;
        }
    }
    theta
}

/// The unit eigenvector to `theta`: ratios of entries from the top and from the bottom, meeting where
/// they differ least.
fn eigenvector(alpha: &[f32], beta: &[f32], theta: f32) -> Vec<f32> {
    let last = alpha.len() - 1;
    let positive = |pivot: f32| if pivot > FLOOR { pivot } else { FLOOR };
    let (mut falling, mut rising) = (vec![0.0; last + 1], vec![0.0; last + 1]);
    let (mut down, mut up) = (theta - alpha[0], theta - alpha[last]);
    for i in 0..last {
        falling[i] = beta[i] / positive(down);
        down = theta - alpha[i + 1] - beta[i] * falling[i];
        let j = last - 1 - i;
        rising[j + 1] = beta[j] / positive(up);
        up = theta - alpha[j] - beta[j] * rising[j + 1];
    }
    let (mut least, mut meeting) = (up.abs(), 0);
    for i in 1..=last {
        let mut gap = theta - alpha[i] - beta[i - 1] * falling[i - 1];
        if i < last {
            gap -= beta[i] * rising[i + 1];
        }
        if gap.abs() <= least {
            (least, meeting) = (gap.abs(), i);
        }
    }
    let mut y = vec![1.0_f32; last + 1];
    for i in (0..meeting).rev() {
        y[i] = y[i + 1] * falling[i];
    }
    for i in meeting + 1..=last {
        y[i] = y[i - 1] * rising[i];
    }
    let mut sum = 0.0;
    for y in &y {
        sum += y * y;
    }
    let reciprocal = 1.0 / sum.sqrt();
    y.iter().map(|y| y * reciprocal).collect()
}

/// All eigenvalues, unordered, and `Eᴴ·rows[r]` in place of each `rows[r]`.
pub(super) fn eigen<T: Number>(a: Vec<Vec<T>>, rows: &mut [Vec<Complex<f32>>]) -> Vec<f32> {
    let n = a.len();
    let mut reduced = reduce(a);
    for row in rows.iter_mut() {
        for m in (1..n).rev() {
            let Reflection { v, tau, .. } = &reduced.reflections[m - 1];
            let along = partial_sums((0..m).map(|j| v[j].conj().times(row[j]))) * *tau;
            for j in 0..m {
                row[j] -= v[j].into() * along;
            }
        }
        let mut phase: T = T::real(1.0);
        for m in 1..n {
            phase = phase * reduced.reflections[m - 1].phase.conj();
            row[m] = phase.conj().times(row[m]);
        }
    }
    reduced.beta.push(0.0);
    implicit_ql(&mut reduced.alpha, &mut reduced.beta, rows);
    let mean = reduced.mean;
    reduced
        .alpha
        .into_iter()
        .map(|value| value + mean)
        .collect()
}

/// A matrix less the mean of its diagonal, reduced to a real tridiagonal one.
struct Reduced<T> {
    mean: f32,
    alpha: Vec<f32>,
    beta: Vec<f32>,
    /// Of row `m` at `m − 1`.
    reflections: Vec<Reflection<T>>,
}

/// One row's reflection, and the phase that its off-diagonal entry then has.
struct Reflection<T> {
    v: Vec<T>,
    tau: f32,
    phase: T,
}

/// Householder, from the last row to the second.
fn reduce<T: Number>(mut a: Vec<Vec<T>>) -> Reduced<T> {
    let n = a.len();
    let mean = trace(&a) / n as f32;
    for i in 0..n {
        a[i][i] = T::real(a[i][i].re() - mean);
    }
    let (mut alpha, mut beta, mut reflections) = (Vec::new(), Vec::new(), Vec::new());
    for m in (1..n).rev() {
        alpha.push(a[m][m].re());
        let mut v: Vec<T> = a[m][..m].iter().map(|x| x.conj()).collect();
        let (length, phase) = v[m - 1].polar();
        let tail = partial_sums(v[..m - 1].iter().map(|&x| power(x)));
        let reduced = tail < NOTHING;
        let reach = (length * length + tail).sqrt();
        let first = length + reach;
        v[m - 1] = phase * first;
        let tau = if reduced {
            0.0
        } else {
            2.0 / (tail + first * first)
        };
        beta.push(if reduced { length } else { reach });
        let mut q: Vec<T> = (0..m)
            .map(|i| row_times(T::zero(), &a, 0, i, &v) * tau)
            .collect();
        let inner = partial_sums((0..m).map(|j| (q[j] * v[j].conj()).re()));
        let half = 0.5 * tau * inner;
        for j in 0..m {
            q[j] = q[j] - v[j] * half;
        }
        for i in 0..m {
            for j in 0..=i {
                a[i][j] = a[i][j] - v[i] * q[j].conj() - q[i] * v[j].conj();
            }
        }
        let phase = if reduced { phase } else { T::zero() - phase };
        reflections.push(Reflection { v, tau, phase });
    }
    alpha.push(a[0][0].re());
    alpha.reverse();
    beta.reverse();
    reflections.reverse();
    Reduced {
        mean,
        alpha,
        beta,
        reflections,
    }
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
