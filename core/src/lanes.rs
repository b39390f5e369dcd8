//! Lanes: `W` independent outputs side by side, one in each lane.
//!
//! Every operation acts on each lane alone and no operation mixes lanes, so a lane's bits do not
//! depend on `W` nor on its neighbours. `W = 1` is plain scalar arithmetic for a microcontroller;
//! on a workstation the compiler turns the loops over `W` into vector instructions.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use num_complex::Complex;

/// `W` real numbers, one a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Lanes<const W: usize>(pub [f32; W]);

/// `W` complex numbers, one a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplexLanes<const W: usize> {
    /// Real parts.
    pub re: Lanes<W>,
    /// Imaginary parts.
    pub im: Lanes<W>,
}

impl<const W: usize> Lanes<W> {
    /// Zero in every lane.
    pub const ZERO: Self = Lanes([0.0; W]);

    /// The same value in every lane.
    #[inline(always)]
    pub const fn splat(value: f32) -> Self {
        Lanes([value; W])
    }

    /// `f` of each lane.
    #[inline(always)]
    pub fn map(mut self, f: impl Fn(f32) -> f32) -> Self {
        for k in 0..W {
            self.0[k] = f(self.0[k]);
        }
        self
    }

    /// The square root of each lane, correctly rounded.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(libm::sqrtf)
    }

    /// `yes` where `mask` is true, `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: [bool; W], yes: Self, mut no: Self) -> Self {
        for k in 0..W {
            if mask[k] {
                no.0[k] = yes.0[k];
            }
        }
        no
    }
}

impl<const W: usize> Add for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, rhs: Self) -> Self {
        for k in 0..W {
            self.0[k] += rhs.0[k];
        }
        self
    }
}

impl<const W: usize> Sub for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, rhs: Self) -> Self {
        for k in 0..W {
            self.0[k] -= rhs.0[k];
        }
        self
    }
}

impl<const W: usize> Mul for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, rhs: Self) -> Self {
        for k in 0..W {
            self.0[k] *= rhs.0[k];
        }
        self
    }
}

impl<const W: usize> Div for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, rhs: Self) -> Self {
        for k in 0..W {
            self.0[k] /= rhs.0[k];
        }
        self
    }
}

impl<const W: usize> Neg for Lanes<W> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

impl<const W: usize> AddAssign for Lanes<W> {
    #[inline(always)]
    fn add_assign(&mut self, rhs: Self) {
        *self = *self + rhs;
    }
}

impl<const W: usize> SubAssign for Lanes<W> {
    #[inline(always)]
    fn sub_assign(&mut self, rhs: Self) {
        *self = *self - rhs;
    }
}

impl<const W: usize> ComplexLanes<W> {
    /// Zero in every lane.
    pub const ZERO: Self = ComplexLanes {
        re: Lanes::ZERO,
        im: Lanes::ZERO,
    };

    /// Which lanes are neither NaN nor infinite.
    #[inline(always)]
    pub fn is_finite(&self) -> [bool; W] {
        core::array::from_fn(|k| self.re.0[k].is_finite() && self.im.0[k].is_finite())
    }

    /// The number in lane `k`.
    #[inline(always)]
    pub fn lane(&self, k: usize) -> Complex<f32> {
        Complex::new(self.re.0[k], self.im.0[k])
    }

    /// Puts a number into lane `k`.
    #[inline(always)]
    pub fn set_lane(&mut self, k: usize, value: Complex<f32>) {
        self.re.0[k] = value.re;
        self.im.0[k] = value.im;
    }
}

impl<const W: usize> Add for ComplexLanes<W> {
    type Output = Self;
    #[inline(always)]
    fn add(self, rhs: Self) -> Self {
        ComplexLanes {
            re: self.re + rhs.re,
            im: self.im + rhs.im,
        }
    }
}

impl<const W: usize> Sub for ComplexLanes<W> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, rhs: Self) -> Self {
        ComplexLanes {
            re: self.re - rhs.re,
            im: self.im - rhs.im,
        }
    }
}

