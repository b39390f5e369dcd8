//! Levels of a frame, the reference of a line's shadow.

use super::detector::Detector;
use super::onset::Levels;
use super::parameters::HISTOGRAMS;
use crate::Error;
use crate::error::check_length;
use crate::instructions::integers;
use crate::memory::Scratch;
use crate::simd::split_front;

/// Finds the [`Levels`] of a frame, line by line.
///
/// Lines that arrive one at a time are compared with the levels of the previous frame.
pub struct Survey<'p, 'm> {
    detector: &'p Detector,
    shadows: &'m mut [u32],
    grey: &'m mut [u32],
}

impl<'p, 'm> Survey<'p, 'm> {
    /// Stride of the lines from which [`Detector::frame`] computes its levels.
    pub const EVERY: usize = 4;

    /// An empty survey in memory of [`Detector::need`].
    ///
    /// # Errors
    /// [`Error::Length`] if the memory is shorter.
    pub fn new(detector: &'p Detector, scratch: Scratch<'m>) -> Result<Self, Error> {
        scratch.check(detector.need())?;
        let mut real = scratch.real;
        let [shadows, grey] = [(); 2].map(|()| {
            let counts = integers(split_front(&mut real, HISTOGRAMS / 2));
            counts.fill(0);
            counts
        });
        Ok(Survey {
            detector,
            shadows,
            grey,
        })
    }

    /// Counts the grey levels of a line, and its shadows at the searched depths.
    ///
    /// A line that is black from end to end is not counted: it is outside the picture.
    ///
    /// # Errors
    /// [`Error::Length`] if the number of samples differs from the parameters'.
    pub fn line(&mut self, grey: &[u8]) -> Result<(), Error> {
        let Detector { sizes, line, .. } = self.detector;
        check_length("line", grey.len(), self.detector.parameters().samples.count)?;
        if grey.iter().all(|&level| level == 0) {
            return Ok(());
        }
        let from = line.shadow_from.saturating_add(sizes.first);
        let to = from.saturating_add(sizes.searched);
        let (mut sum, mut count) = (0u32, 0u32);
        let whole = sizes.stride.saturating_mul(sizes.cells);
        let whole = grey.get(..whole).unwrap_or_default();
        let cells = whole.rchunks_exact(sizes.stride.max(1));
        for (index, cell) in (0..sizes.cells).rev().zip(cells) {
            for &level in cell {
                sum = sum.wrapping_add(u32::from(level));
                count = count.wrapping_add(1);
                if let Some(bin) = self.grey.get_mut(usize::from(level)) {
                    *bin = bin.saturating_add(1);
                }
            }
            let mean = sum / count.max(1);
            if (from..to).contains(&index)
                && let Some(bin) = self.shadows.get_mut(mean as usize)
            {
                *bin = bin.saturating_add(1);
            }
        }
        Ok(())
    }

    /// Levels of the lines so far. Without a line all are black.
    pub fn levels(&self) -> Levels {
        Levels {
            dark: 16 * percentile(self.shadows, 2),
            tissue: 16 * percentile(self.grey, 60),
            bright: 16 * percentile(self.grey, 98),
        }
    }
}

/// The lowest level that at least `percent` per cent of the counts do not exceed.
fn percentile(counts: &[u32], percent: u64) -> u16 {
    let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
    let mut below = 0;
    for (level, &count) in (0..256u16).zip(counts) {
        below += u64::from(count);
        if below * 100 >= total * percent && below > 0 {
            return level;
        }
    }
    0
}
