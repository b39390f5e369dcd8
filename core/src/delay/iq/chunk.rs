//! Positions and carrier phases of a group of elements at several depths.

use super::parameters::DELAY_NUMBERS;
use super::phasor;
use super::taps::CHUNK;
use crate::delay::FAR;
use crate::delay::delay_law::ReceiveDelay;
use crate::simd::{MOST_LANES, Mask, Vector};

/// The largest number of cycles whose fraction is kept in f32.
const MOST_CYCLES: f32 = (1 << 22) as f32;
/// A whole number that lies outside of every record.
const OUTSIDE: f32 = -(1 << 24) as f32;

/// Read position of an element at the line's beginning for an output sample, and its carrier phase, in cycles.
#[derive(Clone, Copy)]
pub(super) struct Centre {
    pub(super) depth: f32,
    pub(super) whole: f32,
    pub(super) fraction: f32,
    pub(super) cycles: f32,
}

impl Centre {
    /// No read.
    pub(super) const NONE: Self = Centre {
        depth: 0.0,
        whole: 0.0,
        fraction: 0.0,
        cycles: 0.0,
    };
}

/// From the first record of some elements to that of each lane, in samples.
pub(super) type Offsets = [u32; MOST_LANES];

/// Constants that all elements of a line share.
pub(super) struct Factors {
    /// f_demod/fs, cycles.
    pub(super) a_sample: f32,
    pub(super) scale: f32,
    /// Taps in front of the sample before a position.
    pub(super) before: f32,
    /// The first sample at which no record can be read.
    pub(super) end: f32,
}

/// Whether a position and a phase are within range, the position in samples and the phase in cycles.
#[inline(always)]
pub(super) fn position<V: Vector>(
    factors: &Factors,
    centre: &Centre,
    receive_delay: V,
    own: V,
) -> (V::Mask, V, V) {
    let zero = own.zero();
    let position = zero.splat(centre.fraction) + receive_delay;
    let phase = receive_delay * zero.splat(factors.a_sample) + own;
    let cycles = zero.splat(centre.cycles) + phase;
    // False for a NaN, too.
    let valid = position.less(zero.splat(FAR as f32)) & cycles.abs().less(zero.splat(MOST_CYCLES));
    (valid, position, cycles)
}

/// Read positions of a group's elements at some depths, and their factors.
pub(super) struct Chunk<V> {
    /// The first tap of each lane with its offset: the bits of integers. Then those of mirrored elements.
    starts: [[V; CHUNK]; 2],
    /// Whether the taps of all lanes are within their records.
    pub(super) within: [bool; CHUNK],
    pub(super) weight: [V; CHUNK],
    pub(super) cosine: [V; CHUNK],
    pub(super) sine: [V; CHUNK],
}

impl<V: Vector> Chunk<V> {
    #[inline(always)]
    pub(super) fn new(zero: V) -> Self {
        Chunk {
            starts: [[zero; CHUNK]; 2],
            within: [false; CHUNK],
            weight: [zero; CHUNK],
            cosine: [zero; CHUNK],
            sine: [zero; CHUNK],
        }
    }

    /// The first tap of a lane at the n-th depth, with its offset; of the mirrored elements or not.
    #[inline(always)]
    pub(super) fn start(&self, mirrored: bool, n: usize, lane: usize) -> Option<u32> {
        let starts = &self.starts[usize::from(mirrored)];
        Some(starts.get(n)?.lanes().get(lane)?.to_bits())
    }

    /// Positions and factors of the elements with these receive delays.
    ///
    /// In three steps, each for all depths: operations of one depth wait for each other, and a processor looks ahead
    /// over few instructions.
    #[inline(always)]
    pub(super) fn locate(
        &mut self,
        factors: &Factors,
        centres: &[Centre],
        &[square, scaled, along, rate, part, ahead, own]: &[V; DELAY_NUMBERS],
        offsets: [&Offsets; 2],
    ) {
        let zero = square.zero();
        let numbers = [square, scaled, along, rate, part];
        // The receive delay in the place of the weight.
        for (receive_delay, centre) in self.weight.iter_mut().zip(centres) {
            *receive_delay = ReceiveDelay::samples_of(zero.splat(centre.depth), numbers);
        }
        // The phase in the place of the cosine.
        let phases = self.weight.iter_mut().zip(&mut self.cosine);
        let [starts, mirrored] = &mut self.starts;
        let starts = starts.iter_mut().zip(mirrored).zip(&mut self.within);
        for (((weight, phase), (starts, within)), centre) in phases.zip(starts).zip(centres) {
            let (valid, position, cycles) = position(factors, centre, *weight, own);
            let position = V::select(valid, position, zero);
            *phase = V::select(valid, cycles, zero);
            // Below 2²³ and not negative, so that truncation is the floor.
            let mut integers = [0i32; MOST_LANES];
            position.truncate(&mut integers);
            let mut floor = zero;
            for (floor, &integer) in floor.lanes_mut().iter_mut().zip(&integers) {
                *floor = integer as f32;
            }
            *weight = position - floor;
            // Whole numbers without an error up to 2²⁴; none beyond that is within a record.
            let first = ((zero.splat(centre.whole) - ahead) + floor) - zero.splat(factors.before);
            let first = V::select(valid, first, zero.splat(OUTSIDE));
            *within = (!first.less(zero) & first.less(zero.splat(factors.end))).all();
            first.truncate(&mut integers);
            for (start, offsets) in [starts.0, starts.1].into_iter().zip(offsets) {
                let sums = integers.iter().zip(offsets);
                for (start, (&integer, &offset)) in start.lanes_mut().iter_mut().zip(sums) {
                    *start = f32::from_bits((integer as u32).wrapping_add(offset));
                }
            }
        }
        let scale = zero.splat(factors.scale);
        for ((cosine, sine), _) in self.cosine.iter_mut().zip(&mut self.sine).zip(centres) {
            let (c, s) = phasor::phasor(*cosine);
            (*cosine, *sine) = (c * scale, s * scale);
        }
    }
}
