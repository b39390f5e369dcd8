//! The records of a group of elements, and where they are read.

use core::ops::Range;

use super::chunk::Chunk;
use super::interpolation::Taps;
use super::record::{Sample, Window};
use crate::Complex;
use crate::simd::{MOST_LANES, Vector};

/// The records of a group of elements, one a lane; behind the last element, its record once more.
pub(super) struct Records<'a, T, const PLANAR: bool> {
    /// From the first element's first sample on.
    samples: &'a [T],
    /// From the first element's samples to those of each lane.
    pub(super) offsets: [i32; MOST_LANES],
    /// From a sample to the next; 1 if planar.
    sample: usize,
    pub(super) length: usize,
}

impl<'a, T: Sample, const PLANAR: bool> Records<'a, T, PLANAR> {
    #[inline(always)]
    pub(super) fn new<V: Vector>(window: &Window<'a, T>, group: &Range<usize>) -> Self {
        let samples = window.samples.get(group.start * window.element..);
        let last = group.len().saturating_sub(1);
        let mut offsets = [0; MOST_LANES];
        for (lane, offset) in offsets.iter_mut().enumerate().take(V::LANES) {
            *offset = (lane.min(last) * window.element) as i32;
        }
        Records {
            samples: samples.unwrap_or_default(),
            offsets,
            sample: if PLANAR { 1 } else { window.sample },
            length: window.length,
        }
    }

    /// The offset of a lane if starts do not include it.
    #[inline(always)]
    fn offset(&self, lane: usize) -> usize {
        self.offsets.get(lane).map_or(0, |&offset| offset as usize)
    }
}

/// Records, and the samples of them that are read at the depths of a chunk.
pub(super) struct Places<'a, 'r, V, T, const PLANAR: bool> {
    pub(super) records: &'r Records<'a, T, PLANAR>,
    pub(super) chunk: &'r Chunk<V>,
}

impl<V: Vector, T: Sample, const PLANAR: bool> Taps for Places<'_, '_, V, T, PLANAR> {
    #[inline(always)]
    fn all_within(&self, n: usize) -> bool {
        self.chunk.within.get(n).is_some_and(|&within| within)
    }

    #[inline(always)]
    fn within<const TAPS: usize>(&self, n: usize, lane: usize) -> Option<[Complex<f32>; TAPS]> {
        let start = self.chunk.start(n, lane)? as usize;
        let Records {
            samples, sample, ..
        } = *self.records;
        if PLANAR {
            // One comparison for all taps.
            let taps = samples.get(start..start + TAPS)?.first_chunk::<TAPS>()?;
            return Some(taps.map(Sample::value));
        }
        let start = start.wrapping_mul(sample) + self.records.offset(lane);
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
        let offset = self.records.offset(lane);
        let start = self.chunk.start(n, lane).unwrap_or(0);
        let start = if PLANAR {
            start.wrapping_sub(offset as u32)
        } else {
            start
        };
        let mut taps = [Complex::new(0.0, 0.0); TAPS];
        for (k, tap) in taps.iter_mut().enumerate() {
            // In front of the record, indices wrap around, to its first samples.
            let index = start.wrapping_add(k as u32) as usize;
            if index < length
                && let Some(sample) = samples.get(offset + index * sample)
            {
                *tap = sample.value();
            }
        }
        taps
    }
}
