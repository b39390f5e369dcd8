//! Steps of the time window along segments, between computed samples.

use super::segment::Segment;
use crate::geometry::DepthStep;

/// A sample of each lane's segment: `offset` samples behind the segment's first sample that is a multiple of `step`.
#[derive(Clone, Copy)]
pub(super) struct SampleIndex {
    offset: isize,
    step: DepthStep,
}

impl SampleIndex {
    /// Computed sample `index` of each segment.
    #[inline(always)]
    pub(super) fn output(index: usize, step: DepthStep) -> Self {
        SampleIndex {
            offset: index.wrapping_mul(step.get()) as isize,
            step,
        }
    }

    /// The next sample that is read.
    #[inline(always)]
    pub(super) fn next(self) -> Self {
        let offset = self.offset.wrapping_add(self.step.get() as isize);
        SampleIndex { offset, ..self }
    }

    /// Its index in the segment's line; `None` before the line.
    #[inline(always)]
    pub(super) fn sample(self, segment: &Segment<'_>) -> Option<usize> {
        let first = self.step.first(segment.first_sample);
        first.checked_add_signed(self.offset)
    }
}

/// The path of the time window along segments.
///
/// Without a time window only the computed samples are read, each push one of every lane. A window reads every
/// sample, and lanes whose segments begin at different places are due at different pushes.
#[derive(Clone, Copy)]
pub(super) struct Pushes {
    half_window: usize,
    /// Distance from one push to the next.
    stride: DepthStep,
    /// Pushes from one computed sample to the next.
    step: DepthStep,
}

impl Pushes {
    #[inline(always)]
    pub(super) fn new(half_window: usize, step: DepthStep) -> Self {
        let (stride, step) = match half_window {
            0 => (step, DepthStep::ONE),
            _ => (DepthStep::ONE, step),
        };
        Pushes {
            half_window,
            stride,
            step,
        }
    }

    /// Number of pushes for `outputs` computed samples of a segment.
    #[inline(always)]
    pub(super) fn count(self, segment: &Segment<'_>, outputs: usize) -> usize {
        self.step.span(segment.first_sample, outputs) + 2 * self.half_window
    }

    #[inline(always)]
    pub(super) fn read(self, push: usize) -> SampleIndex {
        SampleIndex {
            offset: self.offset(push as isize - self.half_window as isize),
            step: self.stride,
        }
    }

    /// The sample in the middle of the time window that is complete after a push from `2K` on.
    #[inline(always)]
    pub(super) fn complete(self, push: usize) -> SampleIndex {
        SampleIndex {
            offset: self.offset(push as isize - 2 * self.half_window as isize),
            step: self.stride,
        }
    }

    #[inline(always)]
    fn offset(self, pushes: isize) -> isize {
        pushes.wrapping_mul(self.stride.get() as isize)
    }

    /// Whether the window is complete for a computed sample of any segment.
    #[inline(always)]
    pub(super) fn is_due(self, segments: &[Segment<'_>], push: usize) -> bool {
        if push < 2 * self.half_window {
            return false;
        }
        self.step.get() == 1 || segments.iter().any(|of| self.output(of, push).is_some())
    }

    /// The index among a segment's computed samples of the one that is complete after a push from `2K` on.
    #[inline(always)]
    pub(super) fn output(self, segment: &Segment<'_>, push: usize) -> Option<usize> {
        let behind = push - 2 * self.half_window;
        if self.step.get() == 1 {
            return Some(behind);
        }
        let sample = segment.first_sample.wrapping_add(behind);
        let before = self.step.outputs(segment.first_sample);
        let is_computed = sample.is_multiple_of(self.step.get());
        is_computed.then(|| self.step.outputs(sample).wrapping_sub(before))
    }
}
