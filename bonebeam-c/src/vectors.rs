//! The vectors that objects compute with: NEON on AArch64, one lane elsewhere.
//!
//! Results have the same bits.

#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
mod own {
    use bonebeam::simd::Lanes;
    use fearless_simd::Neon;

    /// A vector of four lanes.
    pub(crate) type V = Lanes<Neon>;

    /// Zero in every lane.
    pub(crate) fn zero() -> V {
        // SAFETY: the target promises NEON.
        Lanes::new(unsafe { Neon::assume_supported() })
    }
}

#[cfg(not(all(target_arch = "aarch64", target_feature = "neon")))]
mod own {
    /// One lane.
    pub(crate) type V = f32;

    /// Zero.
    pub(crate) fn zero() -> V {
        0.0
    }
}

pub(crate) use own::{V, zero};

/// Lanes of a vector.
pub(crate) const LANES: usize = <V as bonebeam::simd::Vector>::LANES;
