//! The transform of one line of 64 points, three levels at a time in registers.
//!
//! Radix 2, decimation in time, with microfft's operations in its order, so that the numbers are microfft's. A pass
//! reads eight points, computes three levels and writes them. Each point is read and written twice, instead of
//! seven times level by level. The points take sixteen of the 32 registers of a Cortex-M7's FPU. Cost: 1.9 thousand
//! instructions instead of 3.4.

use crate::sine::sin;
use core::f64::consts::TAU;
use num_complex::Complex;

/// Points.
pub(super) const POINTS: usize = 64;
/// Points of a pass's butterfly.
const RADIX: usize = 8;

/// Three bits in reverse.
const REVERSED: [usize; RADIX] = [0, 4, 2, 6, 1, 5, 3, 7];

/// For points `k + 8j` of the second pass the twiddles `W₁₆ᵏ`, `W₃₂ᵏ`, `W₆₄ᵏ` and `W₆₄ᵏ⁺⁸`; the others are these turned
/// by −i.
static TWIDDLES: [[Complex<f32>; 4]; RADIX] = {
    let mut twiddles = [[Complex::new(0.0, 0.0); 4]; RADIX];
    let mut k = 0;
    while k < RADIX {
        twiddles[k] = [
            twiddle(k, 16),
            twiddle(k, 32),
            twiddle(k, 64),
            twiddle(k + 8, 64),
        ];
        k += 1;
    }
    twiddles
};

/// `cos π/4`.
const DIAGONAL: f32 = twiddle(1, 8).re;

/// `exp(−2πik/length)`.
const fn twiddle(k: usize, length: usize) -> Complex<f32> {
    let (k, quarter) = (k as f64, length as f64 / 4.0);
    // As sines of angles up to π/2, which are exact at both ends.
    Complex::new(
        sin(TAU * (quarter - k) / length as f64) as f32,
        -(sin(TAU * k / length as f64) as f32),
    )
}

/// `line[k] = Σ input(n)·exp(−2πikn/64)`.
#[inline(always)]
pub(super) fn transform(input: impl Fn(usize) -> Complex<f32>, line: &mut [Complex<f32>; POINTS]) {
    first_pass(input, line);
    for (k, twiddles) in TWIDDLES.iter().enumerate() {
        let points = last_pass(line, k, twiddles);
        for (j, point) in points.into_iter().enumerate() {
            if let Some(to) = line.get_mut(k + RADIX * j) {
                *to = point;
            }
        }
    }
}

/// The same numbers by `output(k, number)`; `line` is scratch.
#[inline(always)]
pub(super) fn transform_to(
    input: impl Fn(usize) -> Complex<f32>,
    line: &mut [Complex<f32>; POINTS],
    mut output: impl FnMut(usize, Complex<f32>),
) {
    first_pass(input, line);
    for (k, twiddles) in TWIDDLES.iter().enumerate() {
        for (j, point) in last_pass(line, k, twiddles).into_iter().enumerate() {
            output(k + RADIX * j, point);
        }
    }
}

/// Transforms of eight points each, in bit-reversed order.
#[inline(always)]
fn first_pass(input: impl Fn(usize) -> Complex<f32>, line: &mut [Complex<f32>; POINTS]) {
    for (block, at) in line.as_chunks_mut::<RADIX>().0.iter_mut().zip(REVERSED) {
        let point = |j| input(at + RADIX * j);
        *block = first_levels([
            point(0),
            point(4),
            point(2),
            point(6),
            point(1),
            point(5),
            point(3),
            point(7),
        ]);
    }
}

/// The points `k + 8j`.
#[inline(always)]
fn last_pass(
    line: &[Complex<f32>; POINTS],
    k: usize,
    twiddles: &[Complex<f32>; 4],
) -> [Complex<f32>; RADIX] {
    let points = core::array::from_fn(
        #[inline(always)]
        |j| line.get(k + RADIX * j).copied().unwrap_or_default(),
    );
    last_levels(points, twiddles)
}

/// Eight points, in bit-reversed order, transformed.
#[inline(always)]
fn first_levels([a, b, c, d, e, f, g, h]: [Complex<f32>; RADIX]) -> [Complex<f32>; RADIX] {
    let [a, b, c, d] = four([a, b, c, d]);
    let [e, f, g, h] = four([e, f, g, h]);
    // W₈ = (1 − i)·cos π/4.
    let (re, im) = (DIAGONAL * f.re, DIAGONAL * f.im);
    let f = Complex::new(re + im, im - re);
    let (re, im) = (DIAGONAL * h.re, DIAGONAL * h.im);
    let h = Complex::new(re + im, im - re);
    let ([c, g], [d, h]) = (turned(c, g), turned(d, h));
    [a + e, b + f, c, d, a - e, b - f, g, h]
}

/// Four points, in bit-reversed order, transformed.
#[inline(always)]
fn four([a, b, c, d]: [Complex<f32>; 4]) -> [Complex<f32>; 4] {
    let [a, b] = [a + b, a - b];
    let [c, d] = [c + d, c - d];
    let [b, d] = turned(b, d);
    [a + c, b, a - c, d]
}

/// Three levels of transforms of 8 points, for eight points of them.
#[inline(always)]
fn last_levels(
    [a, b, c, d, e, f, g, h]: [Complex<f32>; RADIX],
    &[first, second, third, eighth]: &[Complex<f32>; 4],
) -> [Complex<f32>; RADIX] {
    let (b, d, f, h) = (first * b, first * d, first * f, first * h);
    let ([a, b], [c, d]) = ([a + b, a - b], [second * (c + d), second * (c - d)]);
    let ([e, f], [g, h]) = ([e + f, e - f], [second * (g + h), second * (g - h)]);
    let ([b, d], [f, h]) = (turned(b, d), turned(f, h));
    let ([a, c], [e, g]) = ([a + c, a - c], [e + g, e - g]);
    let (e, f, g, h) = (third * e, eighth * f, third * g, eighth * h);
    let ([c, g], [d, h]) = (turned(c, g), turned(d, h));
    [a + e, b + f, c, d, a - e, b - f, g, h]
}

/// `a − i·b` and `a + i·b`.
#[inline(always)]
fn turned(a: Complex<f32>, b: Complex<f32>) -> [Complex<f32>; 2] {
    [
        Complex::new(a.re + b.im, a.im - b.re),
        Complex::new(a.re - b.im, a.im + b.re),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_microffts() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 - 8e6
        };
        for only in 0..=POINTS {
            // Single points, then all.
            let mut input = [Complex::new(0.0, 0.0); POINTS];
            for (k, point) in input.iter_mut().enumerate() {
                let number = Complex::new(random(), random());
                if only == k || only == POINTS {
                    *point = number;
                }
            }
            let microfft = *microfft::complex::cfft_64(&mut input.clone());
            let [mut line, mut work] = [[Complex::new(7.0, 7.0); POINTS]; 2];
            transform(|n| input[n], &mut work);
            assert_eq!(work, microfft);
            transform_to(|n| input[n], &mut work, |k, point| line[k] = point);
            assert_eq!(line, microfft);
        }
    }
}
