//! Decimation by powers of two: half-band FIR filters.
//!
//! A record at 2.5 times the output rate or more is decimated below that ratio. Each halving is `y[j] = x[2j]/2 +
//! Σ_k h_k·(x[2j−k] + x[2j+k])`, k = 1, 3, …, 2P − 1, with h_k ∝ sin(πk/2)/(πk)·kaiser(k/2P, β) that add up to 1/4:
//!
//! - The last halving: P = 6, β = 6.5. Frequencies below 0.7 of half the output rate pass, and their aliases are
//!   removed, both to 2.5·10⁻⁴.
//! - Earlier halvings: P = 4, β = 8.5, to 1.6·10⁻⁴.
//!
//! The filter that reads the decimated record removes other frequencies above half the output rate
//! ([`interpolate`](super::interpolate)).
//!
//! Lanes are samples. Samples at even and at odd positions are stored apart, so that a filter covers consecutive
//! ones. A record is filtered in chunks; the samples before a chunk that the filter needs are kept in front of it.

use crate::kaiser::Kaiser;
use crate::simd::{Vector, copy, load, split_front as take_first};
use core::ops::Range;
use core::slice::ChunksExactMut;

/// Records this many times as fast as the output, or more, are decimated.
const DECIMATED_FROM: f64 = 2.5;
/// Maximum number of halvings: from 16 to 2 times the output rate.
const MAX_HALVINGS: usize = 3;
/// Non-zero taps on one side of the last filter, and of the filters before it; the shapes of their windows.
const LAST: usize = 6;
const BEFORE: usize = 4;
const LAST_BETA: f64 = 6.5;
const BEFORE_BETA: f64 = 8.5;
/// Samples before sample 0 of a decimated record: half the reach of both filters.
const MARGIN: usize = LAST + BEFORE - 1;
/// Maximum number of samples output together.
const CHUNK: usize = 64;
/// Samples of even index, and of odd index, that stay in front of new ones: at least 2P − 1, and a
/// whole number of registers.
const OLD: usize = 16;
/// Samples until no filter reaches back to the missing samples before the beginning.
const LEAD: usize = 32;

/// How often records sampled at `ratio` times the output rate are decimated, up to a ratio of 16.
pub(super) const fn halvings(ratio: f64) -> usize {
    let mut halvings = 0;
    let mut after = ratio;
    while after >= DECIMATED_FROM && halvings < MAX_HALVINGS {
        after /= 2.0;
        halvings += 1;
    }
    halvings
}

/// Length of a record of `samples` samples after a number of halvings.
///
/// It includes the samples before sample 0 and the filters' reach at the end; 0 without decimation.
pub(super) const fn decimated_len(halvings: usize, samples: usize) -> usize {
    if halvings == 0 {
        return 0;
    }
    let mut length = samples;
    let mut halving = 0;
    while halving < halvings {
        // Up to the last one that the filter reaches: ⌊(length − 1 + 2P − 1)/2⌋ = ⌊length/2⌋ + P − 1.
        length = length / 2 + pairs(halvings, halving);
        halving += 1;
    }
    (MARGIN + length).next_multiple_of(OLD)
}

/// Numbers that all halvings keep.
pub(super) const fn streams_len(halvings: usize) -> usize {
    let mut length = 0;
    let mut halving = 0;
    while halving < halvings {
        length += 2 * stream_len(halvings, halving);
        halving += 1;
    }
    length
}

/// P of a halving.
const fn pairs(halvings: usize, halving: usize) -> usize {
    if halving + 1 < halvings { BEFORE } else { LAST }
}

/// Samples of a record that the filters need after the middle one, for a number of halvings.
pub(super) const fn reach(halvings: usize) -> usize {
    let (mut reach, mut halving) = (0, 0);
    while halving < halvings {
        reach += (2 * pairs(halvings, halving) - 1) << halving;
        halving += 1;
    }
    reach
}

/// Samples of even index, and of odd index, that a halving keeps.
const fn stream_len(halvings: usize, halving: usize) -> usize {
    OLD + (CHUNK << (halvings - 1 - halving))
}

/// The taps of the filters.
static BEFORE_TAPS: [f32; BEFORE] = half_band(BEFORE_BETA);
static LAST_TAPS: [f32; LAST] = half_band(LAST_BETA);

/// The memory of a [`Decimator`].
pub(super) struct DecimatorMemory<'s, 'd> {
    /// Buffer of the filters, [`streams_len`] long.
    pub streams: &'s mut [f32],
    /// The decimated record, [`decimated_len`] long, or several of them.
    pub decimated: &'d mut [f32],
}

/// The filters of all halvings.
#[derive(Clone, Debug)]
pub(super) struct Decimator {
    halvings: usize,
}

