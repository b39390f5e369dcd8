//! Cosine and sine of a phase in cycles, by two polynomials.
//!
//! With x the distance to the nearest whole cycle, −½..½, and y = x²:
//!
//! cos 2πx ≈ 1 + y·(C₁ + y·(C₂ + y·(C₃ + y·(C₄ + y·C₅)))) and
//! sin 2πx ≈ x·(S₀ + y·(S₁ + y·(S₂ + y·(S₃ + y·S₄)))).
//!
//! The coefficients minimise the largest error over −½..½ (least squares, reweighted until the error is level). The
//! polynomials err by 8.7·10⁻⁷ and 5.9·10⁻⁶. With rounding the cosine is right to 2·10⁻⁶ and the sine to 7·10⁻⁶;
//! `the_documented_error_holds` checks steps of 2⁻²⁰ of a cycle. Cost: 23 products, additions and subtractions for
//! both.

use crate::simd::Vector;

/// 1.5·2²³: adding and subtracting it rounds a number below 2²² to an integer.
const INTEGERS: f32 = 12_582_912.0;

/// C₁ to C₅.
const COSINE: [f32; 5] = [-19.739_05, 64.930_28, -85.286_85, 58.852_547, -21.162_6];
/// S₀ to S₄.
const SINE: [f32; 5] = [6.283_056, -41.331_215, 81.366_81, -74.478, 32.781_4];

/// cos 2πφ and sin 2πφ of a phase φ in cycles, below 2²² in magnitude.
#[inline(always)]
pub(super) fn phasor<V: Vector>(cycles: V) -> (V, V) {
    let integers = cycles.splat(INTEGERS);
    let x = cycles - ((cycles + integers) - integers);
    let y = x * x;
    let mut cosine = cycles.splat(COSINE[4]);
    let mut sine = cycles.splat(SINE[4]);
    for k in (0..4).rev() {
        cosine = cosine * y + cycles.splat(COSINE[k]);
        sine = sine * y + cycles.splat(SINE[k]);
    }
    (cycles.splat(1.0) + cosine * y, sine * x)
}

/// [`phasor`] for constants, from 0 to 1 cycle, by the same operations.
pub(super) const fn constant_phasor(cycles: f32) -> (f32, f32) {
    let x = cycles - ((cycles + INTEGERS) - INTEGERS);
    let y = x * x;
    let (mut cosine, mut sine) = (COSINE[4], SINE[4]);
    let mut k = 4;
    while k > 0 {
        k -= 1;
        cosine = cosine * y + COSINE[k];
        sine = sine * y + SINE[k];
    }
    (1.0 + cosine * y, sine * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documented_error_holds() {
        let mut worst = [0.0f64; 2];
        // A whole cycle either way, in steps of 2⁻²⁰, and beside them.
        for step in (-(1 << 20)..=1 << 20).step_by(crate::step(99_991)) {
            for aside in [0.0, 3e-7] {
                let cycles = step as f32 / (1 << 20) as f32 + aside;
                let (cosine, sine) = phasor(cycles);
                let angle = 2.0 * core::f64::consts::PI * f64::from(cycles);
                worst[0] = worst[0].max(libm::fabs(f64::from(cosine) - libm::cos(angle)));
                worst[1] = worst[1].max(libm::fabs(f64::from(sine) - libm::sin(angle)));
            }
        }
        assert!(worst[0] < 2e-6 && worst[1] < 7e-6, "{worst:?}");
    }

    #[test]
    fn whole_cycles_do_not_matter() {
        for cycles in [0.0f32, 0.25, 0.3125, -0.4375] {
            let (cosine, sine) = phasor(cycles);
            for whole in [1.0, -3.0, 1024.0, 65536.0] {
                let (c, s) = phasor(cycles + whole);
                assert_eq!(
                    (c.to_bits(), s.to_bits()),
                    (cosine.to_bits(), sine.to_bits())
                );
            }
        }
        assert_eq!(phasor(0.0), (1.0, 0.0));
    }
}
