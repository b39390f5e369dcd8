//! The shape of a segment's samples, as arguments or as constants.

use super::apodization::Window;
use super::parameters::Parameters;
use crate::linalg::size::{Known, Size};

/// Active elements, subaperture and time window of a segment.
pub(super) trait Extent: Copy {
    /// The number of active elements.
    fn count(self) -> impl Size;

    /// The subaperture's length.
    fn subaperture(self) -> impl Size;

    /// `K` of the time window.
    fn half_window(self, parameters: &Parameters) -> usize;

    fn apodization(self, parameters: &Parameters) -> Option<Window>;
}

/// A shape that is known at run time, with or without a time window. Two numbers, so that it is passed in registers.
#[derive(Clone, Copy)]
pub(super) struct Given<const WINDOW: bool> {
    pub(super) count: usize,
    pub(super) subaperture: usize,
}

impl<const WINDOW: bool> Extent for Given<WINDOW> {
    #[inline(always)]
    fn count(self) -> impl Size {
        self.count
    }

    #[inline(always)]
    fn subaperture(self) -> impl Size {
        self.subaperture
    }

    #[inline(always)]
    fn half_window(self, parameters: &Parameters) -> usize {
        if WINDOW {
            parameters.temporal_half_window
        } else {
            0
        }
    }

    #[inline(always)]
    fn apodization(self, parameters: &Parameters) -> Option<Window> {
        parameters.window()
    }
}

/// `M` elements in subapertures of `L`, without time window and apodization.
#[derive(Clone, Copy)]
pub(super) struct Constant<const M: usize, const L: usize>;

impl<const M: usize, const L: usize> Extent for Constant<M, L> {
    #[inline(always)]
    fn count(self) -> impl Size {
        Known::<M>
    }

    #[inline(always)]
    fn subaperture(self) -> impl Size {
        Known::<L>
    }

    #[inline(always)]
    fn half_window(self, _: &Parameters) -> usize {
        0
    }

    #[inline(always)]
    fn apodization(self, _: &Parameters) -> Option<Window> {
        None
    }
}
