//! Vectors of three, and the eigenvectors of small symmetric matrices.

pub use bonebeam_simulate::V3;
pub(crate) use bonebeam_simulate::{cross, dot, norm, sub};

pub(crate) fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn scale(a: V3, by: f64) -> V3 {
    a.map(|v| v * by)
}

/// The vector of length 1; zero stays zero.
pub(crate) fn unit(a: V3) -> V3 {
    match norm(a) {
        0.0 => a,
        length => scale(a, 1.0 / length),
    }
}

/// The mean of some points; zero of none.
pub(crate) fn mean(points: impl IntoIterator<Item = V3>) -> V3 {
    let (sum, count) = points
        .into_iter()
        .fold(([0.0; 3], 0usize), |(sum, count), p| {
            (add(sum, p), count + 1)
        });
    scale(sum, 1.0 / count.max(1) as f64)
}

/// Eigenvalues in ascending order, and the eigenvectors as rows.
///
/// Jacobi's rotations in cyclic order (Golub and Van Loan, Matrix Computations, section 8.5).
pub(crate) fn symmetric_eigen<const N: usize>(mut a: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut vectors = [[0.0; N]; N];
    for k in 0..N {
        vectors[k][k] = 1.0;
    }
    for _sweep in 0..30 {
        let pairs = || (0..N).flat_map(|i| (i + 1..N).map(move |j| (i, j)));
        let off: f64 = pairs().map(|(i, j)| a[i][j] * a[i][j]).sum();
        let trace: f64 = (0..N).map(|i| a[i][i] * a[i][i]).sum();
        if off <= 1e-30 * trace {
            break;
        }
        for (i, j) in pairs() {
            if a[i][j] == 0.0 {
                continue;
            }
            let theta = (a[j][j] - a[i][i]) / (2.0 * a[i][j]);
            let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
            let (c, s) = (1.0 / t.hypot(1.0), t / t.hypot(1.0));
            for k in 0..N {
                (a[k][i], a[k][j]) = (c * a[k][i] - s * a[k][j], s * a[k][i] + c * a[k][j]);
            }
            for k in 0..N {
                (a[i][k], a[j][k]) = (c * a[i][k] - s * a[j][k], s * a[i][k] + c * a[j][k]);
                let (v, w) = (vectors[i][k], vectors[j][k]);
                (vectors[i][k], vectors[j][k]) = (c * v - s * w, s * v + c * w);
            }
        }
    }
    let mut order: [usize; N] = std::array::from_fn(|k| k);
    order.sort_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
    (order.map(|k| a[k][k]), order.map(|k| vectors[k]))
}

/// The product of a matrix and a vector.
pub(crate) fn image<const N: usize>(a: &[[f64; N]; N], v: &[f64; N]) -> [f64; N] {
    a.map(|row| row.iter().zip(v).map(|(a, v)| a * v).sum())
}

/// `b·a·bᵀ` of a symmetric a.
pub(crate) fn congruent<const N: usize>(a: &[[f64; N]; N], b: &[[f64; N]; N]) -> [[f64; N]; N] {
    let images = b.map(|row| image(a, &row));
    b.map(|row| image(&images, &row))
}

/// Principal axes of some points, the longest first.
pub(crate) fn principal_axes(points: &[V3]) -> [V3; 3] {
    let centre = mean(points.iter().copied());
    let mut scatter = [[0.0; 3]; 3];
    for p in points {
        let p = sub(*p, centre);
        for i in 0..3 {
            for j in 0..3 {
                scatter[i][j] += p[i] * p[j];
            }
        }
    }
    let [short, middle, long] = symmetric_eigen(scatter).1;
    [long, middle, short]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_rebuild_their_matrix() {
        let entry = |i: usize, j: usize| 1.0 / (1.0 + (i + j) as f64) + f64::from(i == j);
        let a: [[f64; 6]; 6] = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        let (values, vectors) = symmetric_eigen(a);
        assert!(values.is_sorted());
        for i in 0..6 {
            for j in 0..6 {
                let rebuilt: f64 = (0..6)
                    .map(|k| values[k] * vectors[k][i] * vectors[k][j])
                    .sum();
                assert!((rebuilt - a[i][j]).abs() < 1e-13, "{i} {j}");
            }
        }
    }
}
