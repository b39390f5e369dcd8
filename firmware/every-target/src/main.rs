//! The golden cases on a bare processor, for `tests/run targets` to compare.
//!
//! It prints a line for each case.
//!
//! Processors differ only in their start-up code. `run` lists the machine of each.

#![no_std]
#![no_main]

mod start;

use bonebeam_tests::Workspaces;
use semihosting::{eprintln, println, process};
use static_cell::ConstStaticCell;

static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// Main function of every processor after its start-up.
fn run() -> ! {
    let outcome = bonebeam_tests::run(WORKSPACES.take(), &mut |name, hash| {
        println!("{name} {hash:016x}");
    });
    match outcome {
        Ok(()) => process::exit(0),
        Err(error) => {
            eprintln!("error: {error}");
            process::exit(1)
        }
    }
}
