//! The bonebeam core for C.
//!
//! An object lives in memory of the caller, whose size follows from the object's configuration at run time. Nothing is
//! allocated, nothing unwinds. A function that can fail returns a [`Status`]. The header is `include/bonebeam.h`. Its
//! first comment states the caller's promises about pointers, once for all functions.

#![no_std]
// Stated once, in the header's first comment.
#![allow(clippy::missing_safety_doc)]

mod beamformer;
mod bounds;
mod delay;
mod frame;
mod frame_parameters;
mod image;
mod iq;
mod iq_lines;
mod memory;
mod phase_symmetry;
mod planned;
mod scan;
mod scan_line;
mod status;
mod vectors;
mod version;
mod workspace;

pub use beamformer::*;
pub use delay::*;
pub use frame::*;
pub use frame_parameters::FrameParameters;
pub use image::*;
pub use iq::*;
pub use iq_lines::*;
pub use memory::BONEBEAM_ALIGN;
pub use phase_symmetry::*;
pub use scan::*;
pub use scan_line::*;
pub use status::*;
pub use version::*;

/// Whether sub-lines are compiled in.
pub(crate) const SUB_LINES: bool = cfg!(feature = "sub-lines");

/// A complex number.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Complex {
    /// Real part.
    pub re: f32,
    /// Imaginary part.
    pub im: f32,
}

/// Consecutive elements or samples.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Range {
    /// Index of the first element or sample.
    pub first: usize,
    /// Number of elements or samples.
    pub count: usize,
}

/// Evenly spaced positions: `first + k·step` for `k` below `count`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Axis {
    /// Position of index 0, m.
    pub first: f64,
    /// Distance of neighbours, m; positive.
    pub step: f64,
    /// Number of positions.
    pub count: usize,
}

impl Range {
    pub(crate) fn samples(&self) -> core::ops::Range<usize> {
        self.first..self.first.saturating_add(self.count)
    }

    pub(crate) fn active(&self) -> bonebeam::geometry::Active {
        bonebeam::geometry::Active {
            first: self.first,
            count: self.count,
        }
    }
}

#[cfg(all(feature = "panic-handler", not(test)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        fn abort() -> !;
    }
    // SAFETY: C's abort() may be called from anywhere.
    unsafe { abort() }
}
