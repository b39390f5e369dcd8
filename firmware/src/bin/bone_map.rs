//! The core's example on a Cortex-M7: RF to bone map and bone surface in statics.
//!
//! Prints their hashes, which equal the workstation's (`cargo run --release -p bonebeam --example bone_map`).

#![no_std]
#![no_main]

#[path = "../../../core/examples/bone_map.rs"]
mod example;

use cortex_m_rt::entry;
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hprintln;
use example::{FrameMemory, bone_map};
use firmware::exit;
use static_cell::ConstStaticCell;

static MEMORY: ConstStaticCell<FrameMemory> = ConstStaticCell::new(FrameMemory::new());

#[entry]
fn main() -> ! {
    match bone_map(MEMORY.take()) {
        Ok([map, surface]) => {
            hprintln!("bone-map {map:016x} surface {surface:016x}");
            exit(EXIT_SUCCESS)
        }
        Err(error) => {
            hprintln!("error: {error}");
            exit(EXIT_FAILURE)
        }
    }
}
