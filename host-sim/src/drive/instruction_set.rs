//! The instruction sets that the kernels are compiled for, and the one that is used.

use clap::ValueEnum;
use fearless_simd::Level;
use serde::{Deserialize, Serialize};

/// An instruction set. The bits of a result do not depend on it, only the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum InstructionSet {
    /// x86-64's baseline, 4 lanes.
    #[cfg(target_arch = "x86_64")]
    Sse2,
    /// AVX2, 8 lanes.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512, 16 lanes.
    #[cfg(target_arch = "x86_64")]
    Avx512,
    /// AArch64's baseline, 4 lanes.
    #[cfg(target_arch = "aarch64")]
    Neon,
    /// No vectors: one lane, as on a microcontroller.
    Scalar,
}

impl InstructionSet {
    /// Those that this processor has, the fastest first.
    pub fn available() -> Vec<Self> {
        let mut sets = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            let level = Level::new();
            if level.as_avx512().is_some() {
                sets.push(InstructionSet::Avx512);
            }
            if level.as_avx2().is_some() {
                sets.push(InstructionSet::Avx2);
            }
            sets.push(InstructionSet::Sse2);
        }
        #[cfg(target_arch = "aarch64")]
        if Level::new().as_neon().is_some() {
            sets.push(InstructionSet::Neon);
        }
        sets.push(InstructionSet::Scalar);
        sets
    }

    /// The fastest that this processor has.
    pub fn detect() -> Self {
        Self::available()[0]
    }

    /// How people write it.
    pub fn name(self) -> &'static str {
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Sse2 => "SSE2",
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => "AVX-512",
            #[cfg(target_arch = "aarch64")]
            InstructionSet::Neon => "NEON",
            InstructionSet::Scalar => "one lane",
        }
    }
}

/// Work to be done with the vectors of an instruction set that is chosen at run time.
pub trait OverLanes {
    /// What comes of it.
    type Output;

    /// Does it with vectors like `zero`, a vector of zeros.
    fn run<V: bonebeam::simd::Vector>(self, zero: V) -> Self::Output;
}

impl InstructionSet {
    /// Does `work` with this instruction set's vectors, or one lane at a time where the processor
    /// does not have it.
    pub fn dispatch<W: OverLanes>(self, work: W) -> W::Output {
        use bonebeam::simd::Lanes;
        let level = Level::new();
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => {
                if let Some(simd) = level.as_avx512() {
                    return work.run(Lanes::new(simd));
                }
            }
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => {
                if let Some(simd) = level.as_avx2() {
                    return work.run(Lanes::new(simd));
                }
            }
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Sse2 => {
                if let Some(simd) = level.as_sse2() {
                    return work.run(Lanes::new(simd));
                }
            }
            #[cfg(target_arch = "aarch64")]
            InstructionSet::Neon => {
                if let Some(simd) = level.as_neon() {
                    return work.run(Lanes::new(simd));
                }
            }
            InstructionSet::Scalar => {}
        }
        work.run(0.0f32)
    }
}
