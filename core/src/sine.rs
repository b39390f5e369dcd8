//! The sine as a `const fn`, for filters as constants. In f64.
//!
//! The operations and bits are those of libm's `sin`. At the odd multiples of π/4 the two may subtract different
//! multiples of π/2. The operations are FreeBSD's:
//!
//! ```text
//! Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
//! Developed at SunPro, a Sun Microsystems, Inc. business.
//! Permission to use, copy, modify, and distribute this software is freely granted, provided that this
//! notice is preserved.
//! ```

use core::f64::consts::{FRAC_2_PI, FRAC_PI_4};

/// π/2 in parts of 33 bits, and its remainder after each part.
const HALF_PI: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    f64::from_bits(0x3BA3_198A_2E00_0000),
];
const LEFT: [f64; 3] = [
    f64::from_bits(0x3DD0_B461_1A62_6331),
    f64::from_bits(0x3BA3_198A_2E03_7073),
    f64::from_bits(0x397B_839A_2520_49C1),
];
/// Bits of cancellation after which the next part of π/2 is subtracted.
///
/// This is a Cody-Waite reduction.
const CANCELLED: [i32; 2] = [16, 49];
/// 1.5·2⁵²: a number that it is added to is rounded to an integer.
const INTEGERS: f64 = 6_755_399_441_055_744.0;

/// The polynomials of sine and cosine, from x³ and x⁴ on.
const SINE: [f64; 6] = [
    f64::from_bits(0xBFC5_5555_5555_5549),
    f64::from_bits(0x3F81_1111_1110_F8A6),
    f64::from_bits(0xBF2A_01A0_19C1_61D5),
    f64::from_bits(0x3EC7_1DE3_57B1_FE7D),
    f64::from_bits(0xBE5A_E5E6_8A2B_9CEB),
    f64::from_bits(0x3DE5_D93A_5ACF_D57C),
];
const COSINE: [f64; 6] = [
    f64::from_bits(0x3FA5_5555_5555_554C),
    f64::from_bits(0xBF56_C16C_16C1_5177),
    f64::from_bits(0x3EFA_01A0_19CB_1590),
    f64::from_bits(0xBE92_7E4F_809C_52AD),
    f64::from_bits(0x3E21_EE9E_BDB4_B1C4),
    f64::from_bits(0xBDA8_FAE9_BE88_38D4),
];

/// The sine of an angle below 2²⁰ in magnitude.
pub(crate) const fn sin(angle: f64) -> f64 {
    if angle >= -FRAC_PI_4 && angle <= FRAC_PI_4 {
        let (cube, rest) = odd(angle);
        return angle + cube * (SINE[0] + angle * angle * rest);
    }
    let quarters = (angle * FRAC_2_PI + INTEGERS) - INTEGERS;
    let mut left = angle - quarters * HALF_PI[0];
    let mut taken = quarters * LEFT[0];
    let mut within = left - taken;
    let mut part = 1;
    while part < 3 && exponent(angle) - exponent(within) > CANCELLED[part - 1] {
        let before = left;
        taken = quarters * HALF_PI[part];
        left = before - taken;
        taken = quarters * LEFT[part] - ((before - left) - taken);
        within = left - taken;
        part += 1;
    }
    let below = (left - within) - taken;
    let value = if quarters as i32 & 1 == 0 {
        let (cube, rest) = odd(within);
        within - ((within * within * (0.5 * below - cube * rest) - below) - cube * SINE[0])
    } else {
        cosine(within, below)
    };
    if quarters as i32 & 2 == 0 {
        value
    } else {
        -value
    }
}

/// x³, and the sine's polynomial from x⁵ on, over that and x².
const fn odd(x: f64) -> (f64, f64) {
    let z = x * x;
    let rest = SINE[1] + z * (SINE[2] + z * SINE[3]) + z * (z * z) * (SINE[4] + z * SINE[5]);
    (z * x, rest)
}

/// The cosine of `x + below`, for angles up to π/4.
const fn cosine(x: f64, below: f64) -> f64 {
    let z = x * x;
    let square = z * z;
    let low = z * (COSINE[0] + z * (COSINE[1] + z * COSINE[2]));
    let rest = low + square * square * (COSINE[3] + z * (COSINE[4] + z * COSINE[5]));
    let half = 0.5 * z;
    let first = 1.0 - half;
    first + (((1.0 - first) - half) + (z * rest - x * below))
}

const fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52) as i32 & 0x7ff
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    #[test]
    fn the_bits_are_those_of_libm() {
        let same = |angle: f64| {
            assert_eq!(sin(angle).to_bits(), libm::sin(angle).to_bits(), "{angle}");
        };
        for step in (-200_000..=200_000).step_by(crate::step(3989)) {
            same(f64::from(step) * 3.1e-4);
        }
        // Over the whole range; where 16 bits cancel, and one more or fewer part would round otherwise;
        // and where the second part counts.
        for step in (-200_000..=200_000).step_by(crate::step(3989)) {
            same(f64::from(step) * 5.24);
        }
        for angle in [
            45_307.370_749_564_61,
            49_070.760_460_651_83,
            466_384.567_175_949,
        ] {
            same(angle);
        }
        // Around the multiples of π/2, where bits cancel. Halfway between them either may be subtracted.
        for quarter in (-80..=80).step_by(crate::step(16)) {
            let at = f64::from(quarter) * PI / 2.0;
            for ulp in 0..4 {
                same(f64::from_bits(at.to_bits() + ulp));
                same(f64::from_bits(at.to_bits().saturating_sub(ulp)));
            }
            for part in 1..40 {
                let beside = libm::exp2(f64::from(-part));
                same(at + beside);
                same(at - beside);
            }
        }
    }
}
