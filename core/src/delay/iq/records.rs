//! The records of a group of elements, and the read positions.

use core::ops::Range;

use super::chunk::{Chunk, Offsets};
use super::record::{Sample, Window};
use super::taps::Taps;
use crate::Complex;
use crate::delay::groups::Group;
use crate::simd::{MOST_LANES, Vector};

/// Elements side by side that are read together, at most one a lane.
pub(super) struct Elements {
    pub(super) range: Range<usize>,
    /// Elements that no other lane writes: an element on the line is its own mirror image.
    pub(super) written: Range<usize>,
    /// Whether the elements mirror those before them. Lanes then hold them from the last to the first.
    pub(super) mirrored: bool,
}

impl Elements {
    /// The two halves of a group, either of which may be empty.
    #[inline(always)]
    pub(super) fn of(group: Group) -> [Self; 2] {
        let Group {
            left,
            right,
            mirrored,
        } = group;
        [
            Elements {
                written: left.clone(),
                range: left.clone(),
                mirrored: false,
            },
            Elements {
                written: right.start.max(left.end)..right.end,
                range: right,
                mirrored,
            },
        ]
    }
}

/// The records of elements, one per lane; lanes after the last element repeat its record.
pub(super) struct Records<'a, T, const PLANAR: bool> {
    /// From the first element's first sample on.
    samples: &'a [T],
    /// From the first element's samples to those of each lane.
    offsets: Offsets,
    /// From a sample to the next; 1 if planar.
    sample: usize,
    length: usize,
}

impl<'a, T: Sample, const PLANAR: bool> Records<'a, T, PLANAR> {
    #[inline(always)]
    pub(super) fn new<V: Vector>(window: &Window<'a, T>, elements: &Elements) -> Self {
        let Elements {
            range, mirrored, ..
        } = elements;
        let samples = window.samples.get(range.start * window.element..);
        let last = range.len().saturating_sub(1);
        let mut offsets = [0; MOST_LANES];
        for (lane, offset) in offsets.iter_mut().enumerate().take(V::LANES) {
            let element = lane.min(last);
            let element = if *mirrored { last - element } else { element };
            // At most as many elements as lanes, of MAX_SAMPLES each, or of consecutive samples.
            *offset = (element * window.element) as u32;
        }
        Records {
            samples: samples.unwrap_or_default(),
            offsets,
            sample: if PLANAR { 1 } else { window.sample },
            length: window.length,
        }
    }

    /// The offsets that starts include: those of consecutive samples.
    #[inline(always)]
    pub(super) fn included(&self) -> &Offsets {
        const NONE: &Offsets = &[0; MOST_LANES];
        if PLANAR { &self.offsets } else { NONE }
    }
}

/// Records, and the samples of them that are read at the depths of a chunk.
pub(super) struct SampleIndices<'a, 'r, V, T, const PLANAR: bool> {
    pub(super) records: &'r Records<'a, T, PLANAR>,
    pub(super) chunk: &'r Chunk<V>,
    pub(super) mirrored: bool,
}

impl<V: Vector, T: Sample, const PLANAR: bool> Taps for SampleIndices<'_, '_, V, T, PLANAR> {
    #[inline(always)]
    fn all_within(&self, n: usize) -> bool {
        self.chunk.within.get(n).is_some_and(|&within| within)
    }

    #[inline(always)]
    fn within<const TAPS: usize>(&self, n: usize, lane: usize) -> Option<[Complex<f32>; TAPS]> {
        let start = self.chunk.start(self.mirrored, n, lane)? as usize;
        let Records {
            samples, sample, ..
        } = *self.records;
        if PLANAR {
            // One comparison for all taps.
            let taps = samples.get(start..start + TAPS)?.first_chunk::<TAPS>()?;
            return Some(taps.map(Sample::value));
        }
        let start = start.wrapping_mul(sample) + *self.records.offsets.get(lane)? as usize;
        let mut taps = [Complex::new(0.0, 0.0); TAPS];
        for (k, tap) in taps.iter_mut().enumerate() {
            *tap = samples.get(start + k * sample)?.value();
        }
        Some(taps)
    }

    #[cold]
    #[inline(never)]
    fn anywhere<const TAPS: usize>(&self, n: usize, lane: usize) -> [Complex<f32>; TAPS] {
        let Records {
            samples,
            sample,
            length,
            ..
        } = *self.records;
        let [first, included] = [&self.records.offsets, self.records.included()].map(
            #[inline(always)]
            |offsets| offsets.get(lane).map_or(0, |&offset| offset),
        );
        let start = self.chunk.start(self.mirrored, n, lane).unwrap_or(0);
        let (start, first) = (start.wrapping_sub(included), first as usize);
        let mut taps = [Complex::new(0.0, 0.0); TAPS];
        for (k, tap) in taps.iter_mut().enumerate() {
            // In front of the record, indices wrap around, to its first samples.
            let index = start.wrapping_add(k as u32) as usize;
            if index < length
                && let Some(sample) = samples.get(first + index * sample)
            {
                *tap = sample.value();
            }
        }
        taps
    }
}
