//! One beam along depth, with a growing aperture.

use super::aligned_line::AlignedLine;
use super::methods::Method;
use super::parameters::{Beamformer, Parameters};
use super::postfilter::Postfilter;
use super::segment::{Segment, SegmentGroup, constant_segments, segments_within};
use super::sizes::Sizes;
use super::workspace::{View, Workspace, with_view};
use crate::Error;
use crate::covariance::Averaging;
use crate::error::check_length;
use crate::geometry::{Active, DepthStep};
use crate::simd::{MOST_LANES, Vector, split_front};
use core::ops::Range;
use num_complex::Complex;

/// A block of a line: samples from `first` on.
///
/// It begins a segment or a block of a segment's time windows.
pub(crate) struct LineBlock<'a, F> {
    pub(crate) line: AlignedLine<'a>,
    pub(crate) first: usize,
    /// Number of samples, computed or not.
    pub(crate) samples: usize,
    /// The active set of each sample of the line.
    pub(crate) active: F,
    /// The samples that are adaptive, counted from `first`; the others are DAS.
    pub(crate) adaptive: Range<usize>,
}

impl<'a, F: Fn(usize) -> Active> LineBlock<'a, F> {
    /// The active set of the block's sample `sample`.
    #[inline(always)]
    pub(super) fn active(&self, sample: usize) -> Active {
        (self.active)(self.first + sample)
    }

    /// The indices among the block's computed samples of those within its samples `samples`.
    #[inline(always)]
    pub(super) fn outputs(&self, step: DepthStep, samples: Range<usize>) -> Range<usize> {
        let of = step.outputs_of(self.first + samples.start..self.first + samples.end);
        let before = step.outputs(self.first);
        of.start.wrapping_sub(before)..of.end.wrapping_sub(before)
    }

    /// A segment that begins at the block's sample `sample`.
    #[inline(always)]
    pub(super) fn segment(&self, sample: usize, set: Active) -> Segment<'a> {
        Segment::new(self.line, set.first, self.first + sample)
    }
}

/// First sample of a block, number of samples and active set of samples with one active set.
pub(super) type Run = (usize, usize, Active);

/// Parts of a run, one for each lane.
pub(super) struct LaneParts<'a, 'z, T> {
    segments: [Segment<'a>; MOST_LANES],
    z: [&'z mut [T]; MOST_LANES],
    /// Number of parts.
    count: usize,
}

impl<'a, 'z, T> LaneParts<'a, 'z, T> {
    /// The segments and their outputs.
    pub(super) fn used(&mut self) -> (&[Segment<'a>], &mut [&'z mut [T]]) {
        (
            self.segments.get(..self.count).unwrap_or_default(),
            self.z.get_mut(..self.count).unwrap_or_default(),
        )
    }
}

impl Beamformer {
    /// Beamforms one beam: `z[n]` from `line`, with the active set `active(n)`.
    ///
    /// With a [depth step](super::Parameters::depth_step) `s`, `z[i]` is sample `n = i·s`. One active set serves the
    /// whole time window of a sample. Samples without an active element are 0. A workspace of several lanes computes a
    /// part of the depths in each lane. See [`Beamformer::segments`] for scale and cost. `active` is called twice for
    /// each sample: the whole line is checked before any output.
    ///
    /// # Errors
    /// As [`Beamformer::segments`]; [`Error::Length`] unless `z` has [`Beamformer::line_samples`] numbers.
    #[inline]
    pub fn line<V: Vector>(
        &self,
        workspace: &mut Workspace<'_, V>,
        line: AlignedLine<'_>,
        active: impl Fn(usize) -> Active,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        self.line_within(workspace, line, active, 0..line.samples(), z)
    }

    /// Checks all segments of a block, before any output.
    pub(super) fn check_block(
        &self,
        sizes: Sizes,
        block: &LineBlock<'_, impl Fn(usize) -> Active>,
    ) -> Result<(), Error> {
        let (adaptive, direct) = (&block.adaptive, self.parameters().method.direct());
        for (first, length, set) in constant_segments(block.samples, |n| block.active(n)) {
            self.check_segment(&block.segment(first, set), set.count, length)?;
            let within =
                adaptive.start < (first + length).min(adaptive.end) && first < adaptive.end;
            if within && set.count > 0 && direct.is_none() {
                self.check_sizes(set.count, sizes)?;
            }
        }
        Ok(())
    }

    /// The computed samples of a block.
    ///
    /// Its adaptive segments are checked one after the other; [`Beamformer::check_block`] checks all before any output.
    ///
    /// Inlined, so that the compiler knows constant `sizes` of the workspace. They are read once a line, since the
    /// compiler must assume that a kernel changes them.
    #[inline(always)]
    pub(crate) fn block<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        sizes: Sizes,
        block: &LineBlock<'_, impl Fn(usize) -> Active>,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        if block.adaptive == (0..block.samples) {
            self.adaptive_block(view, sizes, block, z)
        } else {
            self.gated_block(view, sizes, block, z)
        }
    }

