//! Shared code of the images: output and exit status by semihosting.

#![no_std]

#[path = "../../tests/src/arrays.rs"]
mod arrays;
mod fault;
mod main_loop;
mod scanner;

pub use fault::guard_stack;
pub use main_loop::{Maps, process};
pub use scanner::{Scanner, load};

use core::panic::PanicInfo;

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, ExitStatus};
use cortex_m_semihosting::hprintln;

/// Ends the emulation with this status.
pub fn exit(status: ExitStatus) -> ! {
    debug::exit(status);
    // Without a debugger the exit has no effect.
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{info}");
    exit(EXIT_FAILURE)
}