impl Decimator {
    /// The decimator of records sampled at `ratio` times the output rate, 16 at most.
    pub(super) const fn new(ratio: f64) -> Self {
        Decimator {
            halvings: halvings(ratio),
        }
    }

    /// Largest gain of all halvings for samples of magnitude 1.
    #[cfg(test)]
    pub(super) fn gain(&self) -> f64 {
        let of =
            |taps: &[f32]| 0.5 + 2.0 * taps.iter().map(|&tap| f64::from(tap.abs())).sum::<f64>();
        let [before, last] = [of(&BEFORE_TAPS), of(&LAST_TAPS)];
        match self.halvings {
            0 => 1.0,
            1 => last,
            2 => before * last,
            _ => before * before * last,
        }
    }

    /// How often the rate is halved.
    pub(super) const fn halvings(&self) -> usize {
        self.halvings
    }

    /// Index of sample 0 in the result of [`Decimator::decimate`].
    pub(super) fn origin(&self) -> usize {
        if self.halvings == 0 { 0 } else { MARGIN }
    }

    /// Returns `record` at the rate of the last halving.
    ///
    /// The result is the memory's `decimated`, or `record` itself without decimation. Samples outside the record
    /// are 0. Samples that are not `needed` may stay unchanged.
    ///
    /// Order, f32: `x[2j]/2`, then in ascending k, `+ h_k · (earlier + later)`.
    #[inline(always)]
    pub(super) fn decimate<'a, V: Vector>(
        &self,
        zero: V,
        record: &'a [f32],
        needed: Range<usize>,
        memory: DecimatorMemory<'_, 'a>,
    ) -> &'a [f32] {
        if self.halvings == 0 {
            return record;
        }
        let DecimatorMemory { streams, decimated } = memory;
        streams.fill(0.0);
        let mut rest = streams;
        let mut streams: [Stream; MAX_HALVINGS] = core::array::from_fn(|halving| {
            let length = if halving < self.halvings {
                stream_len(self.halvings, halving)
            } else {
                0
            };
            Stream {
                even: take_first(&mut rest, length),
                odd: take_first(&mut rest, length),
            }
        });
        // Before the record all samples are 0, so filters may begin there without history.
        let start = needed.start.min(decimated.len());
        let begin = start.saturating_sub(LEAD) / OLD * OLD;
        let end = needed.end.min(decimated.len()).next_multiple_of(OLD);
        // The first sample of a halving's first outputs, and then of its first new inputs.
        let mut first = begin as isize - MARGIN as isize;
        for halving in (0..self.halvings).rev() {
            first = 2 * (first + pairs(self.halvings, halving) as isize - 1);
        }
        let needed = decimated.get_mut(begin..end).unwrap_or_default();
        for outputs in needed.chunks_mut(CHUNK) {
            let inputs = outputs.len() << self.halvings;
            streams[0].take_record(zero, record, first, inputs);
            first += inputs as isize;
            for halving in 1..self.halvings {
                if let Some([from, to]) = streams.get_mut(halving - 1..=halving) {
                    let outputs = outputs.len() << (self.halvings - halving);
                    to.take_decimated(zero, from, &BEFORE_TAPS, outputs);
                    from.advance(outputs);
                }
            }
            let Some(last) = streams.get_mut(self.halvings - 1) else {
                break;
            };
            let slots = outputs.chunks_exact_mut(V::LANES);
            for (inputs, slot) in last.inputs(V::LANES).zip(slots) {
                copy(filter(zero, &LAST_TAPS, inputs).lanes(), slot);
            }
            last.advance(outputs.len());
        }
        decimated
    }
}

/// A halving's samples of even index and of odd index: [`OLD`] ones, then new ones.
struct Stream<'a> {
    even: &'a mut [f32],
    odd: &'a mut [f32],
}

