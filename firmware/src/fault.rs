//! A stack that overflows is a fault, and what becomes of a fault: a line that tells it, and the end of the
//! emulation. A product would reset.
#![allow(
    unsafe_code,
    reason = "a fault leaves a stack that no function may use"
)]

use core::arch::naked_asm;

use cortex_m::peripheral::MPU;
use cortex_m_semihosting::debug::EXIT_FAILURE;
use cortex_m_semihosting::hprintln;

use crate::exit;

/// Bytes below the stack's end that are guarded: more than any frame has. The end is a multiple of it.
const GUARD: usize = 64 << 10;

/// Makes what lies below the stack a region that nothing may access: an overflow is a fault at once, whether
/// or not there is memory. It takes none.
pub fn guard_stack(mpu: &mut MPU) {
    const NUMBER: u32 = 0;
    const VALID: u32 = 1 << 4;
    const NEVER_EXECUTED: u32 = 1 << 28;
    const ENABLED: u32 = 1;
    const REST_AS_WITHOUT: u32 = 1 << 2;
    let size = GUARD.trailing_zeros() - 1;
    let begin = cortex_m_stack::stack().end.addr() - GUARD;
    // SAFETY: nothing of the program lies below the stack, which the memory maps say; no access is its
    // permission 0.
    unsafe {
        mpu.rbar.write(begin as u32 | VALID | NUMBER);
        mpu.rasr.write(NEVER_EXECUTED | size << 1 | ENABLED);
        mpu.ctrl.write(REST_AS_WITHOUT | ENABLED);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Takes the stack from its beginning on, since what is left of it may be nothing, and goes on to
/// [`faulted`].
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

/// Tells of a fault at which the stack reached down to `pointer`.
extern "C" fn faulted(pointer: usize) -> ! {
    let end = cortex_m_stack::stack().end.addr();
    match end.checked_sub(pointer) {
        None | Some(0) => hprintln!("error: a hard fault"),
        Some(bytes) => hprintln!("error: the stack overflowed by {bytes} bytes"),
    }
    exit(EXIT_FAILURE)
}
