//! Registers of an instruction set, by the `fearless_simd` crate.

use super::{Dot, Gather, Mask, PARTIAL_SUMS, Term, Vector, copy};
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use fearless_simd::prelude::{
    ExtractToken, Select, Simd, SimdBase, SimdCombine, SimdFloat, SimdMask, SimdSplit,
};
use fearless_simd::{f32x4, f32x8, f32x16};

/// One register of `f32`: 4 lanes with SSE2 and NEON, 8 with AVX2, 16 with AVX-512.
///
/// A value of this type is proof that the processor has the instructions: see [`Lanes::new`].
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Lanes<S: Simd>(S::f32s);

/// One truth value for each lane of [`Lanes`].
#[derive(Clone, Copy, Debug)]
pub struct LanesMask<S: Simd>(S::mask32s);

impl<S: Simd> Lanes<S> {
    /// Zero in every lane; `simd` is proof of the instruction set.
    ///
    /// [`dispatch!`](crate::dispatch) makes the token after asking the processor. If
    /// the target promises the instructions, a token needs no check:
    ///
    /// ```
    /// # #[cfg(target_arch = "x86_64")]
    /// # {
    /// use bonebeam::simd::{Lanes, Vector};
    ///
    /// let simd = fearless_simd::Level::baseline().as_sse2();
    /// let zero = Lanes::new(simd.expect("x86-64 has SSE2"));
    /// assert_eq!(zero.lanes(), [0.0; 4]);
    /// # }
    /// ```
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
    fn truncate(self, integers: &mut [i32]) {
        let whole = self.0.to_int::<S::i32s>();
        match integers.get_mut(..Self::LANES) {
            Some(integers) => whole.store_slice(integers),
            None => {
                for (integer, &lane) in integers.iter_mut().zip(whole.as_slice()) {
                    *integer = lane;
                }
            }
        }
    }
    #[inline(always)]
    fn interleave(self, other: Self) -> (Self, Self) {
        let (first, second) = self.0.interleave(other.0);
        (Lanes(first), Lanes(second))
    }
    #[inline(always)]
    fn deinterleave(self, other: Self) -> (Self, Self) {
        let (even, odd) = self.0.deinterleave(other.0);
        (Lanes(even), Lanes(odd))
    }
    #[inline(always)]
    fn reverse(self) -> Self {
        Lanes(self.0.reverse())
    }
    #[inline(always)]
    fn slide(self, next: Self, by: usize) -> Self {
        let (a, b) = (self.0, next.0);
        // A constant at compile time, so that one branch is left.
        Lanes(match by {
            0 => a,
            1 => a.slide::<1>(b),
            2 => a.slide::<2>(b),
            3 => a.slide::<3>(b),
            4 => a.slide::<4>(b),
            5 => a.slide::<5>(b),
            6 => a.slide::<6>(b),
            7 => a.slide::<7>(b),
            8 => a.slide::<8>(b),
            9 => a.slide::<9>(b),
            10 => a.slide::<10>(b),
            11 => a.slide::<11>(b),
            12 => a.slide::<12>(b),
            13 => a.slide::<13>(b),
            14 => a.slide::<14>(b),
            15 => a.slide::<15>(b),
            _ => b,
        })
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
    fn blended_dots<'a, const BLOCKS: usize, const LINES: usize>(
        self,
        term: impl Fn(usize) -> Option<Term<'a, BLOCKS, LINES>>,
        dots: [&mut [f32]; LINES],
    ) -> Option<()> {
        let simd = self.0.token();
        if Self::LANES == 4 {
            return in_fours(simd, term, dots);
        }
        let (mut sums, y) = (two_sums(simd, &term, 0)?, two_sums(simd, &term, 8)?);
        for line in 0..LINES {
            sums[line] = neighbours(sums[line], y[line]);
        }
        for (dots, sums) in dots.into_iter().zip(sums) {
            if let Some(dots) = dots.get_mut(..PARTIAL_SUMS) {
                sums.store_slice(dots);
            }
        }
        Some(())
    }
}

