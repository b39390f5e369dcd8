//! Shows that the core does not panic: an image that cannot be linked while a panic is left in it.
//!
//! It calls every public function of the core, for one lane and with sizes that are known only at run
//! time; `tests/no_panic.py` shows that none is missing, and lists what cannot be called. What ends in a panic calls a function that is nowhere, so the linker refuses the image where the
//! optimiser has not shown that it is never reached. The image is linked, never run.
//!
//! Not in it is the wording of an error, which is the standard library's.
//!
//! What is left is found by giving the function an address, and looking for the calls:
//!
//! ```sh
//! cargo rustc --release --features no-panic --bin no_panic -- -Clink-arg=--defsym=a_panic_is_left=1
//! llvm-objdump -d -l target/thumbv7em-none-eabihf/release/no_panic | grep -B 9 'bl.*panicking'
//! ```

#![no_std]
#![no_main]

mod beamform;
mod delay;
mod geometry;
mod image;
mod phase_symmetry;
mod pipeline;
mod surface;

use core::panic::PanicInfo;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    geometry::all();
    delay::all();
    beamform::all();
    image::all();
    phase_symmetry::all();
    pipeline::all();
    surface::all();
    take(bonebeam::self_test());
    loop {
        cortex_m::asm::wfi();
    }
}

/// A value that the optimiser knows nothing of.
fn opaque<T>(value: T) -> T {
    core::hint::black_box(value)
}

/// Takes a result, so that it is computed.
fn take<T>(value: T) {
    core::hint::black_box(value);
}

#[allow(unsafe_code)]
unsafe extern "C" {
    safe fn a_panic_is_left() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    a_panic_is_left()
}
