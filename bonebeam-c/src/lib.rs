//! The bonebeam core for C.
//!
//! Storage is the caller's, of constant size and alignment, and set up in place. Nothing is allocated,
//! nothing unwinds. A function that can fail returns a [`Status`] and leaves its outputs alone; pointers
//! must be aligned, may be null only where that is said, and outputs must not overlap inputs. The header
//! is `include/bonebeam.h`.

#![no_std]

mod beamformer;
mod delay;
mod image;
mod iq;
mod iq_lines;
mod memory;
mod phase_symmetry;
mod scan_line;
mod status;

pub use beamformer::*;
pub use delay::*;
pub use image::*;
pub use iq::*;
pub use iq_lines::*;
pub use phase_symmetry::*;
pub use scan_line::*;
pub use status::*;

/// A complex number.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Complex {
    /// The real part.
    pub re: f32,
    /// The imaginary part.
    pub im: f32,
}

/// Consecutive active elements.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Active {
    /// The first of them.
    pub first: usize,
    /// How many.
    pub count: usize,
}

/// Evenly spaced positions: `first + k·step` for `k` below `count`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Axis {
    /// The position of index 0, m.
    pub first: f64,
    /// From one index to the next, m; positive.
    pub step: f64,
    /// How many positions there are.
    pub count: usize,
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
