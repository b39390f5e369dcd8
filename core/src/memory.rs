//! Memory of all stages: its size and its layout.
//!
//! Each stage has a `const` function of its sizes or parameters that returns a [`Need`]: the numbers of real and
//! complex numbers that the stage works in. Each stage takes a [`Scratch`]: a slice of real and a slice of complex
//! numbers. A [`Memory`] owns both for sizes that are known at compile time, for instance in a `static`.
//!
//! ```
//! use bonebeam::beamform::{Parameters, Sizes, Workspace};
//! use bonebeam::memory::{Memory, Need};
//!
//! const SIZES: Sizes = Parameters { temporal_half_window: 2, ..Parameters::DEFAULT }.sizes(16);
//! const NEED: Need = SIZES.need();
//! // On a target, this is a `static`.
//! let mut memory = Memory::<{ NEED.real }, { NEED.complex }>::new();
//! let workspace = Workspace::new(0.0f32, SIZES, memory.scratch())?;
//! assert_eq!(workspace.sizes(), SIZES);
//! # Ok::<(), bonebeam::Error>(())
//! ```
//!
//! If the sizes are known only at run time, a `Scratch` borrows any two slices:
//!
//! ```
//! use bonebeam::prelude::*;
//! use bonebeam::beamform::Parameters;
//!
//! # let sizes = Parameters::DEFAULT.sizes(48);
//! let need = sizes.need();
//! let mut real = vec![0.0f32; need.real];
//! let mut complex = vec![Complex::new(0.0, 0.0); need.complex];
//! let scratch = Scratch { real: &mut real, complex: &mut complex };
//! ```

use crate::simd::split_front;
use crate::{Complex, Error};

/// Numbers of a step of an image or a bone map; `progress` is called between two.
pub(crate) const STEP: usize = 4096;

/// The size of a stage's memory, in numbers. Saturates at `usize::MAX`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Need {
    /// Number of real numbers, or vectors of them.
    pub real: usize,
    /// Number of complex numbers, or vectors of them.
    pub complex: usize,
}

impl Need {
    /// A need of real and complex numbers.
    #[inline(always)]
    pub const fn new(real: usize, complex: usize) -> Self {
        Need { real, complex }
    }

    /// A need of real numbers only.
    #[inline(always)]
    pub const fn real(real: usize) -> Self {
        Need::new(real, 0)
    }

    /// The sum of two needs, for stages at work at the same time.
    ///
    /// ```
    /// use bonebeam::memory::Need;
    ///
    /// let (a, b) = (Need { real: 5, complex: 2 }, Need { real: 3, complex: 4 });
    /// assert_eq!(a.and(b), Need { real: 8, complex: 6 });
    /// assert_eq!(a.or(b), Need { real: 5, complex: 4 });
    /// ```
    #[inline(always)]
    pub const fn and(self, other: Need) -> Self {
        Need::new(
            self.real.saturating_add(other.real),
            self.complex.saturating_add(other.complex),
        )
    }

    /// The larger need of each kind, for stages that run one after the other.
    pub const fn or(self, other: Need) -> Self {
        Need::new(
            larger(self.real, other.real),
            larger(self.complex, other.complex),
        )
    }
}

const fn larger(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

/// Memory that a stage works in, at least its [`Need`].
///
/// Contents are irrelevant. `V` is `f32`, or the vector of a stage that computes several lanes at once.
#[derive(Debug)]
pub struct Scratch<'a, V = f32> {
    /// Real numbers.
    pub real: &'a mut [V],
    /// Complex numbers.
    pub complex: &'a mut [Complex<V>],
}

impl<'a, V> Scratch<'a, V> {
    /// Memory in two slices.
    #[inline(always)]
    pub const fn new(real: &'a mut [V], complex: &'a mut [Complex<V>]) -> Self {
        Scratch { real, complex }
    }

    /// The same memory, borrowed for one call.
    #[inline(always)]
    pub fn reborrow(&mut self) -> Scratch<'_, V> {
        Scratch::new(self.real, self.complex)
    }

    /// Refuses slices that are shorter than `need`.
    #[inline(always)]
    pub(crate) fn check(&self, need: Need) -> Result<(), Error> {
        at_least("real memory", self.real.len(), need.real)?;
        at_least("complex memory", self.complex.len(), need.complex)
    }

    /// Splits `need` off the front; the rest remains in `self`.
    ///
    /// # Errors
    /// [`Error::Length`] if one of the slices is shorter. Nothing is then split off.
    #[inline(always)]
    pub fn take(&mut self, need: Need) -> Result<Scratch<'a, V>, Error> {
        self.check(need)?;
        Ok(Scratch::new(
            split_front(&mut self.real, need.real),
            split_front(&mut self.complex, need.complex),
        ))
    }
}

/// Refuses a slice that is shorter than a stage needs.
#[inline(always)]
fn at_least(name: &'static str, actual: usize, expected: usize) -> Result<(), Error> {
    if actual >= expected {
        return Ok(());
    }
    Err(Error::length(name, actual, expected))
}

/// Owned memory of `REAL` real and `COMPLEX` complex numbers, for a `static`.
#[derive(Clone, Debug)]
pub struct Memory<const REAL: usize, const COMPLEX: usize> {
    real: [f32; REAL],
    complex: [Complex<f32>; COMPLEX],
}

impl<const REAL: usize, const COMPLEX: usize> Memory<REAL, COMPLEX> {
    /// Size in bytes: 4 for each real number, 8 for each complex one.
    pub const BYTES: usize = size_of::<Self>();

    /// Memory filled with zeros.
    pub const fn new() -> Self {
        Memory {
            real: [0.0; REAL],
            complex: [Complex::new(0.0, 0.0); COMPLEX],
        }
    }

    /// Borrows the memory as a [`Scratch`].
    #[inline]
    pub fn scratch(&mut self) -> Scratch<'_> {
        Scratch::new(&mut self.real, &mut self.complex)
    }
}

impl<const REAL: usize, const COMPLEX: usize> Default for Memory<REAL, COMPLEX> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn needs_that_cannot_be_counted_are_the_most_that_can() {
        let most = Need::real(usize::MAX);
        let some = Need::new(1, 2);
        assert_eq!(
            (most.and(some).real, most.and(some).complex),
            (usize::MAX, 2)
        );
    }

    #[test]
    fn memory_is_split_in_order_and_too_much_is_refused() {
        let mut memory = Memory::<3, 2>::new();
        let mut scratch = memory.scratch();
        let some = Need::new(2, 1);
        let taken = scratch.take(some).unwrap();
        taken.real.fill(1.0);
        taken.complex.fill(Complex::I);
        let refused = scratch.take(some).unwrap_err();
        assert_eq!(refused.to_string(), "real memory has length 1, expected 2");
        let refused = scratch.take(Need::new(1, 2)).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "complex memory has length 1, expected 2"
        );
        assert_eq!((scratch.real.len(), scratch.complex.len()), (1, 1));
        assert_eq!(memory.real, [1.0, 1.0, 0.0]);
        assert_eq!(memory.complex, [Complex::I, Complex::ZERO]);
    }
}
