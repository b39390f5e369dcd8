//! Cholesky and the full eigensolver in plain loops.
//!
//! The order of operations is that of `bonebeam::linalg`. Matrices are lower triangles, `a[i][j]` for `j ≤ i`.

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
pub(super) fn power<T: Number>(x: T) -> f32 {
    (x * x.conj()).re()
}

/// Four partial sums, of every fourth value, from zero.
pub(super) fn partial_sums<T: Number>(values: impl Iterator<Item = T>) -> T {
    let mut sums = [T::zero(); 4];
    for (i, value) in values.enumerate() {
        sums[i % 4] = sums[i % 4] + value;
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// The sum of the diagonal.
pub(super) fn trace<T: Number>(a: &[Vec<T>]) -> f32 {
    let mut trace = 0.0;
    for i in 0..a.len() {
        trace += a[i][i].re();
    }
    trace
}

/// `sum` and row `i` of `A·v`: columns ascending from `start`.
pub(super) fn row_times<T: Number>(mut sum: T, a: &[Vec<T>], start: usize, i: usize, v: &[T]) -> T {
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

/// `rows` divided by the factor of `A = G·Gᴴ`: `b*` becomes `(G⁻¹b)*`.
///
/// `None` if `A` is singular in f32.
pub(super) fn cholesky<T: Number>(a: &[Vec<T>], rows: &[Vec<T>]) -> Option<Vec<Vec<T>>> {
    let mut g = factor(a, rows)?;
    Some(g.split_off(a.len()))
}

/// The factor `G` of `A = G·Gᴴ`, with `1/G(j,j)` on its diagonal, and below it `rows` divided by it.
pub(super) fn factor<T: Number>(a: &[Vec<T>], rows: &[Vec<T>]) -> Option<Vec<Vec<T>>> {
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
        g[j][j] = T::real(inverse);
    }
    Some(g)
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
pub(super) struct Reduced<T> {
    pub(super) mean: f32,
    pub(super) alpha: Vec<f32>,
    pub(super) beta: Vec<f32>,
    /// The off-diagonal entry of row `m` at `m − 1`.
    pub(super) reflections: Vec<Reflection<T>>,
}

/// One row's reflection, and the phase that its off-diagonal entry then has.
pub(super) struct Reflection<T> {
    pub(super) v: Vec<T>,
    pub(super) tau: f32,
    pub(super) phase: T,
}

/// Householder, from the last row to the second.
pub(super) fn reduce<T: Number>(mut a: Vec<Vec<T>>) -> Reduced<T> {
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
