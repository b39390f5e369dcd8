//! Counts a frame of 64 lines, computed at every sample, with a bone map: frame.rs.

#![no_std]
#![no_main]

#[path = "../count/counter.rs"]
mod counter;
#[path = "frame.rs"]
mod frame;

use cortex_m_rt::entry;
use frame::Case;

const CASE: Case = Case {
    name: "mv-64-lines",
    lines: 64,
    sub_lines: 1,
    depth_step: 1,
    map_every: 1,
    bound: 44_290_000,
};

#[entry]
fn main() -> ! {
    frame::main()
}
