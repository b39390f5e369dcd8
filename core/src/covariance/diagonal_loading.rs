//! Diagonal loading, and the scale at which the solvers work.

use crate::simd::Vector;

/// Below this share of the line's largest power a sample counts as zero: 300 dB.
const NOTHING: f32 = f32::from_bits((127 - 100) << 23); // 2^-100

/// Scale and loading that turn a covariance into the solvers' matrix.
///
/// Each entry is multiplied by `factor`, and `added` is added to the diagonal. Weights do not depend on the scale.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DiagonalLoading<V: Vector> {
    /// Power of two that brings the trace into `[1, 2)`.
    ///
    /// The factor and products with it are exact.
    pub factor: V,
    /// `Δ/L·tr` at that scale.
    pub added: V,
    /// Lanes whose trace is zero or below `2⁻¹⁰⁰`.
    ///
    /// Their matrix becomes the identity, so that the solvers stay finite. Their output is set to zero.
    pub zero_power: V::Mask,
}

impl<V: Vector> DiagonalLoading<V> {
    /// Computes the loading `Δ` of a matrix of `subaperture` rows.
    #[inline(always)]
    pub fn new(trace: V, subaperture: usize, diagonal_loading: f32) -> Self {
        let zero_power = trace.less(trace.splat(NOTHING));
        let mut factor = trace.zero();
        for (factor, trace) in factor.lanes_mut().iter_mut().zip(trace.lanes()) {
            // 2^-e for a trace in [2^e, 2^(e+1)).
            let exponent = (trace.to_bits() >> 23) & 0xff;
            if *trace >= NOTHING && exponent <= 253 {
                *factor = f32::from_bits((254 - exponent) << 23);
            }
        }
        let added = trace.splat(diagonal_loading / subaperture as f32) * (trace * factor);
        DiagonalLoading {
            factor,
            added: V::select(zero_power, trace.splat(1.0), added),
            zero_power,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_below_300_db_has_zero_power() {
        let root = 1.0 / (1u64 << 50) as f32;
        let least = root * root;
        let loading = DiagonalLoading::new(least, 4, 0.05);
        assert!(!loading.zero_power && loading.factor * least == 1.0);
        let loading = DiagonalLoading::new(least.next_down(), 4, 0.05);
        assert!(loading.zero_power && loading.factor == 0.0 && loading.added == 1.0);
    }
}
