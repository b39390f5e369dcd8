//! Samples of one line with one active aperture.

use super::aligned_line::AlignedLine;
use crate::geometry::{Active, DepthStep, Steering};
use core::ops::Range;
use num_complex::Complex;

/// Consecutive samples of one line with one active aperture: a lane's work.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Segment<'a> {
    /// The beam.
    pub line: AlignedLine<'a>,
    /// The first active element.
    pub first_element: usize,
    /// The first sample. Output begins at the first computed sample from there on.
    pub first_sample: usize,
}

impl<'a> Segment<'a> {
    /// A segment of `line` from its first active element and its first sample on.
    #[inline(always)]
    pub const fn new(line: AlignedLine<'a>, first_element: usize, first_sample: usize) -> Self {
        Segment {
            line,
            first_element,
            first_sample,
        }
    }

    /// The snapshots of all samples from the segment's first one on.
    #[inline(always)]
    pub(super) fn all_snapshots(&self) -> impl Iterator<Item = &'a [Complex<f32>]> {
        let samples = self.line.samples_from(self.first_sample);
        samples.chunks_exact(self.line.elements())
    }

    /// The snapshots of the computed samples from the segment's first one on.
    ///
    /// Each slice extends to the next computed sample.
    #[inline(always)]
    pub(super) fn snapshots(&self, step: DepthStep) -> impl Iterator<Item = &'a [Complex<f32>]> {
        let samples = self.line.samples_from(step.first(self.first_sample));
        samples.chunks(self.line.elements().saturating_mul(step.get()).max(1))
    }
}

/// The work of a vector: a segment in each lane, all with `count` active elements.
#[derive(Clone, Copy)]
pub(super) struct SegmentGroup<'s, 'a> {
    pub(super) segments: &'s [Segment<'a>],
    pub(super) count: usize,
}

/// Segments with the directions of their lines' sub-lines.
#[derive(Clone, Copy, Debug)]
pub struct SteeredSegments<'s, 'a> {
    /// At most one segment a lane.
    pub segments: &'s [Segment<'a>],
    /// Directions of each segment's line, from the line's first sample on.
    pub steering: &'s [Steering<'a>],
}

impl<'s, 'a> SteeredSegments<'s, 'a> {
    /// Segments with the directions of their lines.
    #[inline(always)]
    pub const fn new(segments: &'s [Segment<'a>], steering: &'s [Steering<'a>]) -> Self {
        SteeredSegments { segments, steering }
    }
}

/// Splits `0..samples` at changes of the active set.
///
/// Items are `(first sample, number of samples, active)`.
pub fn constant_segments(
    samples: usize,
    active: impl Fn(usize) -> Active,
) -> impl Iterator<Item = (usize, usize, Active)> {
    let mut start = 0;
    core::iter::from_fn(move || {
        if start >= samples {
            return None;
        }
        let set = active(start);
        let mut end = start + 1;
        while end < samples && active(end) == set {
            end += 1;
        }
        let segment = (start, end - start, set);
        start = end;
        Some(segment)
    })
}

/// The segments of [`constant_segments`], cut to the samples in `wanted`.
///
/// A time window of `2K+1` samples is summed in blocks counted from a segment's first sample. A segment is therefore
/// cut before `wanted` at a whole number of blocks, with up to `2K` unwanted samples.
pub fn segments_within(
    samples: usize,
    active: impl Fn(usize) -> Active,
    wanted: Range<usize>,
    temporal_half_window: usize,
) -> impl Iterator<Item = (usize, usize, Active)> {
    let block = temporal_half_window.saturating_mul(2).saturating_add(1);
    constant_segments(samples, active).filter_map(move |(first, samples, set)| {
        let end = (first + samples).min(wanted.end);
        let above = wanted.start.saturating_sub(first);
        let first = first + above - above.checked_rem(block).unwrap_or(0);
        let within = wanted.start < end && first < end;
        within.then(|| (first, end - first, set))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Five samples of one element, five of two.
    fn active(sample: usize) -> Active {
        Active::new(0, 1 + sample / 5)
    }

    #[test]
    fn a_segment_has_a_wanted_sample() {
        for (start, end) in (0..=10).flat_map(|start| (start..=10).map(move |end| (start, end))) {
            let segments: Vec<_> = segments_within(10, active, start..end, 1).collect();
            let with_wanted = (0..2).filter(|k| (start..end).any(|sample| sample / 5 == *k));
            assert_eq!(segments.len(), with_wanted.count(), "{start}..{end}");
            for (first, samples, set) in segments {
                assert!(samples > 0 && active(first) == set && active(first + samples - 1) == set);
            }
        }
    }
}
