//! The I/Q of a record.

use crate::Complex;
use crate::delay::record::{IqLayout, IqSamples, Record, Samples};

impl<'a> Record<'a> {
    /// Factor of the samples.
    pub(super) fn scale(&self) -> f32 {
        match self.samples {
            Samples::Iq(IqSamples::Counts(_, scale), _) => scale,
            _ => 1.0,
        }
    }

    /// Position of samples of the type `T` in memory.
    pub(super) fn window<T>(&self, samples: &'a [T], layout: IqLayout) -> Window<'a, T> {
        let (elements, length) = (self.elements(), self.samples());
        let (element, sample) = match layout {
            IqLayout::Planar => (length, 1),
            IqLayout::Interleaved => (1, elements),
        };
        Window {
            samples,
            element,
            sample,
            length,
        }
    }
}

/// Samples of either order, with the strides of elements and of samples.
#[derive(Clone, Copy)]
pub(super) struct Window<'a, T> {
    pub(super) samples: &'a [T],
    pub(super) element: usize,
    pub(super) sample: usize,
    pub(super) length: usize,
}

/// A sample of a record in memory.
pub(super) trait Sample: Copy {
    fn value(self) -> Complex<f32>;
}

impl Sample for Complex<f32> {
    #[inline(always)]
    fn value(self) -> Complex<f32> {
        self
    }
}

impl Sample for [i16; 2] {
    #[inline(always)]
    fn value(self) -> Complex<f32> {
        Complex::new(f32::from(self[0]), f32::from(self[1]))
    }
}

impl<T: Sample> Window<'_, T> {
    /// `TAPS` samples of an element from `first` on; those outside the record are 0.
    #[inline(always)]
    pub(super) fn taps<const TAPS: usize>(
        &self,
        element: usize,
        first: i32,
    ) -> [Complex<f32>; TAPS] {
        let mut taps = [Complex::new(0.0, 0.0); TAPS];
        // A negative index becomes large.
        let first = first as u32 as usize;
        if first < self.length.saturating_sub(TAPS - 1) {
            let start = element * self.element + first * self.sample;
            // A separate path with one comparison for all taps, for vectors. A microcontroller takes 5 % longer with
            // it.
            if cfg!(target_pointer_width = "64")
                && self.sample == 1
                && let Some(samples) = self
                    .samples
                    .get(start..)
                    .and_then(<[T]>::first_chunk::<TAPS>)
            {
                return samples.map(Sample::value);
            }
            for (k, tap) in taps.iter_mut().enumerate() {
                if let Some(sample) = self.samples.get(start + k * self.sample) {
                    *tap = sample.value();
                }
            }
        } else {
            self.at_the_edge(element, first, &mut taps);
        }
        taps
    }

    /// The samples `index` and after it of the element that begins at `first`; 0 outside the record. In front
    /// of it, indices wrap around.
    #[cold]
    #[inline(never)]
    pub(super) fn edge(&self, first: usize, index: u32) -> [T; 2]
    where
        T: Default,
    {
        [0, 1].map(|k| {
            let index = index.wrapping_add(k) as usize;
            let sample = (index < self.length).then(|| first + index * self.sample);
            let sample = sample.and_then(|sample| self.samples.get(sample));
            sample.copied().unwrap_or_default()
        })
    }

    #[cold]
    #[inline(never)]
    fn at_the_edge(&self, element: usize, first: usize, taps: &mut [Complex<f32>]) {
        for (k, tap) in taps.iter_mut().enumerate() {
            // In front of the record, indices wrap around, to its first samples.
            let index = (first as u32).wrapping_add(k as u32) as usize;
            if index < self.length
                && let Some(sample) = self
                    .samples
                    .get(element * self.element + index * self.sample)
            {
                *tap = sample.value();
            }
        }
    }
}
