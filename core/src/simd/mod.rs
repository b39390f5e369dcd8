//! Vectors whose lanes hold independent outputs.
//!
//! Every operation acts on each lane alone, so a lane's bits depend neither on the width nor on other lanes.
//! [`f32`] is a vector of one lane, for a microcontroller. `Lanes` (feature `simd`) is a register of an instruction
//! set that the processor was found to have. Kernels are written once, over [`Vector`].
//!
//! # Source of a vector
//!
//! A vector is proof that the processor has its instructions, so no function makes one from nothing. The caller
//! provides one: an entry takes it from memory made of vectors, or has an argument `zero`. Inside,
//! [`Vector::splat`] makes every other vector from an existing one.
//!
//! The first vector is one of three:
//!
//! - `0.0f32`, one lane;
//! - from `dispatch!`, which asks the processor at run time (features `simd` and `std`);
//! - from `Lanes::new` with a token of the `fearless_simd` crate, for a target that promises the instructions
//!   (feature `simd`).
//!
//! # Rules of inlining
//!
//! A function is compiled for an instruction set only if it is inlined into one that is. A remaining call passes
//! registers through memory and makes a call for each operation. It is ten times slower, and no test shows it.
//! Therefore:
//!
//! 1. A kernel is generic over [`Vector`] and marked `#[inline(always)]`, as is everything that it calls, down to
//!    the last operation. Closures that touch a vector carry the attribute, too.
//! 2. A kernel is entered through [`Vector::vectorize`], which compiles the inlined code for the vector's
//!    instruction set: `zero.vectorize(#[inline(always)] || kernel(zero, …))`. An entry encloses long work: a
//!    strip, a line, a block of samples.
//! 3. A stage of a kernel that should be compiled separately is an `#[inline(never)]` function that enters anew by
//!    rule 2. Its comment gives the reason: the compiler then knows that its slices do not overlap; or a
//!    microcontroller's few registers all belong to the stage; or several kernels share the stage.
//! 4. Work on single numbers (a filter's taps, a lane by itself) is left to the compiler.

mod complex;
#[cfg(feature = "simd")]
mod dispatch;
mod dot;
mod gather;
#[cfg(feature = "simd")]
mod lanes;
mod memory;

pub use complex::ComplexVector;
pub(crate) use complex::Scalar;
#[cfg(feature = "simd")]
pub use dispatch::{InstructionSet, Token, UnknownInstructionSet};
pub(crate) use dot::{Dot, PARTIAL_SUMS, Term};
pub(crate) use gather::Gather;
#[cfg(feature = "simd")]
pub use lanes::Lanes;
pub(crate) use memory::{MOST_LANES, copy, get, get_mut, load, load_at, split_front, transpose};