/// Dot products in registers of four: each four is stored before the next is read, so that few numbers are kept.
#[inline(always)]
fn in_fours<'a, S: Simd, const BLOCKS: usize, const LINES: usize>(
    simd: S,
    term: impl Fn(usize) -> Option<Term<'a, BLOCKS, LINES>>,
    dots: [&mut [f32]; LINES],
) -> Option<()> {
    for four in 0..PARTIAL_SUMS / 4 {
        let (x, y) = (
            pair_sums(simd, &term, 4 * four)?,
            pair_sums(simd, &term, 4 * four + 2)?,
        );
        for line in 0..LINES {
            let sums = x[line].unzip_low(y[line]) + x[line].unzip_high(y[line]);
            if let Some(dots) = dots[line].get_mut(4 * four..4 * four + 4) {
                sums.store_slice(dots);
            }
        }
    }
    Some(())
}

/// Two sums for each of the products `k` and `k + 1`.
#[inline(always)]
fn pair_sums<'a, S: Simd, const BLOCKS: usize, const LINES: usize>(
    simd: S,
    term: &impl Fn(usize) -> Option<Term<'a, BLOCKS, LINES>>,
    k: usize,
) -> Option<[f32x4<S>; LINES]> {
    let mut x = quarter_sums(simd, term(k)?);
    let y = quarter_sums(simd, term(k + 1)?);
    for line in 0..LINES {
        x[line] = x[line].unzip_low(y[line]) + x[line].unzip_high(y[line]);
    }
    Some(x)
}

/// The partial sums of each line's dot product, those of every fourth term added up.
#[inline(always)]
fn quarter_sums<S: Simd, const BLOCKS: usize, const LINES: usize>(
    simd: S,
    term: Term<BLOCKS, LINES>,
) -> [f32x4<S>; LINES] {
    partial_sums(simd, term).map(
        #[inline(always)]
        |sums| {
            let (a, b) = sums.split();
            let (a, b) = (a + b).split();
            a + b
        },
    )
}

// The sums of sixteen products take one register of AVX-512, two of AVX2, four of SSE2 and NEON each. They are added
// up for two, four, eight and sixteen products together, separately for each line. Halves in separate registers need
// no move between lanes.

/// Sums 2j and 2j + 1 added, those of `x` first.
#[inline(always)]
fn neighbours<S: Simd>(x: f32x16<S>, y: f32x16<S>) -> f32x16<S> {
    x.unzip_low(y) + x.unzip_high(y)
}

/// Sums j and j + 4 of each half added, those of `x` first.
#[inline(always)]
fn in_quarters<S: Simd>(x: f32x16<S>, y: f32x16<S>) -> f32x16<S> {
    let ((a, b), (c, d)) = (x.split(), y.split());
    let ((a, e), (b, f)) = (a.split(), b.split());
    let ((c, g), (d, h)) = (c.split(), d.split());
    a.combine(b).combine(c.combine(d)) + e.combine(f).combine(g.combine(h))
}

/// Sums j and j + 8 added, those of `x` first.
#[inline(always)]
fn in_halves<S: Simd>(x: f32x16<S>, y: f32x16<S>) -> f32x16<S> {
    let ((a, b), (c, d)) = (x.split(), y.split());
    a.combine(c) + b.combine(d)
}

/// Two sums for each of the products from the k-th on.
#[inline(always)]
fn two_sums<'a, S: Simd, const BLOCKS: usize, const LINES: usize>(
    simd: S,
    term: &impl Fn(usize) -> Option<Term<'a, BLOCKS, LINES>>,
    k: usize,
) -> Option<[f32x16<S>; LINES]> {
    let (mut x, y) = (four_sums(simd, term, k)?, four_sums(simd, term, k + 4)?);
    for line in 0..LINES {
        x[line] = neighbours(x[line], y[line]);
    }
    Some(x)
}

/// Four sums for each of the products from the k-th on.
#[inline(always)]
fn four_sums<'a, S: Simd, const BLOCKS: usize, const LINES: usize>(
    simd: S,
    term: &impl Fn(usize) -> Option<Term<'a, BLOCKS, LINES>>,
    k: usize,
) -> Option<[f32x16<S>; LINES]> {
    let (mut x, y) = (eight_sums(simd, term, k)?, eight_sums(simd, term, k + 2)?);
    for line in 0..LINES {
        x[line] = in_quarters(x[line], y[line]);
    }
    Some(x)
}

