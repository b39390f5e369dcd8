//! Delay and sum.

use crate::vector::{ComplexVector, Vector};

/// The mean over the active elements: the sum in ascending order from zero, divided by the count.
#[inline(always)]
pub(super) fn das<V: Vector>(active: &[ComplexVector<V>]) -> ComplexVector<V> {
    let mut sum = active[0].zero();
    for &x in active {
        sum = sum + x;
    }
    sum.divide(sum.re.splat(active.len() as f32))
}
