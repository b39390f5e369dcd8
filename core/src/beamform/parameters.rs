//! What a beamformer can be asked for.

use super::methods::Method;
use super::sizes::Sizes;
use crate::Error;

/// Parameters of a [`Beamformer`].
///
/// The default is the core's own: MV, `K = 0`, `Δ = 0.05`, `L = M/2`. (The command `host-sim
/// beamform` takes rank 1 where it is asked for no method.)
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// The beamformer.
    pub method: Method,
    /// `K`: the covariance is averaged over the samples `n−K..=n+K`.
    pub temporal_half_window: usize,
    /// `Δ`: `Δ/L·tr(R)` is added to the diagonal. Below about 1e-4 the rounding of f32 decides;
    /// a covariance that is singular in f32 takes the full eigensolver, and no eigenvalue counts for
    /// less than `2⁻²⁴` of the trace.
    pub diagonal_loading: f32,
    /// `L = max(1, floor(ratio·active elements))`, in `(0, 1]`.
    pub subaperture_ratio: f64,
}

impl Parameters {
    /// The default, for a `const`.
    pub const DEFAULT: Self = Parameters {
        method: Method::Mv,
        temporal_half_window: 0,
        diagonal_loading: 0.05,
        subaperture_ratio: 0.5,
    };
}

impl Default for Parameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A beamformer with valid parameters.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Beamformer {
    parameters: Parameters,
}

impl Beamformer {
    /// Validates the parameters.
    ///
    /// # Errors
    /// [`Error::Parameter`] for `β` outside `(0, 1]`, a rank of 0, steps outside `1..=64`, `Δ` that is negative, not finite
    /// or above 1e6, a subaperture ratio outside `(0, 1]`.
    pub fn new(parameters: Parameters) -> Result<Self, Error> {
        parameters.method.check()?;
        if !(parameters.diagonal_loading >= 0.0 && parameters.diagonal_loading <= 1e6) {
            return Err(Error::Parameter {
                name: "diagonal_loading",
                value: parameters.diagonal_loading as f64,
                expected: "0 to 1e6",
            });
        }
        if !(parameters.subaperture_ratio > 0.0 && parameters.subaperture_ratio <= 1.0) {
            return Err(Error::Parameter {
                name: "subaperture ratio",
                value: parameters.subaperture_ratio,
                expected: "above 0, at most 1 (the subaperture cannot exceed the active aperture)",
            });
        }
        Ok(Beamformer { parameters })
    }

    /// The parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// What the memory is for where up to `elements` are active: nothing for DAS.
    pub fn sizes(&self, elements: usize) -> Sizes {
        if self.parameters.method.direct().is_some() {
            return Sizes::default();
        }
        Sizes {
            elements,
            subaperture: self.subaperture(elements),
            temporal_half_window: self.parameters.temporal_half_window,
        }
    }

    /// `L` for `count ≥ 1` active elements.
    pub fn subaperture(&self, count: usize) -> usize {
        let length = libm::floor(self.parameters.subaperture_ratio * count as f64) as usize;
        // Beyond 2⁵³ the product may round up.
        length.min(count).max(1)
    }
}