/// [`Vector::vectorize`] with an expression that is inlined.
macro_rules! vectorize {
    ($vector:expr, $work:expr) => {
        $vector.vectorize(
            #[inline(always)]
            || $work,
        )
    };
}
pub(crate) use vectorize;

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// A vector of real numbers: [`f32`], or `Lanes` with the feature `simd`.
///
/// No other type implements the trait. A vector knows its instruction set, so every further vector is made from an
/// existing one: see [`Vector::splat`].
///
/// ```
/// use bonebeam::simd::Vector;
///
/// /// Takes the magnitude of whole vectors of samples.
/// #[inline(always)]
/// fn magnitudes<V: Vector>(zero: V, samples: &mut [f32]) {
///     for samples in samples.chunks_exact_mut(V::LANES) {
///         let mut lanes = zero;
///         lanes.lanes_mut().copy_from_slice(samples);
///         samples.copy_from_slice(lanes.abs().lanes());
///     }
/// }
///
/// let mut samples = [1.0, -2.0, 3.0];
/// let zero = 0.0f32;
/// zero.vectorize(
///     #[inline(always)]
///     || magnitudes(zero, &mut samples),
/// );
/// assert_eq!(samples, [1.0, 2.0, 3.0]);
/// ```
pub trait Vector:
    Dot
    + Gather
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Number of lanes.
    const LANES: usize;

    /// Number of registers, which sets the block sizes of kernels.
    const REGISTERS: usize;

    /// One truth value for each lane.
    type Mask: Mask;

    /// Runs `f` compiled for this vector's instruction set.
    ///
    /// Only code that is inlined into `f` is compiled so: write `zero.vectorize(#[inline(always)] || kernel(…))`.
    fn vectorize<R>(self, f: impl FnOnce() -> R) -> R;

    /// A vector of this kind with `value` in every lane.
    fn splat(self, value: f32) -> Self;

    /// The lanes as a slice.
    fn lanes(&self) -> &[f32];

    /// The lanes as a mutable slice.
    fn lanes_mut(&mut self) -> &mut [f32];

    /// The square root of each lane, correctly rounded.
    fn sqrt(self) -> Self;

    /// The magnitude of each lane.
    fn abs(self) -> Self;

    /// True where `self < other`; false for a NaN.
    fn less(self, other: Self) -> Self::Mask;

    /// `yes` where `mask` is true, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Writes the integer part of each lane to `integers`.
    ///
    /// Magnitudes are below 2³¹. If `integers` is shorter than a vector, only its entries are written.
    fn truncate(self, integers: &mut [i32]);

    /// Interleaves two vectors: `a₀ b₀ a₁ b₁ …`, first half and second half.
    ///
    /// Only this function, its inverse, [`Vector::reverse`] and [`Vector::slide`] move values between lanes. None
    /// computes with several lanes.
    fn interleave(self, other: Self) -> (Self, Self);

    /// The inverse of [`Vector::interleave`]: values at even and at odd indices.
    ///
    /// The indices count through `self` and then `other`.
    fn deinterleave(self, other: Self) -> (Self, Self);

    /// The lanes in reverse order.
    fn reverse(self) -> Self;

    /// Lanes `by..by + LANES` of the concatenation `[self, next]`.
    ///
    /// `by` is at most the number of lanes.
    fn slide(self, next: Self, by: usize) -> Self;

    /// True in the lanes `k` for which `f(k)` is true.
    fn mask(self, f: impl Fn(usize) -> bool) -> Self::Mask;

    /// True where the number is neither NaN nor infinite.
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        !(self.splat(f32::MAX).less(self.abs())) & !self.is_nan()
    }

    /// True where the number is a NaN.
    #[inline(always)]
    fn is_nan(self) -> Self::Mask {
        let zero = self.splat(0.0);
        let one = self.splat(1.0);
        // Only a NaN is neither below 1 nor above 0.
        !(self.less(one) | zero.less(self))
    }

    /// Zero in every lane.
    #[inline(always)]
    fn zero(self) -> Self {
        self.splat(0.0)
    }
}

/// One truth value for each lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Whether every lane is true.
    fn all(self) -> bool;

    /// Whether any lane is true.
    fn any(self) -> bool;

    /// Value of lane `k`. Past the last lane: false, or the only lane's value.
    fn lane(self, k: usize) -> bool;
}

impl Vector for f32 {
    const LANES: usize = 1;
    const REGISTERS: usize = 32;
    type Mask = bool;

    #[inline(always)]
    fn vectorize<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }
    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        value
    }
    #[inline(always)]
    fn lanes(&self) -> &[f32] {
        core::slice::from_ref(self)
    }
    #[inline(always)]
    fn lanes_mut(&mut self) -> &mut [f32] {
        core::slice::from_mut(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        crate::instructions::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        libm::fabsf(self)
    }
    #[inline(always)]
    fn less(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        f32::is_finite(self)
    }
    #[inline(always)]
    fn truncate(self, integers: &mut [i32]) {
        if let [integer, ..] = integers {
            *integer = self as i32;
        }
    }
    #[inline(always)]
    fn interleave(self, other: Self) -> (Self, Self) {
        (self, other)
    }
    #[inline(always)]
    fn deinterleave(self, other: Self) -> (Self, Self) {
        (self, other)
    }
    #[inline(always)]
    fn reverse(self) -> Self {
        self
    }
    #[inline(always)]
    fn slide(self, next: Self, by: usize) -> Self {
        if by == 0 { self } else { next }
    }
    #[inline(always)]
    fn mask(self, f: impl Fn(usize) -> bool) -> bool {
        f(0)
    }
}

