//! Complex vectors, and the number types of the linear algebra.

use super::Vector;
pub use crate::complex_vector::ComplexVector;
use core::ops::{Add, Sub};
use num_complex::Complex;

impl<V: Vector> ComplexVector<V> {
    /// A complex vector of real and imaginary parts.
    #[inline(always)]
    pub fn new(re: V, im: V) -> Self {
        ComplexVector { re, im }
    }

    /// Complex vector of a real one.
    #[inline(always)]
    pub fn from_real(re: V) -> Self {
        ComplexVector::new(re, re.zero())
    }

    /// Zero in every lane.
    #[inline(always)]
    pub fn zero(self) -> Self {
        Self::from_real(self.re.zero())
    }

    /// Lanes whose value is neither NaN nor infinite.
    #[inline(always)]
    pub fn is_finite(self) -> V::Mask {
        self.re.is_finite() & self.im.is_finite()
    }

    /// The number in lane `k`; 0 beyond the last.
    #[inline(always)]
    pub fn lane(&self, k: usize) -> Complex<f32> {
        match (self.re.lanes().get(k), self.im.lanes().get(k)) {
            (Some(&re), Some(&im)) => Complex::new(re, im),
            _ => Complex::new(0.0, 0.0),
        }
    }

    /// Stores a number in lane `k`; does nothing past the last lane.
    #[inline(always)]
    pub fn set_lane(&mut self, k: usize, value: Complex<f32>) {
        if let (Some(re), Some(im)) = (
            self.re.lanes_mut().get_mut(k),
            self.im.lanes_mut().get_mut(k),
        ) {
            (*re, *im) = (value.re, value.im);
        }
    }

    /// Divides each lane by a real number.
    #[inline(always)]
    pub fn divide(self, divisor: V) -> Self {
        ComplexVector::new(self.re / divisor, self.im / divisor)
    }
}

impl<V: Vector> Add for ComplexVector<V> {
    type Output = Self;
    #[inline(always)]
    fn add(self, rhs: Self) -> Self {
        ComplexVector::new(self.re + rhs.re, self.im + rhs.im)
    }
}

impl<V: Vector> Sub for ComplexVector<V> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, rhs: Self) -> Self {
        ComplexVector::new(self.re - rhs.re, self.im - rhs.im)
    }
}

/// Number type of the linear algebra: real or complex.
///
/// A real vector serves real symmetric matrices, a complex one Hermitian matrices, with the same code.
pub trait Scalar<V: Vector>: Copy + Send + Sync + Add<Output = Self> + Sub<Output = Self> {
    /// Number of registers of a number.
    const PARTS: usize;

    /// Number with the given real part.
    fn from_real(value: V) -> Self;

    /// The real part.
    fn real(self) -> V;

    /// The complex conjugate.
    fn conj(self) -> Self;

    /// `self · rhs*`, in that order: `re·re + im·im`, `im·re − re·im`.
    fn mul_conj(self, rhs: Self) -> Self;

    /// `self · rhs`: `re·re − im·im`, `re·im + im·re`.
    fn mul(self, rhs: Self) -> Self;

    /// `self* · rhs` with a complex right side.
    fn conj_mul_complex(self, rhs: ComplexVector<V>) -> ComplexVector<V>;

    /// `self · rhs` with a complex right side.
    fn mul_complex(self, rhs: ComplexVector<V>) -> ComplexVector<V>;

    /// Multiplies each lane by a real number.
    fn scale(self, factor: V) -> Self;

    /// `|self|²`: `re·re + im·im`.
    fn norm_sqr(self) -> V;

    /// The same value as a complex number.
    fn complex(self) -> ComplexVector<V>;

    /// `yes` where `mask` is true, `no` elsewhere.
    fn select(mask: V::Mask, yes: Self, no: Self) -> Self;
}

impl<V: Vector> Scalar<V> for V {
    const PARTS: usize = 1;

    #[inline(always)]
    fn from_real(value: V) -> Self {
        value
    }
    #[inline(always)]
    fn real(self) -> V {
        self
    }
    #[inline(always)]
    fn conj(self) -> Self {
        self
    }
    #[inline(always)]
    fn mul_conj(self, rhs: Self) -> Self {
        self * rhs
    }
    #[inline(always)]
    fn mul(self, rhs: Self) -> Self {
        self * rhs
    }
    #[inline(always)]
    fn conj_mul_complex(self, rhs: ComplexVector<V>) -> ComplexVector<V> {
        ComplexVector::new(self * rhs.re, self * rhs.im)
    }
    #[inline(always)]
    fn mul_complex(self, rhs: ComplexVector<V>) -> ComplexVector<V> {
        rhs.scale(self)
    }
    #[inline(always)]
    fn scale(self, factor: V) -> Self {
        self * factor
    }
    #[inline(always)]
    fn norm_sqr(self) -> V {
        self * self
    }
    #[inline(always)]
    fn complex(self) -> ComplexVector<V> {
        ComplexVector::from_real(self)
    }
    #[inline(always)]
    fn select(mask: V::Mask, yes: Self, no: Self) -> Self {
        Vector::select(mask, yes, no)
    }
}

impl<V: Vector> Scalar<V> for ComplexVector<V> {
    const PARTS: usize = 2;

    #[inline(always)]
    fn from_real(value: V) -> Self {
        ComplexVector::from_real(value)
    }
    #[inline(always)]
    fn real(self) -> V {
        self.re
    }
    #[inline(always)]
    fn conj(self) -> Self {
        ComplexVector::new(self.re, -self.im)
    }
    #[inline(always)]
    fn mul_conj(self, rhs: Self) -> Self {
        ComplexVector::new(
            self.re * rhs.re + self.im * rhs.im,
            self.im * rhs.re - self.re * rhs.im,
        )
    }
    #[inline(always)]
    fn mul(self, rhs: Self) -> Self {
        ComplexVector::new(
            self.re * rhs.re - self.im * rhs.im,
            self.re * rhs.im + self.im * rhs.re,
        )
    }
    #[inline(always)]
    fn conj_mul_complex(self, rhs: ComplexVector<V>) -> ComplexVector<V> {
        rhs.mul_conj(self)
    }
    #[inline(always)]
    fn mul_complex(self, rhs: ComplexVector<V>) -> ComplexVector<V> {
        self.mul(rhs)
    }
    #[inline(always)]
    fn scale(self, factor: V) -> Self {
        ComplexVector::new(self.re * factor, self.im * factor)
    }
    #[inline(always)]
    fn norm_sqr(self) -> V {
        self.re * self.re + self.im * self.im
    }
    #[inline(always)]
    fn complex(self) -> ComplexVector<V> {
        self
    }
    #[inline(always)]
    fn select(mask: V::Mask, yes: Self, no: Self) -> Self {
        ComplexVector::new(
            Vector::select(mask, yes.re, no.re),
            Vector::select(mask, yes.im, no.im),
        )
    }
}
