//! Diagonal loading, and the scale at which the solvers work.

use crate::lanes::{Lanes, Scalar};

/// Below this share of the line's largest power a sample counts as zero: 300 dB.
const NOTHING: f32 = f32::from_bits((127 - 100) << 23); // 2^-100

/// Scales the lower triangle of `a` by a power of two so that its trace lies in `[1, 2)`, then
/// adds `Δ/L·tr` to the diagonal. Weights do not depend on the scale.
///
/// Returns the lanes whose trace is zero (or below `2⁻¹⁰⁰`); their matrix becomes the identity, so
/// that the solvers stay finite, and their output is to be zero.
#[inline]
pub fn load<S: Scalar<W>, const L: usize, const W: usize>(
    a: &mut [[S; L]; L],
    subarray: usize,
    loading: f32,
) -> [bool; W] {
    let mut trace = Lanes::ZERO;
    for i in 0..subarray {
        trace += a[i][i].real();
    }
    let silent: [bool; W] = core::array::from_fn(|k| trace.0[k] < NOTHING);
    // 2^-e for a trace in [2^e, 2^(e+1)); exact, and exact to multiply with.
    let factor = Lanes(core::array::from_fn(|k| {
        let exponent = (trace.0[k].to_bits() >> 23) & 0xff;
        if silent[k] || exponent > 253 {
            0.0
        } else {
            f32::from_bits((254 - exponent) << 23)
        }
    }));
    let added = Lanes::splat(loading / subarray as f32) * (trace * factor);
    let added = Lanes::select(silent, Lanes::splat(1.0), added);
    for i in 0..subarray {
        for j in 0..i {
            a[i][j] = a[i][j].scale(factor);
        }
        a[i][i] = S::from_real(a[i][i].real() * factor + added);
    }
    silent
}
