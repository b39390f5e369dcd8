//! Cholesky, power iteration and the full eigensolver in plain loops, in the order of operations
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
}

impl Number for f32 {
    fn real(value: f32) -> Self {
        value
    }

    fn times(self, z: Complex<f32>) -> Complex<f32> {
        z * self
    }
}

impl Number for Complex<f32> {
    fn real(value: f32) -> Self {
        Complex::from(value)
    }

    fn times(self, z: Complex<f32>) -> Complex<f32> {
        self * z
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

/// Row `i` of `A·v`: columns ascending from zero.
fn row_times<T: Number>(a: &[Vec<T>], start: usize, i: usize, v: &[T]) -> T {
    let mut sum = T::zero();
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

/// The factor `G` of `A = G·Gᴴ` below the diagonal, and `1/G(j,j)`; `None` where `A` is singular in
/// f32.
pub(super) fn cholesky<T: Number>(a: &[Vec<T>]) -> Option<(Vec<Vec<T>>, Vec<f32>)> {
    let n = a.len();
    let mut g: Vec<Vec<T>> = (0..n).map(|i| vec![T::zero(); i]).collect();
    let mut inverse = vec![0.0; n];
    for j in 0..n {
        let mut pivot = a[j][j].re();
        for k in 0..j {
            pivot -= power(g[j][k]);
        }
        if pivot <= FLOOR {
            return None;
        }
        inverse[j] = 1.0 / pivot.sqrt();
        for i in j + 1..n {
            let mut entry = a[i][j];
            for k in 0..j {
                entry = entry - g[i][k] * g[j][k].conj();
            }
            g[i][j] = entry * inverse[j];
        }
    }
    Some((g, inverse))
}

/// `G⁻¹b`.
pub(super) fn solve_lower<T: Number>(g: &[Vec<T>], inverse: &[f32], b: &[T]) -> Vec<T> {
    let mut x = Vec::new();
    for i in 0..b.len() {
        let mut value = b[i];
        for k in 0..i {
            value = value - g[i][k] * x[k];
        }
        x.push(value * inverse[i]);
    }
    x
}

/// `G⁻ᴴb`.
pub(super) fn solve_upper<T: Number>(g: &[Vec<T>], inverse: &[f32], b: &[T]) -> Vec<T> {
    let mut x = b.to_vec();
    for i in (0..b.len()).rev() {
        for k in i + 1..b.len() {
            x[i] = x[i] - x[k] * g[k][i].conj();
        }
        x[i] = x[i] * inverse[i];
    }
    x
}

/// The largest eigenvalue and its eigenvector, or `None` where the iteration does not arrive.
pub(super) fn power_iteration<T: Number>(a: &[Vec<T>]) -> Option<(f32, Vec<T>)> {
    let n = a.len();
    let mut v = start(n);
    let mut total = 0.0;
    for i in 0..n {
        let below = norm_sqr(&a[i][..i]);
        total += below + below;
        total += power(a[i][i]);
    }
    for step in 1..=32 {
        let product: Vec<T> = (0..n).map(|i| row_times(a, 0, i, &v)).collect();
        let length = norm_sqr(&product).sqrt();
        let reciprocal = if length > 0.0 { 1.0 / length } else { 0.0 };
        let mut change = 0.0;
        for i in 0..n {
            let entry = product[i] * reciprocal;
            change += power(entry - v[i]);
            v[i] = entry;
        }
        let square = length * length;
        let others = if total - square > 0.0 {
            total - square
        } else {
            0.0
        };
        let ratio = if square > 0.0 {
            (others / square + 1e-6).sqrt()
        } else {
            2.0
        };
        if change.sqrt() * ratio <= 4e-6 * (1.0 - ratio) {
            return Some((length, v));
        }
        if step >= 8 && ratio >= 1.0 {
            return None;
        }
    }
    None
}

/// The start vector of the power iteration.
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
        q[i] = row_times(a, k + 1, i, &v) * tau;
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
