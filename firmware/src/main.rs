//! The bonebeam core on a Cortex-M7: prints the golden hashes, and the bytes of stages that are objects.

#![no_std]
#![no_main]

use bonebeam::prelude::stages::*;
use bonebeam_tests::Workspaces;
use cortex_m_rt::entry;
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hprintln;
use firmware::exit;
use static_cell::ConstStaticCell;

static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

#[entry]
fn main() -> ! {
    if let Err(method) = bonebeam::self_test() {
        hprintln!("error: {method} has other bits");
        exit(EXIT_FAILURE);
    }
    let outcome = bonebeam_tests::run(WORKSPACES.take(), &mut |name, hash| {
        hprintln!("{name} {hash:016x}");
    });
    if let Err(error) = outcome {
        hprintln!("error: {error}");
        exit(EXIT_FAILURE);
    }
    hprintln!("RAM delay stage {}", Delay::BYTES);
    hprintln!("RAM delay stage, I/Q {}", IqDelay::BYTES);
    hprintln!("RAM golden cases, all workspaces {}", Workspaces::BYTES);
    exit(EXIT_SUCCESS)
}