impl Stream<'_> {
    /// Takes `length` new samples of the record from `first` on; samples outside are 0.
    #[inline(always)]
    fn take_record<V: Vector>(&mut self, zero: V, record: &[f32], first: isize, length: usize) {
        // Before the record, indices wrap around to beyond its end, which is also empty.
        let first = first as usize;
        let Some(samples) = record.get(first..first.wrapping_add(length)) else {
            self.take_edge(record, first, length);
            return;
        };
        let [even, odd] = self.new_ones::<V>();
        for ((even, odd), x) in even.zip(odd).zip(samples.chunks_exact(2 * V::LANES)) {
            let (x_even, x_odd) = load(zero, x).deinterleave(load(zero, &x[V::LANES..]));
            copy(x_even.lanes(), even);
            copy(x_odd.lanes(), odd);
        }
    }

    #[cold]
    #[inline(never)]
    fn take_edge(&mut self, record: &[f32], first: usize, length: usize) {
        let sample = |k| record.get(first.wrapping_add(k)).copied().unwrap_or(0.0);
        let new = self.even.iter_mut().zip(&mut *self.odd).skip(OLD);
        for (pair, (even, odd)) in new.take(length / 2).enumerate() {
            *even = sample(2 * pair);
            *odd = sample(2 * pair + 1);
        }
    }

    /// Takes `length` outputs of the halving before as new samples.
    #[inline(always)]
    fn take_decimated<V: Vector>(
        &mut self,
        zero: V,
        from: &Stream,
        taps: &[f32; BEFORE],
        length: usize,
    ) {
        let [even, odd] = self.new_ones::<V>();
        let inputs = from.inputs(2 * V::LANES).take(length / (2 * V::LANES));
        for ((even, odd), inputs) in even.zip(odd).zip(inputs) {
            let next = inputs.map(
                #[inline(always)]
                |samples| samples.get(V::LANES..).unwrap_or_default(),
            );
            let y = filter(zero, taps, inputs);
            let (y_even, y_odd) = y.deinterleave(filter(zero, taps, next));
            copy(y_even.lanes(), even);
            copy(y_odd.lanes(), odd);
        }
    }

    /// The positions of new samples of even and of odd index, a vector each.
    #[inline(always)]
    fn new_ones<V: Vector>(&mut self) -> [ChunksExactMut<'_, f32>; 2] {
        [&mut *self.even, &mut *self.odd].map(
            #[inline(always)]
            |samples| {
                let new = samples.get_mut(OLD..).unwrap_or_default();
                new.chunks_exact_mut(V::LANES)
            },
        )
    }

    /// The inputs of a number of outputs, and of the next ones: even and odd samples.
    #[inline(always)]
    fn inputs<'s>(&'s self, outputs: usize) -> impl Iterator<Item = [&'s [f32]; 2]> {
        let windows = |samples: &'s [f32]| samples.windows(OLD + outputs).step_by(outputs);
        windows(self.even).zip(windows(self.odd)).map(
            #[inline(always)]
            |(even, odd)| [even, odd],
        )
    }

    /// After `new` new samples, the last ones become old ones.
    #[inline(always)]
    fn advance(&mut self, new: usize) {
        for samples in [&mut *self.even, &mut *self.odd] {
            if let Some(&last) = samples.get(new..).and_then(<[_]>::first_chunk::<OLD>)
                && let Some(old) = samples.first_chunk_mut()
            {
                *old = last;
            }
        }
    }
}

/// As many outputs of a filter as there are lanes, from samples of even and of odd index.
#[inline(always)]
fn filter<V: Vector, const PAIRS: usize>(
    zero: V,
    taps: &[f32; PAIRS],
    [even, odd]: [&[f32]; 2],
) -> V {
    let middle = OLD + 1 - PAIRS;
    let mut y = zero.splat(0.5) * from_index(zero, even, middle);
    for (k, &tap) in taps.iter().enumerate() {
        let earlier = from_index(zero, odd, middle - 1 - k);
        let later = from_index(zero, odd, middle + k);
        y = y + zero.splat(tap) * (earlier + later);
    }
    y
}

/// The samples from `position` on, 0..=[`OLD`].
///
/// With the widest registers, they come from two loads of a cache line each: a register across two lines would take
/// two loads at every position.
#[inline(always)]
fn from_index<V: Vector>(zero: V, samples: &[f32], index: usize) -> V {
    if V::LANES == OLD {
        let next = samples.get(OLD..).unwrap_or_default();
        return load(zero, samples).slide(load(zero, next), index);
    }
    load(zero, samples.get(index..).unwrap_or_default())
}

/// The taps of a half-band filter for k = 1, 3, ….
const fn half_band<const PAIRS: usize>(beta: f64) -> [f32; PAIRS] {
    let window = Kaiser::new(beta);
    let mut taps = [0.0; PAIRS];
    let mut sum = 0.0;
    let mut pair = 0;
    while pair < PAIRS {
        let k = (2 * pair + 1) as f64;
        let sign = if pair % 2 == 0 { 1.0 } else { -1.0 };
        taps[pair] = sign / (core::f64::consts::PI * k) * window.at(k / (2 * PAIRS) as f64);
        sum += taps[pair];
        pair += 1;
    }
    let mut rounded = [0.0; PAIRS];
    while pair > 0 {
        pair -= 1;
        rounded[pair] = (0.25 * taps[pair] / sum) as f32;
    }
    rounded
}

#[cfg(test)]
mod tests;
