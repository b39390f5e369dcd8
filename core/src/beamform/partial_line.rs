//! Beamforming of a line while only its first samples are aligned.

use super::aligned_line::AlignedLine;
use super::line::LineBlock;
use super::parameters::Beamformer;
use super::workspace::{Workspace, with_view};
use crate::Error;
use crate::error::check_length;
use crate::geometry::Active;
use crate::simd::Vector;
use core::ops::Range;
use num_complex::Complex;

impl Beamformer {
    /// [`Beamformer::line_within`] for the samples that are aligned so far.
    ///
    /// `line` is a block of the line ([`AlignedLine::of_line`]) that ends at the last aligned sample and begins `K`
    /// samples before `done` or earlier. Output is written to `z`, which has the length of the whole line, from sample
    /// `done` on. Returns the first sample without output, which is `done` of the next call; the first call has 0. The
    /// block of the last call ends with the line.
    ///
    /// The bits are those of the whole line if its magnitudes lie within 10¹² of each other and 10^±15. Beyond, a faint
    /// block is more exact than in the whole line: each block has its own working scale. Time windows are summed in
    /// blocks of `2K+1` samples from each change of the active set. A call therefore ends at the beginning of such a
    /// block, and leaves up to `3K` aligned samples for the next call.
    ///
    /// ```
    /// use bonebeam::prelude::stages::*;
    /// use bonebeam::beamform::Parameters;
    ///
    /// let parameters = Parameters { temporal_half_window: 1, ..Parameters::DEFAULT };
    /// let beamformer = Beamformer::new(parameters)?;
    /// let mut memory = Memory::<200, 200>::new();
    /// let sizes = beamformer.sizes(4);
    /// let mut workspace = Workspace::new(0.0f32, sizes, memory.scratch())?;
    ///
    /// let x = [Complex::new(1.0, 0.0); 4 * 20]; // 20 samples of four elements
    /// let active = |_| Active { first: 0, count: 4 };
    /// let (mut z, mut done) = ([Complex::ZERO; 20], 0);
    /// for aligned in [10, 20] {
    ///     let line = AlignedLine::new(&x[..4 * aligned], 4)?.of_line(0, 20)?;
    ///     done = beamformer.partial_line(&mut workspace, line, done, (active, 0..20), &mut z)?;
    ///     assert_eq!(done, if aligned == 10 { 9 } else { 20 });
    /// }
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Beamformer::line_within`]; [`Error::Parameter`] for a block that begins too late.
    #[inline]
    pub fn partial_line<V: Vector>(
        &self,
        workspace: &mut Workspace<'_, V>,
        line: AlignedLine<'_>,
        done: usize,
        (active, adaptive): (impl Fn(usize) -> Active, Range<usize>),
        z: &mut [Complex<f32>],
    ) -> Result<usize, Error> {
        check_length("z", z.len(), self.line_samples(line.samples()))?;
        let end = self.last_cut(&line, &active);
        if end <= done {
            return Ok(done);
        }
        let samples = end - done;
        let within = |sample: usize| sample.saturating_sub(done).min(samples);
        let block = LineBlock {
            line,
            first: done,
            samples,
            active,
            adaptive: within(adaptive.start)..within(adaptive.end),
        };
        let sizes = workspace.sizes();
        self.check_block(sizes, &block)?;
        let z = z.get_mut(self.line_samples(done)..);
        let z = z.unwrap_or_default();
        with_view!(workspace, view => self.block(view, sizes, &block, z))?;
        Ok(end)
    }

    /// The last sample whose predecessors' time windows are aligned, and at which a block of windows begins.
    fn last_cut(&self, line: &AlignedLine<'_>, active: impl Fn(usize) -> Active) -> usize {
        let half_window = self.parameters().temporal_half_window;
        if line.end() >= line.samples() {
            return line.samples();
        }
        let last = line.end().saturating_sub(half_window);
        let mut first = 0;
        for sample in 1..=last {
            if active(sample) != active(sample - 1) {
                first = sample;
            }
        }
        // 2K + 1.
        let windows = half_window.wrapping_mul(2) | 1;
        last - (last - first) % windows
    }
}
