//! Shows that the core does not panic: the image links only without a panic.
//!
//! It calls every public function of the core, for one lane and with sizes known only at run time.
//! `tests/no_panic.py` shows that none is missing, and lists those that cannot be called. A panic calls a function
//! that does not exist. The linker therefore refuses the image unless the optimiser has shown that no panic is
//! reached. The image is linked, never run.
//!
//! The text of an error is left out: the standard library formats it.
//!
//! To find a remaining panic, give the function an address, and look for its calls:
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

/// A value unknown to the optimiser.
fn opaque<T>(value: T) -> T {
    core::hint::black_box(value)
}

/// Uses a result, so that it is computed.
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
