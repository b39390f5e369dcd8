//! Comparison of the core's results with references that another crate has.

use bonebeam::beamform::Parameters;
use bonebeam::geometry::Active;
use ndarray::{Array2, Array3};
use num_complex::Complex;
use serde::Serialize;

use crate::Result;
use crate::delay::DelayStage;
use crate::image::{BModeImage, PixelGrid};
use crate::phase_symmetry;
use bonebeam_files::{BeamformedLines, ChannelData};

/// The contract's bound on 1 − e₁ᴴRe₁/λ₁ for ill-conditioned e₁.
pub const RAYLEIGH: f64 = 1e-3;

/// A program's references: each compares results of the core with its own.
#[derive(Debug)]
#[allow(clippy::type_complexity)]
pub struct References {
    /// Aligned samples `[beam, sample, element]` at an output rate.
    ///
    /// The first beam of the samples and a step follow: each `step`-th beam is compared.
    pub aligned:
        fn(&ChannelData, &DelayStage<'_>, f64, &Array3<Complex<f32>>, usize, usize) -> Bits,
    /// Lines `[beam, sample]` by several methods.
    pub lines: fn(&Aligned<'_>, &[Lines<'_>]) -> Result<Vec<(Bits, Bound)>>,
    /// A B-mode image of lines: dynamic range, grid, and whether it has the median.
    pub image: fn(&BModeImage, &BeamformedLines, f64, &PixelGrid, bool) -> (Bits, Bound),
    /// The phase symmetry map of an image.
    pub map: fn(&Array2<f32>, &Array2<f32>, &phase_symmetry::Parameters) -> (Bits, Bound),
}

/// Lines `[beam, sample]`, and the parameters that made them.
pub type Lines<'a> = (&'a Array2<Complex<f32>>, Parameters);

/// Aligned samples whose lines are compared.
pub struct Aligned<'a> {
    /// The samples, `[beam, sample, element]`.
    pub x: &'a Array3<Complex<f32>>,
    /// The active elements of a beam at a sample.
    pub active: &'a (dyn Fn(usize, usize) -> Active + Sync),
    /// One beam in this many goes through the f32 reference.
    pub every_f32: usize,
    /// One beam in this many goes through the f64 reference.
    pub every_f64: usize,
}

/// Comparison of one result of the core with its references.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Name of the result.
    pub what: String,
    /// The comparison with the f32 reference.
    pub bits: Bits,
    /// The comparison with the f64 reference, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Bound>,
}

/// Values compared with the f32 reference bit by bit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Bits {
    /// How many values were compared.
    pub compared: usize,
    /// Number of values that differ.
    pub different: usize,
}

/// Values compared with the f64 reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Bound {
    /// How many values were compared.
    pub compared: usize,
    /// The largest error, relative to the same value as `bound`.
    pub largest_error: f64,
    /// The error allowed.
    pub bound: f64,
    /// Number of values left out as ill-conditioned.
    pub ill_conditioned: usize,
    /// The largest error of the values left out.
    pub ill_conditioned_error: f64,
    /// The largest 1 − e₁ᴴRe₁/λ₁ of values that depend on the first eigenvector.
    ///
    /// It is bounded in place of their error.
    pub eigenvector_shortfall: f64,
}

impl Check {
    /// Whether all bits are equal and all errors within their bounds.
    pub fn passed(&self) -> bool {
        let holds = self.error.as_ref().is_none_or(Bound::holds);
        self.bits.compared > 0 && self.bits.different == 0 && holds
    }
}

impl Bound {
    /// Whether something was compared and nothing exceeds its bound.
    pub fn holds(&self) -> bool {
        let eigenvectors = self.eigenvector_shortfall <= RAYLEIGH;
        self.compared > 0 && self.largest_error <= self.bound && eigenvectors
    }
}

impl Bits {
    /// Compares real numbers.
    pub fn real(a: &[f32], b: &[f32]) -> Self {
        Bits::count(a.iter().zip(b), a.len().max(b.len()), |a, b| {
            a.to_bits() == b.to_bits()
        })
    }

    /// Compares complex numbers.
    pub fn complex(a: &[Complex<f32>], b: &[Complex<f32>]) -> Self {
        Bits::count(a.iter().zip(b), a.len().max(b.len()), |a, b| {
            a.re.to_bits() == b.re.to_bits() && a.im.to_bits() == b.im.to_bits()
        })
    }

    /// Values that one of the two lacks count as different.
    fn count<'a, T: 'a>(
        pairs: impl Iterator<Item = (&'a T, &'a T)>,
        compared: usize,
        same: impl Fn(&T, &T) -> bool,
    ) -> Self {
        let alike = pairs.filter(|(a, b)| same(a, b)).count();
        Bits {
            compared,
            different: compared - alike,
        }
    }

    /// The sums of both counts.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Bits {
            compared: self.compared + other.compared,
            different: self.different + other.different,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_differ_by_sign_of_zero_and_by_length() {
        let count = |a: &[f32], b: &[f32]| Bits::real(a, b).different;
        assert_eq!(count(&[0.0, 1.0], &[0.0, 1.0]), 0);
        assert_eq!(count(&[0.0, 1.0], &[-0.0, 1.0]), 1);
        assert_eq!(count(&[0.0, 1.0], &[0.0]), 1);
        assert_eq!(count(&[0.0], &[0.0, 1.0, 2.0]), 2);
    }

    #[test]
    fn a_check_passes_only_where_something_was_compared_and_all_of_it_agrees() {
        let check = |compared, different, error| Check {
            what: String::new(),
            bits: Bits {
                compared,
                different,
            },
            error,
        };
        let bound = |compared, largest_error| {
            Some(Bound {
                compared,
                largest_error,
                bound: 1e-4,
                ..Bound::default()
            })
        };
        assert!(check(5, 0, None).passed() && check(5, 0, bound(3, 1e-4)).passed());
        assert!(!check(0, 0, None).passed() && !check(5, 1, None).passed());
        assert!(!check(5, 0, bound(3, 1.1e-4)).passed() && !check(5, 0, bound(0, 0.0)).passed());
        assert!(!check(5, 0, bound(3, f64::NAN)).passed());
    }
}