/// Eight sums for each of the products from the k-th on.
#[inline(always)]
fn eight_sums<'a, S: Simd, const BLOCKS: usize, const LINES: usize>(
    simd: S,
    term: &impl Fn(usize) -> Option<Term<'a, BLOCKS, LINES>>,
    k: usize,
) -> Option<[f32x16<S>; LINES]> {
    let (mut x, y) = (
        partial_sums(simd, term(k)?),
        partial_sums(simd, term(k + 1)?),
    );
    for line in 0..LINES {
        x[line] = in_halves(x[line], y[line]);
    }
    Some(x)
}

/// The partial sums of each line's dot product.
#[inline(always)]
fn partial_sums<S: Simd, const BLOCKS: usize, const LINES: usize>(
    simd: S,
    term: Term<BLOCKS, LINES>,
) -> [f32x16<S>; LINES] {
    let mut sums = products(simd, &term, 0);
    for block in 1..BLOCKS {
        let products = products(simd, &term, block);
        for line in 0..LINES {
            sums[line] += products[line];
        }
    }
    sums
}

/// A block's samples of each line times its coefficients.
#[inline(always)]
fn products<S: Simd, const BLOCKS: usize, const LINES: usize>(
    simd: S,
    term: &Term<BLOCKS, LINES>,
    block: usize,
) -> [f32x16<S>; LINES] {
    let row = f32x16::from_slice(simd, &term.row[block]);
    let next = f32x16::from_slice(simd, &term.next[block]);
    let coefficients = row + f32x16::splat(simd, term.weight) * (next - row);
    let mut products = [coefficients; LINES];
    for (product, samples) in products.iter_mut().zip(&term.samples) {
        *product = f32x16::from_slice(simd, &samples[block]) * coefficients;
    }
    products
}

impl<S: Simd> Gather for Lanes<S> {
    #[inline(always)]
    fn gather<const FOURS: usize>(
        self,
        block: impl Fn(usize) -> Option<[[f32; 4]; FOURS]>,
    ) -> Option<[Self; FOURS]> {
        let simd = self.0.token();
        let mut registers = [self; FOURS];
        let a = block(0)?;
        if Self::LANES == 4 {
            for f in 0..FOURS {
                copy(&a[f], registers[f].lanes_mut());
            }
            return Some(registers);
        }
        let b = block(1)?;
        if Self::LANES == 8 {
            for f in 0..FOURS {
                copy(two(simd, &a[f], &b[f]).as_slice(), registers[f].lanes_mut());
            }
            return Some(registers);
        }
        let (c, d) = (block(2)?, block(3)?);
        for f in 0..FOURS {
            let four = two(simd, &a[f], &b[f]).combine(two(simd, &c[f], &d[f]));
            copy(four.as_slice(), registers[f].lanes_mut());
        }
        Some(registers)
    }
}

/// Two blocks side by side.
#[inline(always)]
fn two<S: Simd>(simd: S, a: &[f32; 4], b: &[f32; 4]) -> f32x8<S> {
    f32x4::from_slice(simd, a).combine(f32x4::from_slice(simd, b))
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
        k < S::f32s::LEN && self.0.to_bitmask() >> k & 1 == 1
    }
}

/// Operators of two operands, lane by lane.
macro_rules! operators {
    ($($kind:ident $operator:ident $function:ident $symbol:tt),*) => {$(
        impl<S: Simd> $operator for $kind<S> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, rhs: Self) -> Self {
                $kind(self.0 $symbol rhs.0)
            }
        }
    )*};
}

operators!(Lanes Add add +, Lanes Sub sub -, Lanes Mul mul *, Lanes Div div /);
operators!(LanesMask BitAnd bitand &, LanesMask BitOr bitor |);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Lanes(-self.0)
    }
}

impl<S: Simd> Not for LanesMask<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        LanesMask(!self.0)
    }
}
