//! A register of an instruction set, by the `fearless_simd` crate.

use super::{Dot, Mask, PARTIAL_SUMS, Vector};
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use fearless_simd::f32x16;
use fearless_simd::prelude::{
    ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdMask, SimdSplit,
};

/// One register of `f32`: 4 lanes with SSE2 and NEON, 8 with AVX2, 16 with AVX-512.
///
/// Whoever has one has proof that the processor has the instructions: see [`Lanes::new`].
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Lanes<S: Simd>(S::f32s);

/// One truth value a lane of [`Lanes`].
#[derive(Clone, Copy, Debug)]
pub struct LanesMask<S: Simd>(S::mask32s);

impl<S: Simd> Lanes<S> {
    /// Zero in every lane; `simd` is proof of the instruction set.
    #[inline(always)]
    pub fn new(simd: S) -> Self {
        Lanes(S::f32s::splat(simd, 0.0))
    }
}

impl<S: Simd> Vector for Lanes<S> {
    const LANES: usize = <S::f32s as SimdBase<S>>::LEN;
    // AVX-512 and NEON have 32, the rest of x86-64 has 16.
    const REGISTERS: usize = if Self::LANES == 16 || cfg!(target_arch = "aarch64") {
        32
    } else {
        16
    };
    type Mask = LanesMask<S>;

    #[inline(always)]
    fn vectorize<R>(self, f: impl FnOnce() -> R) -> R {
        self.0.token().vectorize(f)
    }
    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        Lanes(S::f32s::splat(self.0.token(), value))
    }
    #[inline(always)]
    fn lanes(&self) -> &[f32] {
        self.0.as_slice()
    }
    #[inline(always)]
    fn lanes_mut(&mut self) -> &mut [f32] {
        self.0.as_mut_slice()
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Lanes(self.0.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Lanes(self.0.abs())
    }
    #[inline(always)]
    fn less(self, other: Self) -> LanesMask<S> {
        LanesMask(self.0.simd_lt(other.0))
    }
    #[inline(always)]
    fn select(mask: LanesMask<S>, yes: Self, no: Self) -> Self {
        Lanes(mask.0.select(yes.0, no.0))
    }
    #[inline(always)]
    fn interleave(self, other: Self) -> (Self, Self) {
        let (first, second) = self.0.interleave(other.0);
        (Lanes(first), Lanes(second))
    }
    #[inline(always)]
    fn mask(self, f: impl Fn(usize) -> bool) -> LanesMask<S> {
        let mut bits = 0;
        for k in 0..Self::LANES {
            bits |= u64::from(f(k)) << k;
        }
        LanesMask(S::mask32s::from_bitmask(self.0.token(), bits))
    }
}

impl<S: Simd> Dot for Lanes<S> {
    #[inline(always)]
    fn blended_dot<const BLOCKS: usize>(
        self,
        x: &[[f32; PARTIAL_SUMS]; BLOCKS],
        row: &[[f32; PARTIAL_SUMS]; BLOCKS],
        next: &[[f32; PARTIAL_SUMS]; BLOCKS],
        weight: f32,
    ) -> f32 {
        // One register of AVX-512, two of AVX2, four of SSE2 and NEON.
        let simd = self.0.token();
        let load = |values: &[f32; PARTIAL_SUMS]| f32x16::from_slice(simd, values);
        let mut a = f32x16::splat(simd, 0.0);
        let mut b = a;
        for ((x, row), next) in x.iter().zip(row).zip(next) {
            let x = load(x);
            a += x * load(row);
            b += x * load(next);
        }
        let (low, high) = (a + f32x16::splat(simd, weight) * (b - a)).split();
        let (low, high) = (low + high).split();
        let s = low + high;
        let s = s.as_slice();
        (s[0] + s[2]) + (s[1] + s[3])
    }
}

impl<S: Simd> Mask for LanesMask<S> {
    #[inline(always)]
    fn all(self) -> bool {
        self.0.all_true()
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any_true()
    }
    #[inline(always)]
    fn lane(self, k: usize) -> bool {
        self.0.to_bitmask() >> k & 1 == 1
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, rhs: Self) -> Self {
        Lanes(self.0 + rhs.0)
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, rhs: Self) -> Self {
        Lanes(self.0 - rhs.0)
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, rhs: Self) -> Self {
        Lanes(self.0 * rhs.0)
    }
}

impl<S: Simd> Div for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn div(self, rhs: Self) -> Self {
        Lanes(self.0 / rhs.0)
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lanes(-self.0)
    }
}

impl<S: Simd> BitAnd for LanesMask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, rhs: Self) -> Self {
        LanesMask(self.0 & rhs.0)
    }
}

impl<S: Simd> BitOr for LanesMask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, rhs: Self) -> Self {
        LanesMask(self.0 | rhs.0)
    }
}

impl<S: Simd> Not for LanesMask<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        LanesMask(!self.0)
    }
}
