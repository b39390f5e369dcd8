//! Postfilters: a real factor for each sample, from the aligned samples, that multiplies a method's output.

use super::segment::{Segment, SegmentGroup};
use super::snapshot::gather;
use super::table::{Parameter, choices};
use crate::simd::{ComplexVector, Scalar, Vector};
use num_complex::Complex;

choices! {
    /// A postfilter: the factor that multiplies the output of any [`Method`](super::Method).
    Postfilter {
        /// No postfilter.
        None, "none", "no postfilter";
        /// Coherence factor `|Σx_m|²/(M·Σ|x_m|²)` over the `M` active elements, 0 to 1.
        CoherenceFactor, "coherence-factor", "CF";
    }
}

/// Active elements that are gathered at a time.
const BLOCK: usize = 8;

/// Multiplies `z[lane][i]`, sample `first_sample + i` of its segment, by the factor of that sample.
#[inline(always)]
pub(super) fn postfilter<V: Vector>(
    postfilter: Postfilter,
    zero: V,
    group: SegmentGroup<'_, '_>,
    z: &mut [&mut [Complex<f32>]],
) {
    if postfilter != Postfilter::None {
        apply(postfilter, zero, group, z);
    }
}

/// Apart, so that a beamformer without a postfilter pays one comparison a segment.
#[cold]
#[inline(never)]
fn apply<V: Vector>(
    postfilter: Postfilter,
    zero: V,
    group: SegmentGroup<'_, '_>,
    z: &mut [&mut [Complex<f32>]],
) {
    match postfilter {
        Postfilter::None => {}
        Postfilter::CoherenceFactor => multiply(
            zero,
            z,
            #[inline(always)]
            |i| coherence(zero, group.segments, i, group.count),
        ),
    }
}

/// Multiplies `z[lane][i]` by lane `lane` of `factor(i)`.
#[inline(never)]
fn multiply<V: Vector>(zero: V, z: &mut [&mut [Complex<f32>]], factor: impl Fn(isize) -> V) {
    let longest = z.iter().map(|z| z.len()).max().unwrap_or(0);
    zero.vectorize(
        #[inline(always)]
        || {
            for i in 0..longest {
                let factor = factor(i as isize);
                for (z, &factor) in z.iter_mut().zip(factor.lanes()) {
                    if let Some(z) = z.get_mut(i) {
                        *z *= factor;
                    }
                }
            }
        },
    );
}

/// The coherence factor of each segment's sample `i`: both sums ascending from zero, at the line's working scale,
/// so that squares neither overflow nor, above −300 dB of the line's largest sample, underflow. A sample
/// without power has the factor 0. Rounding is cut at 1.
#[inline(always)]
fn coherence<V: Vector>(zero: V, segments: &[Segment<'_>], i: isize, count: usize) -> V {
    let zero = zero.zero();
    let mut sum = ComplexVector::from_real(zero);
    let mut power = zero;
    let mut block = [sum; BLOCK];
    for first in (0..count).step_by(BLOCK) {
        let Some(block) = block.get_mut(..(count - first).min(BLOCK)) else {
            return zero;
        };
        gather(zero, segments, i, first, block);
        for &mut x in block {
            sum = sum + x;
            power = power + x.norm_sqr();
        }
    }
    let one = zero.splat(1.0);
    let factor = sum.norm_sqr() / (power * zero.splat(count as f32));
    let factor = V::select(factor.less(one), factor, one);
    V::select(zero.less(power), factor, zero)
}