impl Mask for bool {
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn lane(self, _: usize) -> bool {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex;
    use std::vec::Vec;

    fn lanes_beyond_the_last_are_zero_and_stay_so<V: Vector>(zero: V) {
        let mut vector = ComplexVector::from_real(zero.splat(2.0));
        for k in [V::LANES, V::LANES + 3, 64, usize::MAX] {
            vector.set_lane(k, Complex::new(5.0, 5.0));
            assert_eq!(vector.lane(k), Complex::new(0.0, 0.0));
            assert!(V::LANES == 1 || !zero.mask(|_| true).lane(k));
        }
        for k in 0..V::LANES {
            assert_eq!(vector.lane(k), Complex::new(2.0, 0.0));
        }
        // As many integers as fit.
        for length in 0..V::LANES + 2 {
            let mut integers = std::vec![7; length];
            vector.re.truncate(&mut integers);
            for (k, &integer) in integers.iter().enumerate() {
                assert_eq!(integer, if k < V::LANES { 2 } else { 7 });
            }
        }
    }

    /// Numbers of both signs, of both zeros, and those at the ends of the range.
    const NUMBERS: [f32; 16] = [
        1.5,
        f32::NAN,
        -0.0,
        f32::INFINITY,
        -3.0,
        0.0,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        1e-40,
        7.25,
        -0.1,
        1e20,
        f32::MIN_POSITIVE,
        2.0,
        -9.0,
    ];

    /// The numbers from the k-th on, in turn.
    fn from<V: Vector>(zero: V, k: usize) -> V {
        let mut vector = zero;
        for (lane, number) in vector.lanes_mut().iter_mut().enumerate() {
            *number = NUMBERS[(k + lane) % NUMBERS.len()];
        }
        vector
    }

    fn mask_bits<V: Vector>(mask: V::Mask) -> Vec<bool> {
        (0..V::LANES).map(|k| mask.lane(k)).collect()
    }

    /// Each operation is that of the numbers by themselves, lane by lane.
    fn lanes_are_numbers<V: Vector>(zero: V) {
        let pairs = (0..NUMBERS.len()).flat_map(|i| (0..NUMBERS.len()).map(move |j| (i, j)));
        for (i, j) in pairs.step_by(crate::step(23)) {
            let (a, b) = (from(zero, i), from(zero, j));
            let pairs = || a.lanes().iter().zip(b.lanes()).map(|(&a, &b)| (a, b));
            let assert_lanes = |found: V, f: &dyn Fn(f32, f32) -> f32| {
                for (&found, (a, b)) in found.lanes().iter().zip(pairs()) {
                    let number = f(a, b);
                    let same = found.to_bits() == number.to_bits();
                    assert!(
                        same || found.is_nan() && number.is_nan(),
                        "{a}, {b}: {found}"
                    );
                }
            };
            assert_lanes(a + b, &|a, b| a + b);
            assert_lanes(a - b, &|a, b| a - b);
            assert_lanes(a * b, &|a, b| a * b);
            assert_lanes(a / b, &|a, b| a / b);
            assert_lanes(-a, &|a, _| -a);
            assert_lanes(a.abs(), &|a, _| a.abs());
            assert_lanes(a.sqrt(), &|a, _| a.sqrt());
            assert_lanes(a.splat(2.5), &|_, _| 2.5);
            assert_lanes(a.zero(), &|_, _| 0.0);
            let less = a.less(b);
            assert_lanes(V::select(less, a, b), &|a, b| if a < b { a } else { b });
            let assert_mask = |found: V::Mask, f: &dyn Fn(f32, f32) -> bool| {
                let expected: Vec<bool> = pairs().map(|(a, b)| f(a, b)).collect();
                assert_eq!(mask_bits::<V>(found), expected);
                assert_eq!(found.all(), expected.iter().all(|&x| x));
                assert_eq!(found.any(), expected.iter().any(|&x| x));
            };
            let positive = zero.less(a);
            assert_mask(less, &|a, b| a < b);
            assert_mask(!less, &|a, b| a >= b || a.is_nan() || b.is_nan());
            assert_mask(less & positive, &|a, b| a < b && a > 0.0);
            assert_mask(less | positive, &|a, b| a < b || a > 0.0);
            assert_mask(a.is_nan(), &|a, _| a.is_nan());
            assert_mask(a.is_finite(), &|a, _| a.is_finite());
            let both = ComplexVector::new(a, b);
            assert_mask(both.is_finite(), &|a, b| a.is_finite() && b.is_finite());
        }
        assert!(!zero.mask(|_| false).any() && zero.mask(|_| true).all());
        for k in 0..V::LANES {
            let only = zero.mask(|lane| lane == k);
            assert_eq!(only.all(), V::LANES == 1);
            assert!(only.any() && (0..V::LANES).all(|lane| only.lane(lane) == (lane == k)));
        }
    }

    /// Operations that move numbers between lanes follow the documentation.
    fn lanes_move<V: Vector>(zero: V) {
        let counted = |first: usize| {
            let mut vector = zero;
            for (k, number) in vector.lanes_mut().iter_mut().enumerate() {
                *number = (first + k) as f32;
            }
            vector
        };
        let (a, b) = (counted(0), counted(V::LANES));
        let (first, second) = a.interleave(b);
        let turns: Vec<f32> = (0..V::LANES)
            .flat_map(|k| [k as f32, (V::LANES + k) as f32])
            .collect();
        assert_eq!([first.lanes(), second.lanes()].concat(), turns);
        let (even, odd) = first.deinterleave(second);
        assert_eq!((even.lanes(), odd.lanes()), (a.lanes(), b.lanes()));
        let reverse = (0..V::LANES).rev().map(|k| k as f32).collect::<Vec<f32>>();
        assert_eq!(a.reverse().lanes(), reverse);
        for by in 0..=V::LANES {
            assert_eq!(a.slide(b, by).lanes(), counted(by).lanes(), "by {by}");
        }
        let mut square = [zero; MOST_LANES];
        for (k, row) in square.iter_mut().enumerate() {
            *row = counted(100 * k);
        }
        transpose(&mut square);
        for (k, column) in square[..V::LANES].iter().enumerate() {
            let expected = (0..V::LANES).map(|row| (100 * row + k) as f32);
            assert_eq!(column.lanes(), expected.collect::<Vec<f32>>());
        }
    }

    /// Blocks of two fours each, from places in any order; and none if one is missing.
    fn blocks_are_gathered<V: Vector>(zero: V) {
        let block =
            |k: usize| [0, 1].map(|f| [0, 1, 2, 3].map(|j| (100 * (7 - k) + 10 * f + j) as f32));
        let registers = zero.gather(|k| Some(block(k))).unwrap();
        for (f, register) in registers.iter().enumerate() {
            for (lane, &number) in register.lanes().iter().enumerate() {
                assert_eq!(number, block(lane / 4)[f][lane % 4], "{f}, lane {lane}");
            }
        }
        for none in 0..V::LANES.div_ceil(4) {
            let registers = zero.gather(|k| (k != none).then(|| block(k)));
            assert!(registers.is_none(), "without block {none}");
        }
    }

    /// Sixteen products of two lines, whose sums are whole numbers, so that no order rounds.
    fn dot_products<V: Vector>(zero: V) {
        let number = |seed: usize| ((seed * 7 + seed / 5 * 3) % 11) as f32 - 5.0;
        let block = |seed: usize| {
            [0, 1, 2].map(|block| std::array::from_fn(|j| number(seed + 16 * block + j)))
        };
        let samples: Vec<[[[f32; PARTIAL_SUMS]; 3]; 2]> = (0..PARTIAL_SUMS)
            .map(|k| [block(k), block(3 * k + 50)])
            .collect();
        let tables: Vec<[[[f32; PARTIAL_SUMS]; 3]; 2]> = (0..PARTIAL_SUMS)
            .map(|k| [block(5 * k + 9), block(2 * k + 31)])
            .collect();
        let term = |k: usize| Term {
            samples: samples[k].each_ref(),
            row: &tables[k][0],
            next: &tables[k][1],
            weight: 0.25 * (k % 5) as f32,
        };
        let mut dots = [[0.0; PARTIAL_SUMS]; 2];
        let [first, second] = dots.each_mut();
        zero.blended_dots(|k| Some(term(k)), [first, second])
            .expect("all terms");
        for k in 0..PARTIAL_SUMS {
            let Term {
                row, next, weight, ..
            } = term(k);
            let coefficients = row.as_flattened().iter().zip(next.as_flattened());
            let coefficients = coefficients.map(|(row, next)| row + weight * (next - row));
            for line in 0..2 {
                let samples = samples[k][line].as_flattened().iter();
                let dot: f32 = samples.zip(coefficients.clone()).map(|(x, c)| x * c).sum();
                assert_eq!(dots[line][k], dot, "line {line}, product {k}");
            }
        }
        for none in 0..PARTIAL_SUMS {
            let (mut first, mut second) = ([0.0; PARTIAL_SUMS], [0.0; PARTIAL_SUMS]);
            let dots =
                zero.blended_dots(|k| (k != none).then(|| term(k)), [&mut first, &mut second]);
            assert!(dots.is_none(), "without term {none}");
        }
    }

    fn lanes_side_by_side<V: Vector>(zero: V) {
        lanes_beyond_the_last_are_zero_and_stay_so(zero);
        lanes_are_numbers(zero);
        lanes_move(zero);
        blocks_are_gathered(zero);
        dot_products(zero);
    }

    #[test]
    fn lanes_are_numbers_side_by_side() {
        lanes_side_by_side(0.0f32);
        #[cfg(feature = "simd")]
        for set in InstructionSet::available() {
            crate::dispatch!(set, zero => lanes_side_by_side(zero));
        }
    }
}
