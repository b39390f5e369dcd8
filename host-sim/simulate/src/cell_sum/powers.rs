//! Powers of a complex number, and products, in vectors of frequencies.

use bonebeam::simd::{ComplexVector, Vector};
use num_complex::Complex;

/// Frequencies whose phases derive from one base.
///
/// It is a whole number of vectors for every instruction set.
pub const GROUP: usize = 16;

/// a·b^k for k = 0, 1, …, by groups.
///
/// Each group has one base in f64, times b⁰ … b¹⁵.
pub struct Powers {
    base: Complex<f64>,
    /// b¹⁶.
    next: Complex<f64>,
    re: [f32; GROUP],
    im: [f32; GROUP],
}

impl Powers {
    /// The powers of `ratio`, times `first`.
    #[inline(always)]
    pub fn new(first: Complex<f64>, ratio: Complex<f64>) -> Self {
        let mut powers = [Complex::new(1.0, 0.0); GROUP + 1];
        powers[1] = ratio;
        for k in 2..=GROUP {
            powers[k] = powers[k / 2] * powers[k - k / 2];
        }
        Powers {
            base: first,
            next: powers[GROUP],
            re: std::array::from_fn(|k| powers[k].re as f32),
            im: std::array::from_fn(|k| powers[k].im as f32),
        }
    }

    /// The vector of frequencies `vector`; vectors must be requested in order.
    #[inline(always)]
    pub fn get<V: Vector>(&mut self, zero: V, vector: usize) -> ComplexVector<V> {
        let k = vector * V::LANES % GROUP;
        if k == 0 && vector > 0 {
            self.base *= self.next;
        }
        let (re, im) = (
            zero.splat(self.base.re as f32),
            zero.splat(self.base.im as f32),
        );
        let (mut c, mut s) = (zero, zero);
        c.lanes_mut().copy_from_slice(&self.re[k..k + V::LANES]);
        s.lanes_mut().copy_from_slice(&self.im[k..k + V::LANES]);
        ComplexVector::new(re * c - im * s, re * s + im * c)
    }
}

/// sum + a·b.
#[inline(always)]
pub fn plus_product<V: Vector>(
    sum: ComplexVector<V>,
    a: ComplexVector<V>,
    b: ComplexVector<V>,
) -> ComplexVector<V> {
    ComplexVector::new(
        sum.re + (a.re * b.re - a.im * b.im),
        sum.im + (a.re * b.im + a.im * b.re),
    )
}
