//! Gauss–Legendre quadrature.

use std::f64::consts::PI;

/// Nodes in (−1, 1) and weights, whose sum is 2.
///
/// Exact for polynomials of degree 2n − 1. The nodes are the roots of the Legendre polynomial, by Newton's
/// iteration.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let polynomial = |x: f64| {
        let (mut before, mut last) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (before, last) = (last, ((2.0 * k - 1.0) * x * last - (k - 1.0) * before) / k);
        }
        (last, n as f64 * (x * last - before) / (x * x - 1.0))
    };
    let root = |k: usize| {
        let mut x = libm::cos(PI * (k as f64 + 0.75) / (n as f64 + 0.5));
        for _ in 0..8 {
            let (value, slope) = polynomial(x);
            x -= value / slope;
        }
        let (_, slope) = polynomial(x);
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(root).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ x^d over (−1, 1) is 2/(d + 1) for even d; tolerance: roundings of 1e-16 over 20 terms.
    #[test]
    fn polynomials_are_integrated_exactly() {
        for n in [2usize, 5, 12, 20] {
            for degree in (0..2 * n as i32).step_by(2) {
                let sum: f64 = gauss_legendre(n)
                    .iter()
                    .map(|(x, w)| w * x.powi(degree))
                    .sum();
                let exact = 2.0 / f64::from(degree + 1);
                assert!((sum - exact).abs() < 1e-13, "{n} {degree}: {sum}");
            }
        }
    }
}
