//! Postfilters: a real factor for each sample, from the aligned samples, that multiplies a method's output.

use super::segment::{Segment, SegmentGroup};
use super::snapshot::gather;
use super::table::{Parameter, choices};
use crate::simd::{ComplexVector, Scalar, Vector};
use core::f32::consts::TAU;
use num_complex::Complex;

choices! {
    /// A postfilter: the factor that multiplies the output of any [`Method`](super::Method).
    Postfilter {
        /// No postfilter.
        None, "none", "no postfilter";
        /// Coherence factor `|Σx_m|²/(M·Σ|x_m|²)` over the `M` active elements, 0 to 1.
        CoherenceFactor, "coherence-factor", "CF";
        /// Generalized coherence factor: `Σ|p_k|²` over `k = −M₀..=M₀`, over that of all `k`, with `p_k` the discrete
        /// Fourier transform of the `M` active elements and `M₀` the parameter `coherence_cutoff`; `M₀ = 0` is the
        /// coherence factor.
        GeneralizedCoherenceFactor, "generalized-coherence-factor", "GCF";
    }
}

/// Active elements that are gathered at a time.
const BLOCK: usize = 8;

/// Multiplies `z[lane][i]`, sample `first_sample + i` of its segment, by the factor of that sample.
#[inline(always)]
pub(super) fn postfilter<V: Vector>(
    (postfilter, cutoff): (Postfilter, usize),
    zero: V,
    group: SegmentGroup<'_, '_>,
    z: &mut [&mut [Complex<f32>]],
) {
    if postfilter != Postfilter::None {
        apply((postfilter, cutoff), zero, group, z);
    }
}

/// Apart, so that a beamformer without a postfilter pays one comparison a segment.
#[cold]
#[inline(never)]
fn apply<V: Vector>(
    (postfilter, cutoff): (Postfilter, usize),
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
        Postfilter::GeneralizedCoherenceFactor => multiply(
            zero,
            z,
            #[inline(always)]
            |i| generalized_coherence(zero, group, i, cutoff),
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
    let (sum, power) = sums(zero, segments, i, count);
    share(sum.norm_sqr(), power, count)
}

/// The sum of the elements and that of their powers.
#[inline(always)]
fn sums<V: Vector>(
    zero: V,
    segments: &[Segment<'_>],
    i: isize,
    count: usize,
) -> (ComplexVector<V>, V) {
    let mut sum = ComplexVector::from_real(zero);
    let mut power = zero;
    each_element(
        zero,
        segments,
        i,
        count,
        #[inline(always)]
        |_, x| {
            sum = sum + x;
            power = power + x.norm_sqr();
        },
    );
    (sum, power)
}

/// Hands the elements of each segment's sample `i` to `take`, in ascending order.
#[inline(always)]
fn each_element<V: Vector>(
    zero: V,
    segments: &[Segment<'_>],
    i: isize,
    count: usize,
    mut take: impl FnMut(usize, ComplexVector<V>),
) {
    let mut block = [ComplexVector::from_real(zero); BLOCK];
    for first in (0..count).step_by(BLOCK) {
        let Some(block) = block.get_mut(..(count - first).min(BLOCK)) else {
            return;
        };
        gather(zero, segments, i, first, block);
        for (m, &mut x) in block.iter_mut().enumerate() {
            take(first + m, x);
        }
    }
}

/// The coherence factor of the sum of `count` samples and the sum of their powers.
#[inline(always)]
pub(super) fn coherence_of<V: Vector>(sum: ComplexVector<V>, power: V, count: usize) -> V {
    share(sum.norm_sqr(), power, count)
}

/// The coherent power over `count` times the power of all elements: 0 without power, at most 1.
#[inline(always)]
fn share<V: Vector>(coherent: V, power: V, count: usize) -> V {
    let (zero, one) = (power.zero(), power.splat(1.0));
    let factor = coherent / (power * zero.splat(count as f32));
    let factor = V::select(factor.less(one), factor, one);
    V::select(zero.less(power), factor, zero)
}

/// The generalized coherence factor of each segment's sample `i`, by [`share_of_spectrum`].
///
/// Cost: `8·M` flops, `M` sines and cosines a frequency.
#[inline(always)]
fn generalized_coherence<V: Vector>(
    zero: V,
    group: SegmentGroup<'_, '_>,
    i: isize,
    cutoff: usize,
) -> V {
    let SegmentGroup { segments, count } = group;
    share_of_spectrum(
        sums(zero, segments, i, count),
        (count, cutoff),
        #[inline(always)]
        |frequency| {
            each_element(
                zero,
                segments,
                i,
                count,
                #[inline(always)]
                |m, x| frequency.add(m, x),
            );
        },
    )
}

/// The parts of the discrete Fourier transform at `k` cycles across `count` elements.
pub(super) struct Frequency<V> {
    k: usize,
    count: usize,
    cosines: ComplexVector<V>,
    sines: ComplexVector<V>,
}

impl<V: Vector> Frequency<V> {
    /// Adds element `m`.
    #[inline(always)]
    pub(super) fn add(&mut self, m: usize, x: ComplexVector<V>) {
        let turns = (self.k * m).checked_rem(self.count).unwrap_or(0) as f32 / self.count as f32;
        let (sine, cosine) = libm::sincosf(TAU * turns);
        self.cosines = self.cosines + x.scale(x.re.splat(cosine));
        self.sines = self.sines + x.scale(x.re.splat(sine));
    }
}

/// The generalized coherence factor of `count` elements from their sum and the sum of their powers; `each` hands them out.
/// With `C = Σ x_m cos(2πkm/M)` and `S` the same of the sine, `|p_k|² + |p_{−k}|²` is `2·(|C|² + |S|²)`: sums in the order
/// of `each`, frequencies ascending from `k = 0`.
#[inline(always)]
pub(super) fn share_of_spectrum<V: Vector>(
    (sum, power): (ComplexVector<V>, V),
    (count, cutoff): (usize, usize),
    each: impl Fn(&mut Frequency<V>),
) -> V {
    let zero = power.zero();
    // Above half the elements a frequency is one below it.
    let cutoff = cutoff.min(count.saturating_sub(1) / 2);
    let mut coherent = sum.norm_sqr();
    for k in 1..=cutoff {
        let mut frequency = Frequency {
            k,
            count,
            cosines: ComplexVector::from_real(zero),
            sines: ComplexVector::from_real(zero),
        };
        each(&mut frequency);
        let both = frequency.cosines.norm_sqr() + frequency.sines.norm_sqr();
        coherent = coherent + both + both;
    }
    share(coherent, power, count)
}
