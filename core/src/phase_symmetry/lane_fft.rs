//! Fourier transform over lanes, with the operations of `microfft` in its order.
//!
//! Radix 2, decimation in time. Every lane of any vector has microfft's numbers; zeros may differ in sign, which
//! Eq. 10 ignores. Lines in lanes need no shuffles on any instruction set. Two levels of butterflies are computed
//! at a time in registers, which halves the memory traffic. The second level's twiddles W and −i·W differ by an
//! exact turn, so one product serves both. The order of the roundings stays radix 2's.

use super::fft::{Fft, LONGEST, Microfft, is_supported};
use crate::simd::Vector;
use num_complex::Complex;

/// The transform of lines in lanes, with its twiddle factors.
#[derive(Clone, Debug)]
pub struct LaneFft {
    /// `exp(−2πik/N)`, `k < N/2`, for the longest line N; shorter lines take every second, fourth, … one.
    twiddles: [Complex<f32>; LONGEST / 2],
}

impl LaneFft {
    /// Size in bytes.
    pub const BYTES: usize = size_of::<Self>();

    /// Twiddle factors, read from microfft's transform of a unit impulse at 1.
    pub fn new() -> Self {
        let zero = Complex::new(0.0, 0.0);
        let mut line = [zero; LONGEST];
        Microfft.transform(
            |n| Complex::new(if n == 1 { 1.0 } else { 0.0 }, 0.0),
            &mut line,
        );
        let mut twiddles = [zero; LONGEST / 2];
        for (twiddle, bin) in twiddles.iter_mut().zip(line) {
            *twiddle = bin;
        }
        LaneFft { twiddles }
    }

    /// Twiddle `k` of a transform of `length` points, in every lane.
    #[inline(always)]
    fn twiddle<V: Vector>(&self, zero: V, k: usize, length: usize) -> Complex<V> {
        let twiddle = self.twiddles[(k * (LONGEST / length)) % (LONGEST / 2)];
        Complex::new(zero.splat(twiddle.re), zero.splat(twiddle.im))
    }

    /// One level: halves of `half` points become transforms of twice as many.
    #[inline(always)]
    fn level<V: Vector>(&self, zero: V, half: usize, line: &mut [Complex<V>]) {
        for block in line.chunks_exact_mut(2 * half) {
            let (even, odd) = block.split_at_mut(half);
            for (k, (a, b)) in even.iter_mut().zip(odd).enumerate() {
                let rotated = product(self.twiddle(zero, k, 2 * half), *b);
                (*a, *b) = (sum(*a, rotated), difference(*a, rotated));
            }
        }
    }

    /// Two levels: quarters of `quarter` points become transforms of four times as many.
    #[inline(always)]
    fn two_levels<V: Vector>(&self, zero: V, quarter: usize, line: &mut [Complex<V>]) {
        for block in line.chunks_exact_mut(4 * quarter) {
            let (even, odd) = block.split_at_mut(2 * quarter);
            let (a, b) = even.split_at_mut(quarter);
            let (c, d) = odd.split_at_mut(quarter);
            for (k, (((a, b), c), d)) in a.iter_mut().zip(b).zip(c).zip(d).enumerate() {
                let first = self.twiddle(zero, k, 2 * quarter);
                let second = self.twiddle(zero, k, 4 * quarter);
                let (turned_b, turned_d) = (product(first, *b), product(first, *d));
                let (a1, b1) = (sum(*a, turned_b), difference(*a, turned_b));
                let (c1, d1) = (sum(*c, turned_d), difference(*c, turned_d));
                let (turned_c, turned_d) = (product(second, c1), product(second, d1));
                (*a, *c) = (sum(a1, turned_c), difference(a1, turned_c));
                (*b, *d) = sum_and_difference_at_minus_i(b1, turned_d);
            }
        }
    }
}

impl Default for LaneFft {
    fn default() -> Self {
        Self::new()
    }
}

impl<V: Vector> Fft<V> for LaneFft {
    #[inline(always)]
    fn transform(&self, input: impl Fn(usize) -> Complex<V>, line: &mut [Complex<V>]) {
        let length = line.len();
        if !is_supported(length) {
            return;
        }
        let bits = length.trailing_zeros();
        // Two levels without products. The input is read in four runs of consecutive indices, as memory is read
        // fastest; the output is in bit-reversed order.
        for at in 0..length / 4 {
            // A quarter of the longest line is counted by eight bits.
            let k = usize::from((at as u8).reverse_bits() >> (u8::BITS + 2 - bits));
            let Some(block) = line.as_chunks_mut::<4>().0.get_mut(k) else {
                return;
            };
            let (a, b) = (input(at), input(at + length / 2));
            let (c, d) = (input(at + length / 4), input(at + 3 * length / 4));
            let (a, b) = (sum(a, b), difference(a, b));
            let (c, d) = (sum(c, d), difference(c, d));
            let (second, fourth) = sum_and_difference_at_minus_i(b, d);
            *block = [sum(a, c), second, difference(a, c), fourth];
        }
        let Some(zero) = line.first().map(|bin| bin.re.zero()) else {
            return;
        };
        let mut done = 4;
        if !bits.is_multiple_of(2) {
            self.level(zero, done, line);
            done *= 2;
        }
        while done < length {
            self.two_levels(zero, done, line);
            done *= 4;
        }
    }
}

#[inline(always)]
fn sum<V: Vector>(a: Complex<V>, b: Complex<V>) -> Complex<V> {
    Complex::new(a.re + b.re, a.im + b.im)
}

#[inline(always)]
fn difference<V: Vector>(a: Complex<V>, b: Complex<V>) -> Complex<V> {
    Complex::new(a.re - b.re, a.im - b.im)
}

/// `a − i·b` and `a + i·b`.
#[inline(always)]
fn sum_and_difference_at_minus_i<V: Vector>(
    a: Complex<V>,
    b: Complex<V>,
) -> (Complex<V>, Complex<V>) {
    let minus = Complex::new(a.re + b.im, a.im - b.re);
    let plus = Complex::new(a.re - b.im, a.im + b.re);
    (minus, plus)
}

#[inline(always)]
fn product<V: Vector>(a: Complex<V>, b: Complex<V>) -> Complex<V> {
    Complex::new(a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re)
}
