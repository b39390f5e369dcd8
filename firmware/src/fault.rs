//! A stack overflow becomes a fault; a fault prints a line and ends the emulation.
//!
//! A product would reset.
#![allow(
    unsafe_code,
    reason = "a fault leaves a stack that no function may use"
)]

use core::arch::naked_asm;

use cortex_m::peripheral::MPU;
use cortex_m_semihosting::debug::EXIT_FAILURE;
use cortex_m_semihosting::hprintln;

use crate::exit;

/// Number of guarded bytes below the stack's end: more than any frame has.
///
/// The end is a multiple of it.
const GUARD: usize = 64 << 10;

/// Forbids all access below the stack: an overflow is a fault at once.
///
/// That holds with and without memory there. The guard needs no memory itself.
pub fn guard_stack(mpu: &mut MPU) {
    const NUMBER: u32 = 0;
    const VALID: u32 = 1 << 4;
    const NEVER_EXECUTED: u32 = 1 << 28;
    const ENABLED: u32 = 1;
    const REST_AS_WITHOUT: u32 = 1 << 2;
    let size = GUARD.trailing_zeros() - 1;
    let begin = cortex_m_stack::stack().end.addr() - GUARD;
    // SAFETY: the memory maps keep the program out of the region below the stack; its permission 0 is no access.
    unsafe {
        mpu.rbar.write(begin as u32 | VALID | NUMBER);
        mpu.rasr.write(NEVER_EXECUTED | size << 1 | ENABLED);
        mpu.ctrl.write(REST_AS_WITHOUT | ENABLED);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Resets the stack pointer, since no stack may be left, and calls [`faulted`].
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!(
        "mov r0, sp",
        "movw r1, #:lower16:_stack_start",
        "movt r1, #:upper16:_stack_start",
        "mov sp, r1",
        "b {faulted}",
        faulted = sym faulted,
    )
}

/// Reports a fault with the stack down to `pointer`.
extern "C" fn faulted(pointer: usize) -> ! {
    let end = cortex_m_stack::stack().end.addr();
    match end.checked_sub(pointer) {
        None | Some(0) => hprintln!("error: a hard fault"),
        Some(bytes) => hprintln!("error: the stack overflowed by {bytes} bytes"),
    }
    exit(EXIT_FAILURE)
}
