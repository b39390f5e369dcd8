//! Taps of several lanes at the depths of a chunk, loaded in blocks of two.

use crate::Complex;
use crate::simd::{ComplexVector, Vector, vectorize};

/// Depths that a group of elements is read at together: its records stay in the cache, and its receive delays in
/// registers.
pub(super) const CHUNK: usize = 16;

/// The samples that elements are read at, at each depth of a chunk.
pub(super) trait Taps {
    /// Whether those of all lanes are within the records.
    fn all_within(&self, n: usize) -> bool;

    /// Those of a lane at the n-th depth; none if the record does not have them.
    fn within<const TAPS: usize>(&self, n: usize, lane: usize) -> Option<[Complex<f32>; TAPS]>;

    /// The same with 0 outside the record.
    fn anywhere<const TAPS: usize>(&self, n: usize, lane: usize) -> [Complex<f32>; TAPS];
}

/// Pairs of taps that a depth loads at once.
const MOST_PAIRS: usize = 2;

/// The values at the depths of a chunk, and memory of the pairs of taps loaded.
pub(super) struct Values<V> {
    pub(super) values: [ComplexVector<V>; CHUNK],
    loaded: [[Quarters<V>; MOST_PAIRS]; CHUNK],
}

/// Blocks of four numbers, one for each lane: a quarter of the lanes in each register.
pub(super) type Quarters<V> = [V; 4];

impl<V: Vector> Values<V> {
    #[inline(always)]
    pub(super) fn new(zero: V) -> Self {
        Values {
            values: [ComplexVector::from_real(zero); CHUNK],
            loaded: [[[zero; 4]; MOST_PAIRS]; CHUNK],
        }
    }

    /// The values by `interpolate`, of a weight and the taps.
    ///
    /// The taps of all depths are loaded first: a processor looks ahead over few instructions.
    #[inline(always)]
    pub(super) fn by_pairs<const TAPS: usize, const PAIRS: usize>(
        &mut self,
        weights: &[V],
        taps: &impl Taps,
        interpolate: impl Fn(V, [ComplexVector<V>; TAPS]) -> ComplexVector<V>,
    ) {
        for (n, (&weight, loaded)) in weights.iter().zip(&mut self.loaded).enumerate() {
            if let Some(loaded) = loaded.first_chunk_mut::<PAIRS>() {
                load_taps::<V, TAPS, PAIRS>(weight, taps, n, loaded);
            }
        }
        let loaded = self.loaded.iter().zip(weights);
        for (value, (loaded, &weight)) in self.values.iter_mut().zip(loaded) {
            if let Some(loaded) = loaded.first_chunk::<PAIRS>() {
                *value = interpolate(weight, side_by_side(loaded));
            }
        }
    }
}

/// The numbers of all blocks side by side: the first of each lane, the second, and so on.
#[inline(always)]
pub(super) fn columns<V: Vector>([a, b, c, d]: Quarters<V>) -> [V; 4] {
    let ((even, odd), (even_behind, odd_behind)) = (a.deinterleave(b), c.deinterleave(d));
    let (first, third) = even.deinterleave(even_behind);
    let (second, fourth) = odd.deinterleave(odd_behind);
    [first, second, third, fourth]
}

/// The taps of all lanes side by side.
#[inline(always)]
pub(super) fn side_by_side<V: Vector, const TAPS: usize, const PAIRS: usize>(
    pairs: &[Quarters<V>; PAIRS],
) -> [ComplexVector<V>; TAPS] {
    let mut taps = [ComplexVector::from_real(pairs[0][0].zero()); TAPS];
    for (taps, &pair) in taps.as_chunks_mut::<2>().0.iter_mut().zip(pairs) {
        let [a_re, a_im, b_re, b_im] = columns(pair);
        *taps = [(a_re, a_im), (b_re, b_im)].map(
            #[inline(always)]
            |(re, im)| ComplexVector::new(re, im),
        );
    }
    taps
}

/// Loads blocks of all lanes; none if one lane has none.
#[inline(always)]
pub(super) fn load_quarters<V: Vector, const FOURS: usize>(
    zero: V,
    loaded: &mut [Quarters<V>; FOURS],
    block: impl Fn(usize) -> Option<[[f32; 4]; FOURS]>,
) -> Option<()> {
    for quarter in 0..4 {
        let registers = zero.gather::<FOURS>(
            #[inline(always)]
            |k| block(quarter * (V::LANES / 4) + k),
        )?;
        for (loaded, register) in loaded.iter_mut().zip(registers) {
            loaded[quarter] = register;
        }
    }
    Some(())
}

/// Loads the taps of all lanes.
#[inline(always)]
pub(super) fn load_taps<V: Vector, const TAPS: usize, const PAIRS: usize>(
    zero: V,
    taps: &impl Taps,
    n: usize,
    loaded: &mut [Quarters<V>; PAIRS],
) {
    let within = taps.all_within(n)
        && load_quarters(
            zero,
            loaded,
            #[inline(always)]
            |lane| Some(pairs(taps.within::<TAPS>(n, lane)?)),
        )
        .is_some();
    if !within {
        at_the_edge::<V, TAPS, PAIRS>(zero, taps, n, loaded);
    }
}

/// Loads the taps of all lanes, some of them outside the records.
#[cold]
#[inline(never)]
fn at_the_edge<V: Vector, const TAPS: usize, const PAIRS: usize>(
    zero: V,
    taps: &impl Taps,
    n: usize,
    loaded: &mut [Quarters<V>; PAIRS],
) {
    vectorize!(zero, {
        load_quarters(
            zero,
            loaded,
            #[inline(always)]
            |lane| Some(pairs(taps.anywhere::<TAPS>(n, lane))),
        )
    });
}

#[inline(always)]
fn pairs<const TAPS: usize, const PAIRS: usize>(taps: [Complex<f32>; TAPS]) -> [[f32; 4]; PAIRS] {
    let mut pairs = [[0.0; 4]; PAIRS];
    for (pair, [a, b]) in pairs.iter_mut().zip(taps.as_chunks::<2>().0) {
        *pair = [a.re, a.im, b.re, b.im];
    }
    pairs
}
