//! The core's only `unsafe` code: two instructions and three casts.
//!
//! Safe functions of stable Rust's `core` offer none of the five.
//!
//! - [`sqrt`]: `libm::sqrtf` is one instruction if the compiler's target promises it (x86-64, AArch64). On a
//!   Cortex-M it takes about a hundred, although the FPU has the instruction. Both round correctly, so the bits do
//!   not depend on the choice: the golden hash `sqrt` holds on a workstation and on a Cortex-M7.
//! - [`prefetch`]: requests the next sample's cache lines while a sample is computed. Lanes of beams are far apart
//!   in memory, which no hardware prefetcher detects. This saves some 5 % of the time of the in-vivo frame's lines,
//!   and changes no bit.
//! - [`vectors`]: a caller's complex memory is one slice of `num_complex` numbers for all stages. Arithmetic over
//!   lanes cannot be defined for that type outside its own crate, so the beamformers compute with
//!   [`ComplexVector`].
//! - [`parts`]: registers of real and imaginary parts in turn are stored as they are. As complex numbers, the compiler
//!   takes them apart first, which was a sixth of the time of the delay stage from I/Q.
//! - [`integers`]: a caller's real memory is one slice of `f32` for all stages. The surface detector stores
//!   integers in it.

use crate::complex_vector::ComplexVector;
use num_complex::Complex;

/// The same numbers as complex vectors.
#[inline(always)]
#[allow(unsafe_code)]
pub(crate) fn vectors<V>(complex: &mut [Complex<V>]) -> &mut [ComplexVector<V>] {
    const {
        assert!(size_of::<Complex<V>>() == size_of::<ComplexVector<V>>());
        assert!(align_of::<Complex<V>>() == align_of::<ComplexVector<V>>());
    }
    // SAFETY: both types are `repr(C)` with the same two fields in the same order. The slice is borrowed for as
    // long as the result.
    unsafe { core::slice::from_raw_parts_mut(complex.as_mut_ptr().cast(), complex.len()) }
}

/// The real and imaginary parts of complex numbers, in turn.
#[inline(always)]
#[allow(unsafe_code)]
pub(crate) fn parts(complex: &mut [Complex<f32>]) -> &mut [f32] {
    const {
        assert!(size_of::<Complex<f32>>() == 2 * size_of::<f32>());
        assert!(align_of::<Complex<f32>>() == align_of::<f32>());
    }
    // SAFETY: `Complex` is `repr(C)` with two fields of this type. The slice is borrowed for as long as the result, and
    // twice its length does not overflow, since its bytes are counted by a usize.
    unsafe { core::slice::from_raw_parts_mut(complex.as_mut_ptr().cast(), 2 * complex.len()) }
}

/// Integers that a caller's real memory can hold.
pub(crate) trait Integer: Copy {}
impl Integer for u8 {}
impl Integer for u16 {}
impl Integer for u32 {}
impl Integer for i32 {}

/// A caller's real memory as integers.
///
/// As many, twice as many of 16 bits, or four times as many of 8. Contents are arbitrary.
#[inline(always)]
#[allow(unsafe_code)]
pub(crate) fn integers<T: Integer>(real: &mut [f32]) -> &mut [T] {
    const {
        assert!(size_of::<f32>().is_multiple_of(size_of::<T>()));
        assert!(align_of::<T>() <= align_of::<f32>());
    }
    let count = real.len() * (size_of::<f32>() / size_of::<T>());
    // SAFETY: every pattern of bits is a value of both types, which have no padding. The slice has the same bytes, is
    // aligned, and is borrowed for as long as the result.
    unsafe { core::slice::from_raw_parts_mut(real.as_mut_ptr().cast(), count) }
}

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

/// The bytes of a cache line.
#[cfg(target_arch = "x86_64")]
const CACHE_LINE: usize = 64;

/// Prefetches the cache lines of `values`, if there is an instruction for it.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
#[allow(unsafe_code)]
pub(crate) fn prefetch(values: &[Complex<f32>]) {
    use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    for line in values.chunks(CACHE_LINE / size_of::<Complex<f32>>()) {
        // SAFETY: the instruction is part of every x86-64, writes nothing, and faults at no address;
        // this address is within the slice besides.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast()) }
    }
}

/// Prefetches the cache lines of `values`, if there is an instruction for it.
#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
pub(crate) fn prefetch(_: &[Complex<f32>]) {}
