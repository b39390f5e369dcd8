//! A stage of the solution for several directions, as a function of its own.

use crate::beamform::workspace::{Directions, Solver};
use crate::simd::{Scalar, Vector, vectorize};

#[inline(always)]
pub(super) fn no_lane<V: Vector>(zero: V) -> V::Mask {
    zero.mask(
        #[inline(always)]
        |_| false,
    )
}

/// Runs a kernel, each as a separate function (see `segments`).
#[inline(never)]
pub(super) fn stage<S: Scalar<V>, V: Vector, R>(
    zero: V,
    solver: &mut Solver<'_, S, V>,
    directions: &mut Directions<'_, S, V>,
    kernel: impl FnOnce(&mut Solver<'_, S, V>, &mut Directions<'_, S, V>) -> R,
) -> R {
    vectorize!(zero, kernel(solver, directions))
}
