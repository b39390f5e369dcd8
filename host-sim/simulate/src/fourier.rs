//! Discrete Fourier transforms of a power of two, with equal bits on every machine.
//!
//! Stockham's radix-2 transform in f64: `+ − ×` in a fixed order, and twiddle factors from `libm`.

use std::f64::consts::TAU;

use num_complex::Complex;

/// Plan of one size.
pub struct Fourier {
    twiddles: Vec<Complex<f64>>,
}

impl Fourier {
    /// Transforms of `n` points, a power of two.
    pub fn new(n: usize) -> Self {
        assert!(n.is_power_of_two());
        let twiddles = (0..n / 2).map(|k| unit(-(k as f64) / n as f64)).collect();
        Fourier { twiddles }
    }

    /// X\[k\] = Σ x\[n\]·e^{−j2πkn/N}, in place.
    pub fn forward(&self, x: &mut Vec<Complex<f64>>, scratch: &mut Vec<Complex<f64>>) {
        self.transform(x, scratch, false);
    }

    /// x\[n\] = Σ X\[k\]·e^{+j2πkn/N}, in place, without a factor.
    pub fn inverse(&self, x: &mut Vec<Complex<f64>>, scratch: &mut Vec<Complex<f64>>) {
        self.transform(x, scratch, true);
    }

    fn transform(&self, x: &mut Vec<Complex<f64>>, scratch: &mut Vec<Complex<f64>>, inverse: bool) {
        let n = x.len();
        assert!(n == 1 || n == 2 * self.twiddles.len());
        scratch.resize(n, Complex::default());
        let (mut half, mut stride) = (n / 2, 1);
        while half > 0 {
            let (low, high) = x.split_at(stride * half);
            let blocks = low.chunks_exact(stride).zip(high.chunks_exact(stride));
            for (p, ((a, b), out)) in blocks.zip(scratch.chunks_exact_mut(2 * stride)).enumerate() {
                let mut w = self.twiddles[p * stride];
                if inverse {
                    w.im = -w.im;
                }
                let (sums, differences) = out.split_at_mut(stride);
                for q in 0..stride {
                    sums[q] = a[q] + b[q];
                    differences[q] = (a[q] - b[q]) * w;
                }
            }
            std::mem::swap(x, scratch);
            half /= 2;
            stride *= 2;
        }
    }
}

/// e^{j2π·cycles}.
pub fn unit(cycles: f64) -> Complex<f64> {
    // Whole cycles taken off first, exactly: the angle stays small and its rounding, too.
    let (sin, cos) = libm::sincos(TAU * (cycles - libm::rint(cycles)));
    Complex::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sum of its definition; tolerance: some tens of roundings of 1e-16 on sums of 64.
    #[test]
    fn transforms_are_their_defining_sums() {
        for n in [1usize, 2, 8, 64] {
            let x: Vec<Complex<f64>> = (0..n)
                .map(|k| Complex::new(((k * k) % 7) as f64 - 3.0, ((3 * k) % 5) as f64))
                .collect();
            let plan = Fourier::new(n);
            for inverse in [false, true] {
                let sign = if inverse { 1.0 } else { -1.0 };
                let mut found = x.clone();
                plan.transform(&mut found, &mut Vec::new(), inverse);
                for (k, value) in found.iter().enumerate() {
                    let sum: Complex<f64> = (x.iter().enumerate())
                        .map(|(m, v)| v * unit(sign * (k * m % n) as f64 / n as f64))
                        .sum();
                    assert!((value - sum).norm() < 1e-12, "{n} {k}");
                }
            }
        }
    }
}
