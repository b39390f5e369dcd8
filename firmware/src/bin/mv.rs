//! Minimum variance alone: what an image of one method takes, and that its bits are the same.
//!
//! Ends with a failure if a line has other bits. Without the feature `eigenspace`, the linker refuses an image larger
//! than firmware/mv.x allows.

#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;

use bonebeam::beamform::{Parameters, Sizes};
use bonebeam::prelude::stages::*;
use cortex_m_rt::entry;
use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use static_cell::ConstStaticCell;

const ELEMENTS: usize = 16;
const SAMPLES: usize = 8;
const PARAMETERS: Parameters = Parameters::of(Method::Mv);
const SIZES: Sizes = PARAMETERS.sizes(ELEMENTS);
const NEED: Need = SIZES.need();
/// FNV-1a over the words of the line, with and without the feature `eigenspace`.
const HASH: u32 = 0x6c74_36b2;

struct Arrays {
    memory: Memory<{ NEED.real }, { NEED.complex }>,
    x: [Complex<f32>; SAMPLES * ELEMENTS],
    z: [Complex<f32>; SAMPLES],
}

static ARRAYS: ConstStaticCell<Arrays> = ConstStaticCell::new(Arrays {
    memory: Memory::new(),
    x: [Complex::new(0.0, 0.0); SAMPLES * ELEMENTS],
    z: [Complex::new(0.0, 0.0); SAMPLES],
});

#[entry]
fn main() -> ! {
    end(matches!(line(black_box(ARRAYS.take())), Ok(HASH)))
}

/// The hash of a line of noise.
fn line(arrays: &mut Arrays) -> Result<u32, Error> {
    let mut state = 1u32;
    for x in &mut arrays.x {
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as f32
        };
        *x = Complex::new(next(), next());
    }
    let beamformer = Beamformer::new(PARAMETERS)?;
    let mut workspace = Workspace::new(0.0, SIZES, arrays.memory.scratch())?;
    let line = AlignedLine::new(&arrays.x, ELEMENTS)?;
    let all = |_| Active::new(0, ELEMENTS);
    beamformer.line(&mut workspace, line, all, &mut arrays.z)?;
    let words = arrays.z.iter().flat_map(|z| [z.re, z.im]);
    let mix = |hash: u32, word: f32| (hash ^ word.to_bits()).wrapping_mul(0x0100_0193);
    Ok(words.fold(0x811c_9dc5, mix))
}

/// Ends the emulation.
fn end(right: bool) -> ! {
    debug::exit(if right { EXIT_SUCCESS } else { EXIT_FAILURE });
    loop {
        cortex_m::asm::wfi();
    }
}

/// Without a message, which would be most of the image.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    end(false)
}
