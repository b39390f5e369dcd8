//! The bonebeam core on a Cortex-M7: prints the golden hashes and the RAM needs.
//!
//! The RAM needs are those of the core's workspaces.

#![no_std]
#![no_main]

mod ram;

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
    ram::print();
    exit(EXIT_SUCCESS)
}