/// What the linear algebra needs of a number: real lanes for a real symmetric matrix, complex
/// lanes for a Hermitian one. The same code then serves both.
pub trait Scalar<const W: usize>: Copy + Add<Output = Self> + Sub<Output = Self> {
    /// Zero in every lane.
    const ZERO: Self;

    /// A real number in every lane.
    fn from_real(value: Lanes<W>) -> Self;

    /// The real part.
    fn real(self) -> Lanes<W>;

    /// `self · rhs*`, in that order: `re·re + im·im`, `im·re − re·im`.
    fn mul_conj(self, rhs: Self) -> Self;

    /// `self · rhs`: `re·re − im·im`, `re·im + im·re`.
    fn mul(self, rhs: Self) -> Self;

    /// `self* · rhs` with a complex right side.
    fn conj_mul_complex(self, rhs: ComplexLanes<W>) -> ComplexLanes<W>;

    /// Each lane times a real number.
    fn scale(self, factor: Lanes<W>) -> Self;

    /// `|self|²`: `re·re + im·im`.
    fn norm_sqr(self) -> Lanes<W>;

    /// The complex number of the same value.
    fn complex(self) -> ComplexLanes<W>;

    /// `yes` where `mask` is true, `no` elsewhere.
    fn select(mask: [bool; W], yes: Self, no: Self) -> Self;
}

impl<const W: usize> Scalar<W> for Lanes<W> {
    const ZERO: Self = Lanes([0.0; W]);

    #[inline(always)]
    fn from_real(value: Lanes<W>) -> Self {
        value
    }
    #[inline(always)]
    fn real(self) -> Lanes<W> {
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
    fn conj_mul_complex(self, rhs: ComplexLanes<W>) -> ComplexLanes<W> {
        ComplexLanes {
            re: self * rhs.re,
            im: self * rhs.im,
        }
    }
    #[inline(always)]
    fn scale(self, factor: Lanes<W>) -> Self {
        self * factor
    }
    #[inline(always)]
    fn norm_sqr(self) -> Lanes<W> {
        self * self
    }
    #[inline(always)]
    fn complex(self) -> ComplexLanes<W> {
        ComplexLanes {
            re: self,
            im: Lanes::ZERO,
        }
    }
    #[inline(always)]
    fn select(mask: [bool; W], yes: Self, no: Self) -> Self {
        Lanes::select(mask, yes, no)
    }
}

impl<const W: usize> Scalar<W> for ComplexLanes<W> {
    const ZERO: Self = ComplexLanes {
        re: Lanes([0.0; W]),
        im: Lanes([0.0; W]),
    };

    #[inline(always)]
    fn from_real(value: Lanes<W>) -> Self {
        ComplexLanes {
            re: value,
            im: Lanes::ZERO,
        }
    }
    #[inline(always)]
    fn real(self) -> Lanes<W> {
        self.re
    }
    #[inline(always)]
    fn mul_conj(self, rhs: Self) -> Self {
        ComplexLanes {
            re: self.re * rhs.re + self.im * rhs.im,
            im: self.im * rhs.re - self.re * rhs.im,
        }
    }
    #[inline(always)]
    fn mul(self, rhs: Self) -> Self {
        ComplexLanes {
            re: self.re * rhs.re - self.im * rhs.im,
            im: self.re * rhs.im + self.im * rhs.re,
        }
    }
    #[inline(always)]
    fn conj_mul_complex(self, rhs: ComplexLanes<W>) -> ComplexLanes<W> {
        rhs.mul_conj(self)
    }
    #[inline(always)]
    fn scale(self, factor: Lanes<W>) -> Self {
        ComplexLanes {
            re: self.re * factor,
            im: self.im * factor,
        }
    }
    #[inline(always)]
    fn norm_sqr(self) -> Lanes<W> {
        self.re * self.re + self.im * self.im
    }
    #[inline(always)]
    fn complex(self) -> ComplexLanes<W> {
        self
    }
    #[inline(always)]
    fn select(mask: [bool; W], yes: Self, no: Self) -> Self {
        ComplexLanes {
            re: Lanes::select(mask, yes.re, no.re),
            im: Lanes::select(mask, yes.im, no.im),
        }
    }
}
