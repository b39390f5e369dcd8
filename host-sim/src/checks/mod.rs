//! The core's results held against the two references: the same bits as the f32 one, and within
//! the contract's bounds of the f64 one.

pub mod beamform;
pub mod delay;
pub mod image;
pub mod phase_symmetry;

use num_complex::Complex;
use serde::Serialize;

/// How one result of the core compares with its references.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// What was computed.
    pub what: String,
    /// The comparison with the f32 reference.
    pub bits: Bits,
    /// The comparison with the f64 reference, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Bound>,
}

/// Values compared with the f32 reference bit by bit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Bits {
    /// How many values were compared.
    pub compared: usize,
    /// How many of them differ.
    pub different: usize,
}

/// Values compared with the f64 reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Bound {
    /// How many values were compared.
    pub compared: usize,
    /// The largest error, relative to what `bound` is relative to.
    pub largest_error: f64,
    /// The error allowed.
    pub bound: f64,
    /// How many values were left out because their problem is ill-conditioned.
    pub ill_conditioned: usize,
    /// The largest error of these.
    pub ill_conditioned_error: f64,
}

impl Check {
    /// Whether every bit is the same and every error within its bound.
    pub fn passed(&self) -> bool {
        let holds = self.error.as_ref().is_none_or(Bound::holds);
        self.bits.compared > 0 && self.bits.different == 0 && holds
    }
}

impl Bound {
    /// Whether something was compared and no error exceeds the bound.
    pub fn holds(&self) -> bool {
        self.compared > 0 && self.largest_error <= self.bound
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

    /// What one of the two lacks differs.
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

    fn add(self, other: Self) -> Self {
        Bits {
            compared: self.compared + other.compared,
            different: self.different + other.different,
        }
    }
}