    /// A block whose samples are all adaptive.
    #[inline(always)]
    fn adaptive_block<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        sizes: Sizes,
        block: &LineBlock<'_, impl Fn(usize) -> Active>,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let active = |sample| block.active(sample);
        let step = self.parameters().step();
        for (first_sample, samples, set) in constant_segments(block.samples, &active) {
            let out = z.get_mut(block.outputs(step, first_sample..first_sample + samples));
            let run = (first_sample, samples, set);
            self.run(view, sizes, (block, run), out.unwrap_or_default())?;
        }
        Ok(())
    }

    /// A run of samples with one active set, a part of it in each lane.
    ///
    /// Inlined for constant sizes, if the code may be large.
    #[cfg_attr(feature = "constants", inline(always))]
    fn run<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        sizes: Sizes,
        (block, run): (&LineBlock<'_, impl Fn(usize) -> Active>, Run),
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let (first, _, set) = run;
        let count = set.count;
        let Parameters {
            method, postfilter, ..
        } = self.parameters();
        // A method without covariance has no use for parts; its postfilter has.
        if V::LANES == 1 || method.direct().is_some() && *postfilter == Postfilter::None {
            let segments = &[block.segment(first, set)];
            let group = SegmentGroup { segments, count };
            return self.segments_within(view, sizes, group, &mut [z]);
        }
        let mut parts = self.parts(V::LANES, (block, run), 1, z);
        let (segments, z) = parts.used();
        self.segments_within(view, sizes, SegmentGroup { segments, count }, z)
    }

    /// Cuts a run into a part for each lane, with `numbers` of `z` for each computed sample.
    ///
    /// A part begins a block of the run's time windows, so that its bits are those of the whole run.
    pub(super) fn parts<'a, 'z, T>(
        &self,
        lanes: usize,
        (block, (first, samples, set)): (&LineBlock<'a, impl Fn(usize) -> Active>, Run),
        numbers: usize,
        z: &'z mut [T],
    ) -> LaneParts<'a, 'z, T> {
        let windows = self.parameters().temporal_half_window.saturating_mul(2);
        let windows = windows.saturating_add(1);
        let length = samples.div_ceil(lanes.max(1)).next_multiple_of(windows);
        let mut parts = LaneParts {
            segments: [block.segment(first, set); MOST_LANES],
            z: [(); MOST_LANES].map(|()| Default::default()),
            count: 0,
        };
        let (mut rest, end) = (z, first + samples);
        let firsts = (first..end).step_by(length.max(1));
        let lanes = parts.segments.iter_mut().zip(&mut parts.z);
        for (first, (segment, z)) in firsts.zip(lanes) {
            let part = first..(first + length).min(end);
            *segment = block.segment(first, set);
            let outputs = block.outputs(self.parameters().step(), part).len();
            *z = split_front(&mut rest, outputs.saturating_mul(numbers));
            parts.count += 1;
        }
        parts
    }

    /// [`Beamformer::line`] for the samples in `adaptive`, and DAS for the others.
    ///
    /// Each sample has the same bits as in a whole line of its method. A time window reads samples outside `adaptive`.
    /// The memory must fit only the active sets within `adaptive`. `active` is called three times for each sample.
    ///
    /// # Errors
    /// As [`Beamformer::line`].
    #[inline(always)]
    pub fn line_within<V: Vector>(
        &self,
        workspace: &mut Workspace<'_, V>,
        line: AlignedLine<'_>,
        active: impl Fn(usize) -> Active,
        adaptive: Range<usize>,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        check_length("z", z.len(), self.line_samples(line.samples()))?;
        let block = LineBlock {
            line,
            first: 0,
            samples: line.samples(),
            active,
            adaptive,
        };
        let sizes = workspace.sizes();
        self.check_block(sizes, &block)?;
        with_view!(workspace, view => self.block(view, sizes, &block, z))
    }

    /// A block in which some samples are adaptive and the others are DAS.
    #[inline(always)]
    fn gated_block<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        sizes: Sizes,
        block: &LineBlock<'_, impl Fn(usize) -> Active>,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let (samples, step) = (block.samples, self.parameters().step());
        let (active, adaptive) = (|sample| block.active(sample), &block.adaptive);
        let half_window = self.parameters().temporal_half_window;
        for (first, length, set) in segments_within(samples, active, adaptive.clone(), half_window)
        {
            let out = z.get_mut(block.outputs(step, first..first + length));
            let run = (first, length, set);
            self.run(view, sizes, (block, run), out.unwrap_or_default())?;
        }
        // DAS also overwrites the unwanted samples above a segment.
        let Some(das) = Method::Das.direct() else {
            return Ok(());
        };
        let start = adaptive.start.min(samples);
        for rest in [0..start, adaptive.end.clamp(start, samples)..samples] {
            for (first, length, set) in constant_segments(rest.len(), |n| active(rest.start + n)) {
                let first = rest.start + first;
                let out = z.get_mut(block.outputs(step, first..first + length));
                let out = out.unwrap_or_default();
                let group = SegmentGroup {
                    segments: &[block.segment(first, set)],
                    count: set.count,
                };
                match set.count {
                    0 => out.fill(Complex::new(0.0, 0.0)),
                    _ => self.direct_segments(&das, view.zero, group, &mut [out]),
                }
            }
        }
        Ok(())
    }
}
