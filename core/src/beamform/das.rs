//! Delay and sum.

use crate::lanes::{ComplexLanes, Lanes};

/// The mean over the active elements: the sum in ascending order from zero, divided by the count.
#[inline]
pub(super) fn das<const W: usize>(active: &[ComplexLanes<W>]) -> ComplexLanes<W> {
    let mut sum = ComplexLanes::ZERO;
    for &x in active {
        sum = sum + x;
    }
    let count = Lanes::splat(active.len() as f32);
    ComplexLanes {
        re: sum.re / count,
        im: sum.im / count,
    }
}
