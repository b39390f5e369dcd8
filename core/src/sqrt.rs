//! The square root of one f32.
//!
//! `libm::sqrtf` is one instruction where the compiler's targets promise it (x86-64, AArch64), and
//! about a hundred on a Cortex-M, whose FPU has the instruction as well. No safe function of stable
//! Rust's `core` reaches that one, so this module holds the core's only `unsafe`.
//!
//! Both round correctly, so the bits do not depend on which is taken: the golden hash `sqrt` is met
//! by the workstation's and by the Cortex-M7's.

/// `√x`, correctly rounded; NaN for a negative `x`.
#[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
#[inline(always)]
pub(crate) fn sqrt(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// `√x`, correctly rounded; NaN for a negative `x`.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[inline(always)]
#[allow(unsafe_code)]
pub(crate) fn sqrt(x: f32) -> f32 {
    let bits: u32;
    // SAFETY: the hard-float ABI promises an FPU, and every FPU of Arm's has VSQRT.F32. The
    // registers that change are declared; memory and stack stay untouched. By way of a core
    // register, since the compiler does not let `asm!` name this target's float ones as operands.
    unsafe {
        core::arch::asm!(
            "vmov s0, {bits}",
            "vsqrt.f32 s0, s0",
            "vmov {bits}, s0",
            bits = inout(reg) x.to_bits() => bits,
            out("s0") _,
            options(pure, nomem, nostack),
        );
    }
    f32::from_bits(bits)
}
