//! The sum over a window of neighbouring samples (the outer sum of Eq. 2), by two stacks.
//!
//! A running add-and-subtract over time would leave an echo's rounding error in the shadow behind
//! it. The two-stack sum only adds: the last `2K+1` matrices stand in blocks of `2K+1`; the older
//! block is kept as suffix sums, the newer one as one growing prefix, and a window is one suffix
//! plus the prefix. Three additions an entry and sample, whatever `K` is.

use crate::lanes::Scalar;

/// The window's memory: `SLOTS ≥ 2K+1` matrices of `L × L`, and the prefix.
///
/// Only the lower triangle of each matrix is used.
#[derive(Clone, Debug)]
pub struct TimeWindow<S, const L: usize, const SLOTS: usize> {
    slots: [[[S; L]; L]; SLOTS],
    prefix: [[S; L]; L],
    /// Position in the newer block.
    position: usize,
}

impl<S: Copy, const L: usize, const SLOTS: usize> TimeWindow<S, L, SLOTS> {
    /// An empty window; `zero` is the scalar's zero.
    pub const fn new(zero: S) -> Self {
        TimeWindow {
            slots: [[[zero; L]; L]; SLOTS],
            prefix: [[zero; L]; L],
            position: 0,
        }
    }

    /// Starts a new run: what was pushed before is never read again.
    pub fn clear(&mut self) {
        self.position = 0;
    }

    /// Where the next sample's matrix is to be written, before [`TimeWindow::push`].
    pub fn slot(&mut self) -> &mut [[S; L]; L] {
        &mut self.slots[self.position]
    }

    /// Takes the matrix in [`TimeWindow::slot`] into the window of `length = 2K+1` samples and,
    /// where `sum` is given (from the `length`-th push of a run on), writes the window's sum to it.
    ///
    /// Order: `prefix` adds the newer block's matrices oldest first; a suffix adds newest first;
    /// the sum is `suffix + prefix`.
    #[inline]
    pub fn push<const W: usize>(
        &mut self,
        subarray: usize,
        length: usize,
        sum: Option<&mut [[S; L]; L]>,
    ) where
        S: Scalar<W>,
    {
        let here = self.position;
        for i in 0..subarray {
            let row = &self.slots[here][i];
            let prefix = &mut self.prefix[i];
            if here == 0 {
                prefix[..=i].copy_from_slice(&row[..=i]);
            } else {
                for j in 0..=i {
                    prefix[j] = prefix[j] + row[j];
                }
            }
        }
        if let Some(sum) = sum {
            for i in 0..subarray {
                let prefix = &self.prefix[i];
                if here + 1 == length {
                    sum[i][..=i].copy_from_slice(&prefix[..=i]);
                } else {
                    let suffix = &self.slots[here + 1][i];
                    for j in 0..=i {
                        sum[i][j] = suffix[j] + prefix[j];
                    }
                }
            }
        }
        if here + 1 == length {
            for slot in (1..length).rev() {
                let (older, newer) = self.slots.split_at_mut(slot);
                for i in 0..subarray {
                    for j in 0..=i {
                        older[slot - 1][i][j] = older[slot - 1][i][j] + newer[0][i][j];
                    }
                }
            }
            self.position = 0;
        } else {
            self.position = here + 1;
        }
    }
}
