//! Selection of computed samples: every `depth_step`-th of a line.

use core::num::NonZeroUsize;
use core::ops::Range;

/// Distance between computed samples of a line, in aligned samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthStep(NonZeroUsize);

impl DepthStep {
    /// The depth step of a number; 1 for 0.
    #[inline(always)]
    pub(crate) fn new(step: usize) -> Self {
        DepthStep(NonZeroUsize::new(step).unwrap_or(NonZeroUsize::MIN))
    }

    /// Every sample is computed.
    pub(crate) const ONE: Self = DepthStep(NonZeroUsize::MIN);

    /// The depth step as a number.
    #[inline(always)]
    pub(crate) fn get(self) -> usize {
        self.0.get()
    }

    /// The number of computed samples among the first `samples` of a line.
    #[inline(always)]
    pub(crate) fn outputs(self, samples: usize) -> usize {
        if self.get() == 1 {
            return samples;
        }
        samples / self.0 + usize::from(!samples.is_multiple_of(self.get()))
    }

    /// The index of the last computed sample at or before `sample`.
    #[inline(always)]
    pub(crate) fn index(self, sample: usize) -> usize {
        if self.get() == 1 {
            return sample;
        }
        sample / self.0
    }

    /// The indices of the computed samples among a line's samples `samples`.
    #[inline(always)]
    pub(crate) fn outputs_of(self, samples: Range<usize>) -> Range<usize> {
        self.outputs(samples.start)..self.outputs(samples.end)
    }

    /// Whether a sample is computed.
    #[inline(always)]
    pub(crate) fn includes(self, sample: usize) -> bool {
        self.get() == 1 || sample.is_multiple_of(self.get())
    }

    /// The first computed sample at or after `sample`.
    #[inline(always)]
    pub(crate) fn first(self, sample: usize) -> usize {
        if self.get() == 1 {
            return sample;
        }
        self.outputs(sample).saturating_mul(self.get())
    }

    /// Samples of a segment up to the last of its `outputs` computed ones.
    #[inline(always)]
    pub(crate) fn span(self, first_sample: usize, outputs: usize) -> usize {
        if self.get() == 1 || outputs == 0 {
            return outputs;
        }
        let between = (outputs - 1).saturating_mul(self.get());
        let above = self.first(first_sample).saturating_sub(first_sample);
        above.saturating_add(between).saturating_add(1)
    }
}
