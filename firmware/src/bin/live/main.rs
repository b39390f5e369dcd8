//! Counts a frame of 32 lines of two sub-lines: frame.rs.
//!
//! It is computed at every second sample, with a bone map for every third frame.

#![no_std]
#![no_main]

#[path = "../count/counter.rs"]
mod counter;
#[path = "frame.rs"]
mod frame;

use cortex_m_rt::entry;
use frame::Case;

const CASE: Case = Case {
    name: "mv-32-lines-2-sub-lines-step-2",
    lines: 32,
    sub_lines: 2,
    depth_step: 2,
    map_every: 3,
    bound: 16_000_000,
};

#[entry]
fn main() -> ! {
    frame::main()
}
