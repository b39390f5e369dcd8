//! Postfilters: a real factor for each sample, multiplied with a method's output.
//!
//! The factor is computed from the aligned samples.

use super::pushes::SampleIndex;
use super::segment::SegmentGroup;
use super::snapshot::gather;
use super::table::{Parameter, choices};
use crate::geometry::DepthStep;
use crate::simd::{ComplexVector, Scalar, Vector, vectorize};
use core::f32::consts::TAU;
use num_complex::Complex;

choices! {
    /// A postfilter: a factor on the output of any [`Method`](super::Method).
    Postfilter {
        /// No postfilter.
        None, "none", "no postfilter";
        /// Coherence factor `|Σx_m|²/(M·Σ|x_m|²)` over the `M` active elements, 0 to 1.
        CoherenceFactor, "coherence-factor", "CF";
        /// Generalized coherence factor: `Σ|p_k|²` over `|k| ≤ M₀`, over that of all `k`.
        ///
        /// `p_k` is the discrete Fourier transform of the `M` active elements and `M₀` the parameter
        /// `coherence_cutoff`; `M₀ = 0` is the coherence factor.
        GeneralizedCoherenceFactor, "generalized-coherence-factor", "GCF";
    }
}

/// A postfilter and its parameters.
#[derive(Clone, Copy)]
pub(super) struct Applied {
    pub(super) postfilter: Postfilter,
    pub(super) cutoff: usize,
}

/// Active elements that are gathered at a time.
const BLOCK: usize = 8;

/// Multiplies `z[lane][i]`, computed sample `i` of its segment, by the factor of that sample.
#[inline(always)]
pub(super) fn postfilter<V: Vector>(
    (postfilter, step): (Applied, DepthStep),
    zero: V,
    group: SegmentGroup<'_, '_>,
    z: &mut [&mut [Complex<f32>]],
) {
    if postfilter.postfilter != Postfilter::None {
        apply((postfilter, step), zero, group, z);
    }
}

/// A separate function: without a postfilter the cost is one comparison a segment.
#[cold]
#[inline(never)]
fn apply<V: Vector>(
    (postfilter, step): (Applied, DepthStep),
    zero: V,
    group: SegmentGroup<'_, '_>,
    z: &mut [&mut [Complex<f32>]],
) {
    let longest = z.iter().map(|z| z.len()).max().unwrap_or(0);
    vectorize!(zero, {
        for i in 0..longest {
            let sample = SampleOf {
                zero,
                group,
                sample_index: SampleIndex::output(i, step),
            };
            let factor = factor(postfilter, sample.sums(), &sample);
            for (z, &factor) in z.iter_mut().zip(factor.lanes()) {
                if let Some(z) = z.get_mut(i) {
                    *z *= factor;
                }
            }
        }
    });
}

/// The active elements of a sample.
pub(super) trait Elements<V: Vector> {
    fn count(&self) -> usize;

    /// Hands each element with its index to `take`, in the order in which they are summed up.
    fn each(&self, take: impl FnMut(usize, ComplexVector<V>));
}

/// The factor of a postfilter, from elements, their sum and their total power.
///
/// Both sums are at the line's working scale, so that squares neither overflow nor, above −300 dB of the line's
/// largest sample, underflow.
#[inline(always)]
pub(super) fn factor<V: Vector>(
    Applied { postfilter, cutoff }: Applied,
    (sum, power): (ComplexVector<V>, V),
    elements: &impl Elements<V>,
) -> V {
    let coherent = match postfilter {
        Postfilter::None => return power.splat(1.0),
        Postfilter::CoherenceFactor => sum.norm_sqr(),
        Postfilter::GeneralizedCoherenceFactor => low_frequencies(sum, elements, cutoff),
    };
    fraction(coherent, power, elements.count())
}

/// A sample of each segment.
struct SampleOf<'s, 'a, V> {
    zero: V,
    group: SegmentGroup<'s, 'a>,
    sample_index: SampleIndex,
}

impl<V: Vector> SampleOf<'_, '_, V> {
    /// The sum of the elements and that of their powers, ascending from zero.
    #[inline(always)]
    fn sums(&self) -> (ComplexVector<V>, V) {
        let zero = self.zero.zero();
        let (mut sum, mut power) = (ComplexVector::from_real(zero), zero);
        self.each(
            #[inline(always)]
            |_, x| {
                sum = sum + x;
                power = power + x.norm_sqr();
            },
        );
        (sum, power)
    }
}

impl<V: Vector> Elements<V> for SampleOf<'_, '_, V> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.group.count
    }

    #[inline(always)]
    fn each(&self, mut take: impl FnMut(usize, ComplexVector<V>)) {
        let SegmentGroup { segments, count } = self.group;
        let mut block = [ComplexVector::from_real(self.zero.zero()); BLOCK];
        for first in (0..count).step_by(BLOCK) {
            let Some(block) = block.get_mut(..(count - first).min(BLOCK)) else {
                return;
            };
            gather(self.zero, segments, self.sample_index, first, block);
            for (m, &mut x) in block.iter_mut().enumerate() {
                take(first + m, x);
            }
        }
    }
}

/// The coherent power over `count` times the power of all elements.
///
/// Without power it is 0. Rounding above 1 is clipped to 1.
#[inline(always)]
fn fraction<V: Vector>(coherent: V, power: V, count: usize) -> V {
    let (zero, one) = (power.zero(), power.splat(1.0));
    let factor = coherent / (power * zero.splat(count as f32));
    let factor = V::select(factor.less(one), factor, one);
    V::select(zero.less(power), factor, zero)
}

/// `Σ|p_k|²` over `k = −cutoff..=cutoff`, with `p_k` the discrete Fourier transform of the elements and `p_0` their sum.
/// With `C = Σ x_m cos(2πkm/M)` and `S` the same of the sine, `|p_k|² + |p_{−k}|²` is `2·(|C|² + |S|²)`: sums in the
/// order of the elements, frequencies ascending from `k = 0`.
///
/// Cost: `8·M` flops, `M` sines and cosines a frequency.
#[inline(always)]
fn low_frequencies<V: Vector>(
    sum: ComplexVector<V>,
    elements: &impl Elements<V>,
    cutoff: usize,
) -> V {
    let zero = sum.re.zero();
    let count = elements.count();
    // Above half the elements a frequency is one below it.
    let cutoff = cutoff.min(count.saturating_sub(1) / 2);
    let mut coherent = sum.norm_sqr();
    for k in 1..=cutoff {
        let mut cosines = ComplexVector::from_real(zero);
        let mut sines = ComplexVector::from_real(zero);
        elements.each(
            #[inline(always)]
            |m, x| {
                let cycles = (k * m).checked_rem(count).unwrap_or(0) as f32 / count as f32;
                let (sine, cosine) = libm::sincosf(TAU * cycles);
                cosines = cosines + x.scale(zero.splat(cosine));
                sines = sines + x.scale(zero.splat(sine));
            },
        );
        let both = cosines.norm_sqr() + sines.norm_sqr();
        coherent = coherent + both + both;
    }
    coherent
}
