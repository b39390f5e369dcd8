//! The golden cases on a bare processor: prints a line a case, for `tests/run targets` to compare.
//!
//! How a processor starts is all that differs from one to another; `run` says which machine each is.

#![no_std]
#![no_main]

mod start;

use bonebeam_tests::Workspaces;
use semihosting::{eprintln, println, process};
use static_cell::ConstStaticCell;

static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// What every processor does when it has started.
fn golden() -> ! {
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
