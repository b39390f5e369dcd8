//! Memory of the coherence of a frame's samples.

use crate::Error;
use crate::beamform::{AlignedLine, CoherenceOfLine, ShortLagCoherence};
use crate::error::check_length;
use crate::geometry::Active;
use crate::instructions::integers;
use crate::simd::split_front;
use crate::surface::level;

/// Coherence of all lines, in the memory of [`len`].
pub(super) struct CoherenceMap<'m> {
    coherence: ShortLagCoherence,
    window: &'m mut [f32],
    /// The line in work.
    row: &'m mut [u8],
    /// From 0 for none or less to 255 for 1.
    levels: &'m mut [u8],
}

/// Length of the memory: a time window, and a byte for each sample of all lines and of the line in work.
///
/// A line has `samples` samples, all lines have `all`.
pub(super) const fn len(coherence: ShortLagCoherence, samples: usize, all: usize) -> usize {
    let bytes = all.saturating_add(samples);
    coherence.need().real.saturating_add(bytes.div_ceil(4))
}

impl<'m> CoherenceMap<'m> {
    /// No coherence in any line.
    pub(super) fn new(
        coherence: ShortLagCoherence,
        (samples, all): (usize, usize),
        memory: &'m mut [f32],
    ) -> Result<Self, Error> {
        coherence.check_window(samples)?;
        let expected = len(coherence, samples, all);
        check_length("coherence memory", memory.len(), expected)?;
        let mut memory = memory;
        let window = split_front(&mut memory, coherence.need().real);
        let mut bytes: &mut [u8] = integers(memory);
        let row = split_front(&mut bytes, samples);
        let levels = split_front(&mut bytes, all);
        levels.fill(0);
        Ok(CoherenceMap {
            coherence,
            window,
            row,
            levels,
        })
    }

    /// The beginning of a line.
    pub(super) fn line(&mut self) -> CoherenceRow<'_> {
        CoherenceRow {
            samples: CoherenceOfLine::new(self.coherence, self.window),
            out: self.row.iter_mut(),
        }
    }

    /// Keeps the line in work as line `line`.
    pub(super) fn keep(&mut self, line: usize) {
        let mut rows = self.levels.chunks_exact_mut(self.row.len().max(1));
        for (kept, row) in rows.nth(line).into_iter().flatten().zip(&*self.row) {
            *kept = *row;
        }
    }

    /// `[line][sample]`.
    pub(super) fn levels(&self) -> &[u8] {
        self.levels
    }
}

/// Coherence of a line in work.
pub(super) struct CoherenceRow<'m> {
    samples: CoherenceOfLine<'m>,
    out: core::slice::IterMut<'m, u8>,
}

impl CoherenceRow<'_> {
    /// Takes the samples of a block that the blocks before it did not have.
    #[inline(always)]
    pub(super) fn block(&mut self, line: AlignedLine<'_>, active: impl Fn(usize) -> Active) {
        self.samples.block(line, active, |coherence| {
            if let Some(out) = self.out.next() {
                *out = level(255.0 * coherence);
            }
        });
    }
}
