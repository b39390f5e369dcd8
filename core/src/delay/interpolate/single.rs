//! The windowed sinc in f32, for filters made on processors with f64 in software.

use core::f32::consts::PI;

/// Terms of the series of I₀, enough for β ≤ 10: the rest is below 10⁻⁸ of it.
const TERMS: usize = 22;
/// 1/(k!)².
const BESSEL: [f32; TERMS] = {
    let mut coefficients = [0.0; TERMS];
    let (mut k, mut coefficient) = (0, 1.0f64);
    while k < TERMS {
        if k > 0 {
            coefficient /= (k * k) as f64;
        }
        coefficients[k] = coefficient as f32;
        k += 1;
    }
    coefficients
};
/// Taylor series of sin πx over x, in x²; it errs by 6·10⁻⁸ at x = ½.
const SINE: [f32; 6] = [
    PI,
    -5.167_712_7,
    2.550_164,
    -0.599_264_5,
    0.082_145_89,
    -0.007_370_43,
];
/// 1.5·2²³: adding and subtracting it rounds a number below 2²² to an integer.
const INTEGERS: f32 = 12_582_912.0;

/// κ·sinc(κu)·kaiser(u/half, β).
pub(super) struct Filter {
    cutoff: f32,
    /// 1/half.
    width: f32,
    /// (β/2)².
    square: f32,
    /// κ/I₀(β).
    scale: f32,
}

impl Filter {
    pub(super) fn new(cutoff: f32, beta: f32, half: f32) -> Self {
        let square = (0.5 * beta) * (0.5 * beta);
        Filter {
            cutoff,
            width: 1.0 / half,
            square,
            scale: cutoff / bessel_i0(square),
        }
    }

    /// Its value `u` samples from its middle. Order, f32: p = u·width; w = I₀ of square·(1 − p·p), 0 beyond the
    /// support; x = κ·u; r = x less the nearest integer; s = r·(polynomial of r·r), negative where that
    /// integer is odd; `(scale·w)·(s/(π·x))`, or `scale·w` where x = 0.
    pub(super) fn at(&self, u: f32) -> f32 {
        let position = u * self.width;
        let inside = 1.0 - position * position;
        if inside < 0.0 {
            return 0.0;
        }
        let window = self.scale * bessel_i0(self.square * inside);
        let x = self.cutoff * u;
        if x == 0.0 {
            return window;
        }
        window * (sin_pi(x) / (PI * x))
    }
}

/// sin πx of an x below 2²² in magnitude.
fn sin_pi(x: f32) -> f32 {
    let whole = (x + INTEGERS) - INTEGERS;
    let r = x - whole;
    let square = r * r;
    let sum = SINE.iter().rev().fold(0.0, |sum, c| sum * square + c);
    let sine = r * sum;
    if whole as i32 & 1 == 0 { sine } else { -sine }
}

/// The modified Bessel function I₀(x) of `square` = (x/2)², by Horner's rule.
fn bessel_i0(square: f32) -> f32 {
    BESSEL.iter().rev().fold(0.0, |sum, c| sum * square + c)
}
