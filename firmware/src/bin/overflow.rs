//! Overflows its stack on purpose: the first word too many is a fault.
//!
//! `tests/run boards` checks that the fault is reported, within a frame of the stack's end. With statics below the
//! stack and no guard, the stack would overwrite all of them first, without a sign.

#![no_std]
#![no_main]

use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m_rt::entry;
use cortex_m_semihosting::debug::EXIT_SUCCESS;
use firmware::{exit, guard_stack};

/// Statics that an overflow would overwrite.
static STATICS: [AtomicU32; 16 << 10] = [const { AtomicU32::new(0) }; 16 << 10];

#[entry]
fn main() -> ! {
    if let Some(mut peripherals) = cortex_m::Peripherals::take() {
        guard_stack(&mut peripherals.MPU);
    }
    STATICS[0].store(deeper(0), Ordering::Relaxed);
    black_box(&STATICS);
    exit(EXIT_SUCCESS)
}

#[inline(never)]
fn deeper(depth: u32) -> u32 {
    let frame = black_box([depth; 16]);
    if black_box(true) {
        return deeper(depth + 1) ^ frame[3];
    }
    depth
}
