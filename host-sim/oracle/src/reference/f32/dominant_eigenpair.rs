//! The largest eigenvalue and its eigenvector in plain loops.
//!
//! They are computed by Lanczos steps, directly, or by power iteration. The order of operations is that of
//! `bonebeam::linalg`.

use super::linalg::{FLOOR, Number, Reflection, partial_sums, power, reduce, row_times, trace};

/// The largest eigenvalue and its eigenvector.
pub(super) fn dominant_eigenpair<T: Number>(a: &[Vec<T>]) -> (f32, Vec<T>) {
    lanczos(a).unwrap_or_else(|| direct(a))
}

/// Steps of power iteration: the last product's length, and its direction.
pub(super) fn power_iteration<T: Number>(a: &[Vec<T>], steps: usize) -> (f32, Vec<T>) {
    let n = a.len();
    let start = usize::from(n > 1 && a[0][0].re() < a[1][1].re());
    // The matrix times a unit vector is a column.
    let mut product: Vec<T> = (0..n)
        .map(|i| match i >= start {
            true => a[i][start],
            false => a[start][i].conj(),
        })
        .collect();
    for step in 1.. {
        let length = partial_sums(product.iter().map(|&x| power(x))).sqrt();
        let reciprocal = 1.0 / length;
        let v: Vec<T> = product.iter().map(|&entry| entry * reciprocal).collect();
        if step == steps {
            return (length, v);
        }
        product = (0..n)
            .map(|i| row_times(v[i] * -0.0, a, 0, i, &v))
            .collect();
    }
    unreachable!("there is a last step")
}

/// The Lanczos iteration; `None` if it does not converge.
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
    let (mut bound, mut shift, mut fraction) = (alpha[0], 0.0, 1.0);
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
            fraction *= beta[k - 1] / (bound - alpha[k]);
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
            if end || exhausted || length * fraction <= 8.0 * 2e-6 * bound {
                bound = largest(&alpha, &beta, bound, 1e-3 * gap);
                let (left, y) = eigenvector_upwards(&alpha, &beta, bound, &reciprocals);
                let mut residual = length * y[k] + left;
                for i in 0..k {
                    residual += errors[i] * y[i + 1];
                }
                if residual < 2e-6 * gap {
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

/// The distance of the eigenvalue `bound` from all others.
///
/// It is by the sum of the squared deviations.
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

/// Subtracts from `w` its components along the basis; returns the real part of the last.
///
/// All components are computed before the first is subtracted.
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

/// The eigenvector to `theta` from its last entry, and the residual of the first row.
fn eigenvector_upwards(
    alpha: &[f32],
    beta: &[f32],
    theta: f32,
    reciprocals: &[f32],
) -> (f32, Vec<f32>) {
    let rows = alpha.len();
    // A power of two that leaves room for larger entries.
    let last = 2.0_f32.powi(-40);
    let mut y = vec![last; rows];
    let (mut behind, mut sum) = (0.0, last * last);
    for k in (0..rows - 1).rev() {
        let row = (theta - alpha[k + 1]) * y[k + 1] - behind;
        behind = beta[k] * y[k + 1];
        y[k] = row * reciprocals[k];
        sum += y[k] * y[k];
    }
    let left = ((theta - alpha[0]) * y[0] - behind).abs();
    let reciprocal = 1.0 / sum.sqrt();
    let left = if reciprocal > 0.0 {
        left * reciprocal
    } else {
        f32::INFINITY
    };
    (left, y.iter().map(|y| y * reciprocal).collect())
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

/// The larger eigenvalue of the 2 × 2 matrix of a bound and a further row.
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

/// The unit eigenvector to `theta`.
///
/// It is from ratios of entries from the top and from the bottom, which meet where they differ least.
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
