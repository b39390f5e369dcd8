//! The bonebeam core on a Cortex-M7: runs the golden cases and prints their hashes, then what RAM
//! the core's workspaces take. Output and exit status go to the host by semihosting.

#![no_std]
#![no_main]

mod ram;

use core::panic::PanicInfo;

use bonebeam_tests::Workspaces;
use cortex_m_rt::entry;
use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS, ExitStatus};
use cortex_m_semihosting::hprintln;
use static_cell::ConstStaticCell;

static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

#[entry]
fn main() -> ! {
    let outcome = bonebeam_tests::run(WORKSPACES.take(), &mut |name, hash| {
        hprintln!("{name} {hash:016x}");
    });
    if let Err(error) = outcome {
        hprintln!("error: {error}");
        exit(EXIT_FAILURE);
    }
    ram::print();
    exit(EXIT_SUCCESS)
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{info}");
    exit(EXIT_FAILURE)
}

fn exit(status: ExitStatus) -> ! {
    debug::exit(status);
    // Without a debugger nobody takes the exit.
    loop {
        cortex_m::asm::wfi();
    }
}
