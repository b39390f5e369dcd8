//! Division of a line into blocks.

use crate::geometry::Active;
use core::ops::Range;

/// Cuts a line into blocks: at changes of the active set, and at multiples of the time window's length from each
/// change.
pub(super) struct Cuts<F> {
    samples: usize,
    window: usize,
    block: usize,
    active: F,
    /// The first sample without output so far.
    first: usize,
    /// The last change of the active set before that, and the set.
    segment: (usize, Active),
}

impl<F: Fn(usize) -> Active> Cuts<F> {
    /// Blocks of at most `block` samples, which is at least the time window's length.
    pub(super) fn new(samples: usize, half_window: usize, block: usize, active: F) -> Self {
        Cuts {
            samples,
            window: half_window.saturating_mul(2).saturating_add(1),
            block,
            segment: (0, active(0)),
            active,
            first: 0,
        }
    }
}

impl<F: Fn(usize) -> Active> Iterator for Cuts<F> {
    type Item = Range<usize>;

    fn next(&mut self) -> Option<Range<usize>> {
        let first = self.first;
        if first >= self.samples {
            return None;
        }
        let last = first.saturating_add(self.block).min(self.samples);
        let mut end = last;
        if last < self.samples {
            end = first + 1;
            for sample in first + 1..=last {
                let set = (self.active)(sample);
                if set != self.segment.1 {
                    self.segment = (sample, set);
                    end = sample;
                } else if (sample - self.segment.0).is_multiple_of(self.window) {
                    end = sample;
                }
            }
        }
        self.first = end;
        Some(first..end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every sample occurs once, in blocks within the limit, and cuts change no bit.
    #[test]
    fn lines_are_cut_at_blocks_from_where_the_active_set_changed() {
        let samples = 100;
        let active = |sample: usize| Active::new(0, [3, 4, 9, 9][sample / 30]);
        for half_window in [0, 1, 5, 10] {
            let window = 2 * half_window + 1;
            for block in (window..=2 * samples).step_by(crate::step(41)) {
                let mut next = 0;
                for own in Cuts::new(samples, half_window, block, active) {
                    assert!(own.start == next && !own.is_empty() && own.len() <= block);
                    let changed = (0..=own.start)
                        .rfind(|&n| n == 0 || active(n) != active(n - 1))
                        .unwrap_or(0);
                    assert_eq!((own.start - changed) % window, 0, "{half_window} {block}");
                    next = own.end;
                }
                assert_eq!(next, samples);
            }
        }
    }
}
